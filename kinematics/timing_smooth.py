"""Accelerations that build up over a time: a profile averaged over a moving window.

The averaged profile is at every moment at the mean of where the other was during the window. It
runs the same way, ends one window later, and its speed is a mean of the other's speeds. Its jerk
is the change of the other's acceleration over the window, divided by the window: at most twice
the largest acceleration per window, and once where the other does not go from speeding up
straight to braking.
"""

from __future__ import annotations

from kinematics.profiles import Phase, Profile


def averaged(profile: Profile, window_s: float) -> Profile:
    """Return the mean of a profile without jerk over the time just past, in phases of its own."""
    rest = Phase(window_s, 0.0, 0.0, 0.0, 0.0)
    leads = [*profile.phases, rest._replace(distance=profile.distance)]
    lags = [rest, *profile.phases]
    phases = []
    lead = lag = 0
    lead_s = lag_s = distance = 0.0
    shortest_s = 1e-12 * (profile.duration_s + window_s)
    while lead < len(leads) and lag < len(lags):
        left_s, left_lag_s = leads[lead].duration_s - lead_s, lags[lag].duration_s - lag_s
        step_s = min(left_s, left_lag_s)
        if step_s > shortest_s:
            phase = _mean(step_s, distance, leads[lead], lead_s, lags[lag], lag_s, window_s)
            phases.append(phase)
            distance = min(phase.state(step_s)[0], profile.distance)
        lead_s, lag_s = lead_s + step_s, lag_s + step_s
        if left_s - step_s <= shortest_s:
            lead, lead_s = lead + 1, 0.0
        if left_lag_s - step_s <= shortest_s:
            lag, lag_s = lag + 1, 0.0
    return Profile(tuple(phases), profile.distance)


def _mean(
    step_s: float,
    distance: float,
    lead: Phase,
    lead_s: float,
    lag: Phase,
    lag_s: float,
    window_s: float,
) -> Phase:
    """Return the phase in which the window's two ends stay within a phase each."""
    ahead = lead.distance + lead_s * (lead.speed + 0.5 * lead_s * lead.acceleration)
    behind = lag.distance + lag_s * (lag.speed + 0.5 * lag_s * lag.acceleration)
    faster = lead.speed + lead_s * lead.acceleration
    slower = lag.speed + lag_s * lag.acceleration
    return Phase(
        step_s,
        distance,
        max((ahead - behind) / window_s, 0.0),
        (faster - slower) / window_s,
        (lead.acceleration - lag.acceleration) / window_s,
    )
