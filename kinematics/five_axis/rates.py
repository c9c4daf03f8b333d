"""Rates of the five-axis build: of its joints for a moving tip, in a jog and of its tip.

Lengths in mm, angles in rad, times in s. The tip's rates are x, y, z, pitch and roll; the joints'
follow from solving the build's own two links and its turning base (the derivative of the five-axis
closed form: McKerrow, chapter 4, sections 12 and 16).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import cos, inf, sin, sqrt
from operator import add, sub

from kinematics.five_axis import FiveAxisArm
from kinematics.five_axis.closed_form import Angles, Lengths
from kinematics.geometry import AXIS_MM
from kinematics.spaces import Jacobian, Joints

# The arithmetic of one jog cycle: ramps, joint rates of a moving tip, braking. A jog is decided
# many times a second, so that nothing but floats and tuples is made, and nothing is checked.

Rates = tuple[float, ...]

SINGULAR = 1e-9
"""A sine of the elbow so small, or of the tip's distance from the base in units of it, is none."""


def ramped(now: Rates, wish: Rates, slope: float, time_s: float) -> tuple[Rates, Rates]:
    """Return the mean over a time, and what there is at its end, of rates on their way to a wish.

    They go straight there, all at once, the one with most to change by `slope` a second: so a
    line from rest is straight, and a change of direction passes through zero.
    """
    gaps = list(map(sub, wish, now))
    gap = max(*gaps, -min(gaps))
    if gap == 0.0 or slope == inf:
        return wish, wish
    share = slope * time_s / gap
    if share >= 1.0:
        return _along(wish, -0.5 / share, gaps), wish
    return _along(now, 0.5 * share, gaps), _along(now, share, gaps)


def _along(place: Rates, share: float, gaps: Sequence[float]) -> Rates:
    return tuple(map(add, place, map(share.__mul__, gaps)))


def braked(way_s: float, time_s: float, ramp_s: float) -> float:
    """Return the share of a speed that may be had for a time, so as to stop before a bound still.

    At that speed the way to the bound would last `way_s`, and losing the speed lasts `ramp_s`:
    v^2 = 2 a d at the end of the time. From rest to the bound it is never more than all of it.
    """
    if way_s <= 0.0:
        return 0.0
    share = 2.0 * way_s / (time_s + sqrt(time_s * time_s + 2.0 * ramp_s * way_s))
    return min(share, 1.0)


def joint_rates(angles: Angles, tip: Sequence[float], lengths: Lengths) -> Angles | None:
    """Return the joints' rates for the tip's rates, None where the posture is singular."""
    base, shoulder, elbow, wrist, _ = angles
    vx, vy, vz, pitching, rolling = tip
    _, upper, fore, hand = lengths
    second = shoulder + elbow
    third = second + wrist
    cos_first, cos_second, cos_third = cos(shoulder), cos(second), cos(third)
    sin_first, sin_second, sin_third = sin(shoulder), sin(second), sin(third)
    r = upper * cos_first + fore * cos_second + hand * cos_third
    bend = sin(elbow)
    cos_base, sin_base = cos(base), sin(base)
    across = vy * cos_base - vx * sin_base
    if -SINGULAR < bend < SINGULAR or (-AXIS_MM < r < AXIS_MM and across):
        return None
    if r < 0.0:
        pitching = -pitching
    out = vx * cos_base + vy * sin_base + hand * sin_third * pitching
    up = vz - hand * cos_third * pitching
    first = (out * cos_second + up * sin_second) / (upper * bend)
    both = -(out * cos_first + up * sin_first) / (fore * bend)
    return (across / r if across else 0.0, first, both - first, pitching - both, rolling)


def share_of_limits(rates: Sequence[float], limits: Sequence[float]) -> float:
    """Return by how much rates have to be slowed so that none exceeds its limit: 1 for not at all.

    Slowing all of them alike keeps the tip on its line.
    """
    share = 1.0
    for rate, limit in zip(rates, limits, strict=True):
        if rate > limit or -rate > limit:
            share = min(share, limit / abs(rate))
    return share


def shares_to_stop(
    places: Sequence[float],
    rates: Sequence[float],
    spans: Sequence[tuple[float, float]],
    time_s: float,
    ramps_s: Sequence[float],
) -> list[float]:
    """Return by how much each rate has to be slowed to stop at the end of its span at the latest.

    `ramps_s` is how long each takes to lose its speed. The least of the shares, given to all of
    them, keeps the tip on its line.
    """
    shares = []
    for place, rate, (low, high), ramp_s in zip(places, rates, spans, ramps_s, strict=True):
        if rate == 0.0:
            shares.append(1.0)
            continue
        way_s = ((high if rate > 0.0 else low) - place) / rate
        shares.append(1.0 if way_s > time_s + ramp_s else braked(way_s, time_s, ramp_s))
    return shares


# The task Jacobian of the five-axis build.
#
# Its determinant in the build's own task space (x, y, z, pitch, roll) is r * a2 * a3 * sin(elbow),
# up to its sign, where r is the tip's distance from the base axis: the build is singular with the
# elbow straight or folded, and with the tip over the base, and nowhere else.


def task_jacobian(arm: FiveAxisArm, joints: Joints) -> Jacobian:
    """Return the five rows x, y, z (mm/rad), pitch and roll (rad/rad) of the five-axis build.

    The derivative of `FiveAxisArm.fk`. A tip behind the base axis pitches against its joints
    (see `arm`); on the axis itself pitch counts as in front, and the tip can leave in the
    arm's own plane only.
    """
    arm.fk(joints)  # checks that these are the build's joints
    base, *plane, _ = joints.angles_rad
    to_tip = from_joints_to_tip(plane, arm.lengths)
    r = to_tip[0][0]
    cos_base, sin_base = math.cos(base), math.sin(base)
    sense = -1.0 if r < -AXIS_MM else 1.0
    return (
        (-r * sin_base, *(-cos_base * rise for _, rise in to_tip), 0.0),
        (r * cos_base, *(-sin_base * rise for _, rise in to_tip), 0.0),
        (0.0, *(reach for reach, _ in to_tip), 0.0),
        (0.0, sense, sense, sense, 0.0),
        (0.0, 0.0, 0.0, 0.0, 1.0),
    )


def from_joints_to_tip(plane: Sequence[float], lengths: Lengths) -> list[tuple[float, float]]:
    """Return how far the tip lies outwards of and above shoulder, elbow and wrist.

    `plane` holds their angles. What is above a joint is also how fast the tip moves inwards while
    that joint turns.
    """
    shoulder, elbow, wrist = plane
    _, upper, fore, hand = lengths
    found = []
    reach = rise = 0.0
    for length, elevation in (
        (hand, shoulder + elbow + wrist),
        (fore, shoulder + elbow),
        (upper, shoulder),
    ):
        reach += length * math.cos(elevation)
        rise += length * math.sin(elevation)
        found.append((reach, rise))
    return found[::-1]
