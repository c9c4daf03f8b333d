"""Profiles from rest to rest: distance, speed and acceleration along a path at every time.

Distances are in any unit (mm, rad, a share of a path), times in s. A profile consists of phases of
constant jerk. `trapezoid` limits speed and acceleration, `averaged` lets accelerations build up.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import accumulate
from operator import itemgetter
from typing import NamedTuple

from kinematics.errors import KinematicsError, not_negative, positive
from kinematics.frames.numbers import last_that


class Phase(NamedTuple):
    """A period of constant jerk, and the state at its beginning."""

    duration_s: float
    distance: float
    speed: float
    acceleration: float
    jerk: float

    def state(self, since_s: float) -> tuple[float, float, float]:
        """Return distance, speed and acceleration at a time after the phase began."""
        _, distance, speed, acceleration, jerk = self
        half = 0.5 * since_s
        return (
            distance + since_s * (speed + half * (acceleration + since_s * jerk / 3.0)),
            speed + since_s * (acceleration + half * jerk),
            acceleration + since_s * jerk,
        )

    @property
    def steady(self) -> bool:
        """Whether the speed is constant."""
        return self.acceleration == 0.0 == self.jerk


@dataclass(frozen=True, slots=True)
class Profile:
    """Phases end to end over a distance, from rest to rest; it never runs backwards."""

    phases: tuple[Phase, ...]
    distance: float
    ends_s: tuple[float, ...] = field(init=False, repr=False, compare=False)
    """When each phase ends."""
    duration_s: float = field(init=False, compare=False)

    def __post_init__(self) -> None:
        ends = tuple(accumulate(map(_DURATION, self.phases)))
        object.__setattr__(self, "ends_s", ends)
        object.__setattr__(self, "duration_s", ends[-1] if ends else 0.0)

    def at(self, t_s: float) -> tuple[float, float, float]:
        """Return distance, speed and acceleration at a time; at the ends and beyond, rest."""
        if t_s <= 0.0:
            return 0.0, 0.0, 0.0
        if t_s >= self.duration_s:
            return self.distance, 0.0, 0.0
        index = bisect_right(self.ends_s, t_s)
        began_s = self.ends_s[index - 1] if index else 0.0
        distance, speed, acceleration = self.phases[index].state(t_s - began_s)
        following = index + 1
        far = self.phases[following].distance if following < len(self.phases) else self.distance
        return min(distance, far), max(speed, 0.0), acceleration

    def when(self, distance: float) -> float:
        """Return the time at which a distance is reached, within the profile's ends."""
        if distance <= 0.0:
            return 0.0
        if distance >= self.distance:
            return self.duration_s
        index = bisect_right(self.phases, distance, key=_PLACE) - 1
        began_s = self.ends_s[index - 1] if index else 0.0
        return began_s + since_s(self.phases[index], distance)


_DURATION, _PLACE = itemgetter(0), itemgetter(1)


def trapezoid(distance: float, speed: float, acceleration: float) -> Profile:
    """Return the quickest profile under a speed and an acceleration, of which one may be infinite.

    If the distance is too short to reach the speed, its shape is a triangle.
    """
    length = not_negative("a profile's distance", distance)
    for name, limit in (("speed", speed), ("acceleration", acceleration)):
        positive(f"a profile's {name}", limit, endless=True)
    if math.inf == speed == acceleration:
        raise KinematicsError("speed and acceleration must not both be infinite")
    if length == 0.0:
        return Profile((), 0.0)
    if acceleration == math.inf:
        return Profile((Phase(length / speed, 0.0, speed, 0.0, 0.0),), length)
    top = min(speed, math.sqrt(length * acceleration))
    ramp_s = top / acceleration
    ramp = min(0.5 * top * ramp_s, 0.5 * length)
    level_s = max(length / top - ramp_s, 0.0)
    phases = (
        Phase(ramp_s, 0.0, 0.0, acceleration, 0.0),
        Phase(level_s, ramp, top, 0.0, 0.0),
        Phase(ramp_s, length - ramp, top, -acceleration, 0.0),
    )
    return Profile(tuple(phase for phase in phases if phase.duration_s > 0.0), length)


# Accelerations that build up over a time: a profile averaged over a moving window.
#
# At every time, the averaged profile is at the mean of the original's positions during the window.
# It covers the same path, ends one window later, and its speed is a mean of the original's speeds.
# Its jerk is the change of the original's acceleration over the window, divided by the window: at
# most twice the largest acceleration per window, and once unless the original goes straight from
# speeding up to braking.


def averaged(profile: Profile, window_s: float) -> Profile:
    """Return a jerk-free profile averaged over the preceding window, in phases of its own."""
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
    """Return the phase during which both ends of the window stay within one phase each."""
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


def since_s(phase: Phase, distance: float) -> float:
    """Return how long after its start a phase reaches a distance, at most the phase's duration."""
    duration_s, start, speed, acceleration, jerk = phase
    ahead = distance - start
    if jerk == 0.0:
        root = math.sqrt(max(speed * speed + 2.0 * acceleration * ahead, 0.0))
        under = speed + root
        return min(2.0 * ahead / under, duration_s) if under > 0.0 else duration_s
    return last_that(lambda t_s: phase.state(t_s)[0] <= distance, 0.0, duration_s)
