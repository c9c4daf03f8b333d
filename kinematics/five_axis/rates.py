"""Rates of the five-axis build: of its joints for a moving tip, in a jog and at singularities.

Lengths in mm, angles in rad, times in s. The tip's rates are x, y, z, pitch and roll; the joints'
follow from solving the build's own two links and its turning base (the derivative of the five-axis
closed form: McKerrow, chapter 4, sections 12 and 16).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from math import cos, inf, sin, sqrt
from operator import add, sub

from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.closed_form import Angles, Lengths, plane_tip
from kinematics.geometry import AXIS_MM
from kinematics.limits import wrap
from kinematics.spaces import Jacobian, Joints, RollFrame

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


# The singularities of the five-axis build: which there are, how near, and what each one costs.
#
# In its own task space (x, y, z, pitch, roll) the build's Jacobian has the determinant
# r * a2 * a3 * sin(elbow), up to its sign, where r is the tip's distance from the base axis: it is
# singular with the elbow straight or folded, and with the tip over the base, and nowhere else.
# Source: McKerrow, chapter 4, sections 12 and 16. Lengths in mm, angles in rad.

_ROUNDS = 50
_CLOSE_MM = 1e-10


def task_jacobian(
    arm: FiveAxisArm, joints: Joints, roll_frame: RollFrame = RollFrame.HAND
) -> Jacobian:
    """Return the five rows x, y, z (mm/rad), pitch and roll (rad/rad) of the five-axis build.

    The derivative of `FiveAxisArm.fk`. A tip behind the base axis pitches against its joints
    (see `arm`); on the axis itself pitch counts as in front, and the tip can leave in the
    arm's own plane only.
    """
    arm.fk(joints)  # checks that these are the build's joints
    base, shoulder, elbow, wrist, _ = joints.angles_rad
    r, _, _ = plane_tip(shoulder, elbow, wrist, arm.lengths)
    joints_above = _above(arm, shoulder, elbow, wrist)
    cos_base, sin_base = math.cos(base), math.sin(base)
    outwards = [-rise for _, rise in joints_above]
    upwards = [reach for reach, _ in joints_above]
    sense = -1.0 if r < -AXIS_MM else 1.0
    turns_roll = -1.0 if roll_frame is RollFrame.TABLE else 0.0
    return (
        (-r * sin_base, *(cos_base * rate for rate in outwards), 0.0),
        (r * cos_base, *(sin_base * rate for rate in outwards), 0.0),
        (0.0, *upwards, 0.0),
        (0.0, sense, sense, sense, 0.0),
        (turns_roll, 0.0, 0.0, 0.0, 1.0),
    )


def _above(
    arm: FiveAxisArm, shoulder: float, elbow: float, wrist: float
) -> list[tuple[float, float]]:
    """Return how far the tip lies outwards of and above shoulder, elbow and wrist, in the plane."""
    _, upper, fore, hand = arm.lengths
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


class FiveAxisSingularity(Enum):
    """A way in which the five-axis build is singular; the value says what it costs."""

    ELBOW_STRAIGHT = (
        "the elbow is straight: the wrist cannot move further from the shoulder, and elbow up and "
        "elbow down are the same posture"
    )
    ELBOW_FOLDED = (
        "the elbow is folded: the wrist cannot move nearer to the shoulder, and elbow up and "
        "elbow down are the same posture"
    )
    TIP_OVER_BASE = (
        "the tip is on the base axis: turning the base only turns the hand, and the tip cannot "
        "move across the plane that the arm stands in"
    )


@dataclass(frozen=True, slots=True)
class Nearness:
    """How far a posture is from one singularity.

    `distance_rad` is the smallest joint move that leads there (root of the sum of squares; over
    the base, the smallest one found, which is never more than the shoulder's alone);
    `distance_mm` how far the wrist is from full stretch or full fold, or the tip from the base
    axis.
    """

    singularity: FiveAxisSingularity
    distance_rad: float
    distance_mm: float

    @property
    def sentence(self) -> str:
        """What the singularity costs, and how far away it is."""
        return (
            f"{math.degrees(self.distance_rad):.1f}° and {self.distance_mm:.1f} mm away: "
            f"{self.singularity.value}"
        )


def five_axis_singularities(arm: FiveAxisArm, joints: Joints) -> tuple[Nearness, ...]:
    """Return the three singularities, the nearest (by joint moves) first; limits not looked at."""
    points = arm.points(joints)
    _, shoulder, elbow, wrist, _ = joints.angles_rad
    bend = abs(wrap(elbow))
    span = math.dist(points[1], points[3])
    upper, fore = arm.upper_arm_mm, arm.forearm_mm
    over = _over_base(arm, (shoulder, elbow, wrist))
    return tuple(
        sorted(
            (
                Nearness(FiveAxisSingularity.ELBOW_STRAIGHT, bend, max(upper + fore - span, 0.0)),
                Nearness(
                    FiveAxisSingularity.ELBOW_FOLDED,
                    math.pi - bend,
                    max(span - abs(upper - fore), 0.0),
                ),
                Nearness(FiveAxisSingularity.TIP_OVER_BASE, over, math.hypot(*points[4][:2])),
            ),
            key=lambda one: one.distance_rad,
        )
    )


def _over_base(arm: FiveAxisArm, start: tuple[float, float, float]) -> float:
    """Return a small move of shoulder, elbow and wrist that puts the tip on the base axis.

    The shoulder alone can always do it, since its axis meets the base axis: that bounds the
    move from above. Newton's method on r = 0, always by the shortest way from the start,
    looks for a combination that is smaller.
    """
    r, z, _ = plane_tip(*start, arm.lengths)
    height = z - arm.base_height_mm
    alone = math.atan2(abs(r), abs(height)) if r or height else 0.0
    angles = start
    for _ in range(_ROUNDS):
        if not math.dist(start, angles) <= alone:
            break  # on the flat at full stretch a step is thrown anywhere
        r, _, _ = plane_tip(*angles, arm.lengths)
        if abs(r) <= _CLOSE_MM:
            return math.dist(start, angles)
        slopes = _slopes(arm, angles)
        steep = sum(slope * slope for slope in slopes)
        if steep == 0.0:
            break
        back = sum(s * (a - b) for s, a, b in zip(slopes, start, angles, strict=True))
        step = (r + back) / steep
        one, two, three = (a - slope * step for a, slope in zip(start, slopes, strict=True))
        angles = one, two, three
    return alone


def _slopes(arm: FiveAxisArm, angles: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return how the tip's distance from the base axis changes with each angle, mm/rad."""
    shoulder, elbow, wrist = angles
    _, upper, fore, hand = arm.lengths
    of_hand = -hand * math.sin(shoulder + elbow + wrist)
    of_fore = of_hand - fore * math.sin(shoulder + elbow)
    return of_fore - upper * math.sin(shoulder), of_fore, of_hand
