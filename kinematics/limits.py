"""Ranges of joint angles, the turns of an angle within a range, and postures spread over ranges.

All angles in rad.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from kinematics.errors import JointLimit, KinematicsError, check_fields, finite
from kinematics.text import beyond, shown_name

# How far beyond a limit an angle may lie and still be taken for the limit itself.
#
# Next to the stretched arm the rounding of a pose shows as some 5e-8 rad of the elbow (the square
# root of the floating-point precision), so a tighter tolerance would refuse a posture's own pose.
# On an arm of 450 mm it is worth 5e-5 mm, thousands of times less than one motor step.
LIMIT_TOLERANCE_RAD = 1e-7

# Postures whose joints differ by no more than this are the same, apart from rounding.
SAME_POSTURE_RAD = 1e-4


@dataclass(frozen=True, slots=True)
class JointRange:
    """Angles that a joint can take, both ends included, in rad."""

    low_rad: float
    high_rad: float

    def __post_init__(self) -> None:
        check_fields(self, finite, "low_rad", "high_rad")
        if self.low_rad > self.high_rad:
            raise KinematicsError(
                f"a joint's low limit ({math.degrees(self.low_rad):.1f}°) must not lie above its "
                f"high limit ({math.degrees(self.high_rad):.1f}°)"
            )

    @classmethod
    def of(cls, low_deg: float, high_deg: float) -> JointRange:
        """Make a range from degrees."""
        return cls(
            math.radians(finite("low_deg", low_deg)), math.radians(finite("high_deg", high_deg))
        )

    def clamp(self, angle_rad: float) -> float:
        """Return the angle of the range nearest to this one."""
        return min(max(angle_rad, self.low_rad), self.high_rad)

    def turned(self, angle_rad: float, seed_rad: float) -> float:
        """Return the turn of an angle that a joint of this range should use; see `turn_into`."""
        return turn_into(angle_rad, self.low_rad, self.high_rad, seed_rad)

    def nearest(self, angle_rad: float, seed_rad: float) -> float:
        """Return the angle of the range whose direction is nearest to that of another angle."""
        return self.clamp(self.turned(angle_rad, seed_rad))

    def widened(self, angle_rad: float) -> JointRange:
        """Return the range extended to include this angle."""
        return JointRange(min(self.low_rad, angle_rad), max(self.high_rad, angle_rad))


def widened_to(limits: Iterable[JointRange], angles: Iterable[float]) -> tuple[JointRange, ...]:
    """Return the ranges of joints, each extended to include an angle beyond it."""
    return tuple(bounds.widened(angle) for bounds, angle in zip(limits, angles, strict=True))


@dataclass(frozen=True, slots=True)
class LimitViolation:
    """A joint beyond one of its limits: the value it would need, and the limit.

    Both are in `unit`: rad, or mm of a joint that slides. Arms that are driven have none of these.
    """

    joint: str
    value: float
    bound: float
    unit: str = "rad"

    @property
    def excess(self) -> float:
        """How far beyond the limit, in `unit`."""
        return abs(self.value - self.bound)

    def __str__(self) -> str:
        return f"{shown_name(self.joint)} {beyond(self.value, self.bound, self.unit)}"


def refuse_worst(broken: Sequence[LimitViolation]) -> None:
    """Raise `JointLimit` for the joint furthest beyond its limit, if there is one."""
    if broken:
        worst = max(broken, key=lambda violation: violation.excess)
        raise JointLimit(worst.joint, worst.value, worst.bound)


# 2 pi minus `math.tau`, the nearest float: the part of a turn that `math.tau` leaves out.
TAU_REST = 2.4492935982947064e-16


def wrap(angle: float) -> float:
    """Return the same direction within (-pi, pi].

    The sine and cosine of an angle count its turns by 2 pi, not by the nearest float, and so does
    this function. Otherwise 1e8 turns would point the hand 2.4e-8 rad elsewhere, some 9 um at the
    tip.
    """
    turned = math.remainder(angle, math.tau)
    if turned != angle:
        turns = round((angle - turned) / math.tau)
        turned = math.remainder(turned - turns * TAU_REST, math.tau)
    return turned if turned > -math.pi else math.pi


def turn_near(angle: float, near: float) -> float:
    """Return the turn of `angle` (by whole circles) that is nearest to another angle."""
    return near + wrap(wrap(angle) - near)


# Larger angles are wrapped before anything is added to them; below it that costs no digits.
MANY_TURNS_RAD = 100.0

# A seed beyond this counts as its direction: angles so large have 1e-10 rad left as last digit.
FARTHEST_SEED_RAD = 1e6


def few_turns(angle: float) -> float:
    """Return an angle that can be added to without losing digits, in the same direction."""
    return angle if -MANY_TURNS_RAD < angle < MANY_TURNS_RAD else wrap(angle)


def few_turns_each(angles: tuple[float, ...]) -> tuple[float, ...]:
    """Apply `few_turns` to each angle; return the angles themselves if none is so large."""
    if max(angles) < MANY_TURNS_RAD and min(angles) > -MANY_TURNS_RAD:
        return angles
    return tuple(map(few_turns, angles))


def turn_into(angle: float, low: float, high: float, seed: float) -> float:
    """Return the turn of `angle` (by whole circles) that a joint of this range should use.

    Of the turns within the range, the one nearest to `seed`; if none is within it, the one that
    misses it least. An angle within the tolerance of a limit becomes the limit. A range may be
    unbounded on either side, or on both.
    """
    angle = few_turns(angle)
    if not -FARTHEST_SEED_RAD < seed < FARTHEST_SEED_RAD:
        seed = wrap(seed)
    near = angle + round((seed - angle) / math.tau) * math.tau
    floor, ceiling = low - LIMIT_TOLERANCE_RAD, high + LIMIT_TOLERANCE_RAD
    if floor <= near <= ceiling:
        return min(max(near, low), high)
    # A joint may have a single limit: only the end beyond which the seed's turn lies is finite.
    if near < floor:
        turns = math.ceil((floor - angle) / math.tau)  # the first turn above the lower end
        first, last = angle + turns * math.tau, angle + (turns - 1) * math.tau
        if first <= ceiling:
            return min(max(first, low), high)
    else:
        turns = math.floor((ceiling - angle) / math.tau)  # the last turn below the upper end
        first, last = angle + (turns + 1) * math.tau, angle + turns * math.tau
        if last >= floor:
            return min(max(last, low), high)
    return last if low - last <= first - high else first


# The lowest and the highest of a range.
Span = tuple[float, float]


def all_fitted(
    angles: Sequence[float], spans: Sequence[Span], near: Sequence[float]
) -> tuple[float, ...] | None:
    """Return for each angle its turn within the range nearest to another; None if one has none.

    Most angles are within their ranges and near already: two comparisons save a call.
    """
    found = []
    for angle, (low, high), seed in zip(angles, spans, near, strict=True):
        if not (low <= angle <= high and -math.pi < angle - seed < math.pi):
            angle = turn_into(angle, low, high, seed)
            if not low <= angle <= high:
                return None
        found.append(angle)
    return tuple(found)


# Postures all over the ranges of joints, to see what an arm reaches.

# Corners of the joint limits that are sampled: all of them, of up to eight joints.
MOST_CORNERS = 256


def corners_of(spans: Sequence[Span]) -> tuple[tuple[float, ...], ...]:
    """Return the postures with every joint at one of its ends; none of too many joints."""
    return tuple(product(*spans)) if 2 ** len(spans) <= MOST_CORNERS else ()


def sampled(spans: Sequence[Span], count: int) -> Iterator[tuple[float, ...]]:
    """Yield the corners, then this many random postures, the same at every call."""
    yield from corners_of(spans)
    draw = random.Random(1)  # noqa: S311 - any postures will do
    for _ in range(count):
        yield tuple(draw.uniform(low, high) for low, high in spans)
