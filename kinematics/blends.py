"""Blends: from one part of a route to the next past the point between them, without a corner.

Units: mm and rad. Between lines and arcs a blend is a cubic Bezier curve of the tip and of the
hand's turn; where a joint motion is on either side, one of the joint angles. Its two middle
points lie two thirds of the way along the tangents, so that the direction is continuous where it
leaves and where it joins, in space and in the joints; between two straight parts it is the
parabola with the point between as its control point. A blend is inside the hull of its four
points, none of which is further from the point between than the radius.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import add, sub
from typing import NamedTuple, cast

from kinematics.arm_geometry import ArmGeometry, Curve, Point
from kinematics.chords import Chord, posture_at
from kinematics.curves import HandCurve, JointCurve
from kinematics.spaces import Joints
from kinematics.traces import Bezier, Blendable
from kinematics.vectors import add as plus
from kinematics.vectors import scale

SMALLEST_MM = 1e-3
"""A blend of a smaller radius than this is a stop."""

MIDDLE = 2.0 / 3.0
"""How far along its tangent, to the point between, a middle point of a blend lies."""

SHRINKING = 0.7
"""By how much a blend of the joints that strays is made smaller."""

_TRIES = 12
_LOOKS = 16
_HALVINGS = 30
_NUDGE = 1e-3
_SLACK_MM = 1e-6
_SLACK_RAD = 1e-9

Passing = HandCurve[Blendable]
Angles = tuple[float, ...]


class Blend(NamedTuple):
    """A curve, the share of the part before where it begins, and of the part after where it ends.

    While it lasts, the tip is within `radius_mm` of the point between the parts.
    """

    curve: Curve
    leave: float
    enter: float
    radius_mm: float


def blend(
    arm: ArmGeometry, before: Sequence[Chord], after: Sequence[Chord], radius_mm: float
) -> Blend | None:
    """Return the blend between two parts, each given by the chords of its whole curve.

    The radius is made as small as half of the shorter neighbour asks for. None is a stop: where
    no radius is asked for, or the tip does not move along a line.
    """
    first, second = _passing(before[0].curve), _passing(after[0].curve)
    limits = [one.trace.largest_blend_mm for one in (first, second) if one is not None]
    radius = min([radius_mm, *limits])
    if radius < SMALLEST_MM:
        return None
    if first is not None and second is not None:
        return _of_hands(first, second, radius)
    sides = _Side(arm, before, first, -1.0), _Side(arm, after, second, 1.0)
    return _of_joints(arm, sides, radius)


def _passing(curve: Curve) -> Passing | None:
    """Return a line or an arc as what it is, and None for a joint motion."""
    return cast(Passing, curve) if isinstance(curve, HandCurve) else None


def _of_hands(first: Passing, second: Passing, radius: float) -> Blend:
    out, into = (one.trace.share_beside_end(radius) for one in (first, second))
    leave = 1.0 - out
    start, end = first.tip(leave), second.tip(into)
    points = (
        start,
        plus(start, scale(MIDDLE * out, first.trace.slope(leave))),
        plus(end, scale(-MIDDLE * into, second.trace.slope(into))),
        end,
    )
    hands = (
        first.hand(leave),
        first.hand(1.0 - out * (1.0 - MIDDLE)),
        second.hand(into * (1.0 - MIDDLE)),
        second.hand(into),
    )
    return Blend(HandCurve(first.follower, Bezier(points), hands), leave, into, radius)


class _Side:
    """A part beside a blend in joint space; `sign` says to which side of the point between."""

    def __init__(
        self, arm: ArmGeometry, chords: Sequence[Chord], passing: Passing | None, sign: float
    ) -> None:
        self._arm = arm
        self._chords = chords
        self._curve = chords[0].curve
        self._passing = passing
        self._before = sign < 0.0
        self.end = chords[-1].end if self._before else chords[0].start

    def share(self, via: Point, radius: float) -> float:
        """Return how much of the part, at most half, lies within the radius."""
        if self._passing is not None:
            return self._passing.trace.share_beside_end(radius)

        def outside(share: float) -> bool:
            return math.dist(self._curve.tip(self.at(share)), via) > radius

        steps = (index / (2 * _LOOKS) for index in range(1, _LOOKS + 1))
        high = next((share for share in steps if outside(share)), None)
        if high is None:
            return 0.5
        low = high - 1.0 / (2 * _LOOKS)
        for _ in range(_HALVINGS):
            middle = (low + high) / 2.0
            low, high = (low, middle) if outside(middle) else (middle, high)
        return low

    def at(self, share: float) -> float:
        """Return the share of the way that is so far from the point between."""
        return 1.0 - share if self._before else share

    def points(self, share: float) -> tuple[Joints, Joints]:
        """Return where the blend leaves the part, and the middle point on the tangent there."""
        at = self.at(share)
        posture = posture_at(self._chords, at)
        towards = MIDDLE * share if self._before else -MIDDLE * share
        slope = self._slope(at, posture)
        angles = tuple(map(add, posture, (towards * rate for rate in slope)))
        return posture, Joints(angles, posture.names)

    def _slope(self, at: float, posture: Joints) -> Angles:
        """Return how fast the joints turn with the share of the way."""
        if self._passing is None:
            return tuple(map(sub, self._chords[-1].end, self._chords[0].start))
        nudge = min(_NUDGE, at / 2.0, (1.0 - at) / 2.0)
        behind, ahead = (self._curve.solve(at + step, posture) for step in (-nudge, nudge))
        return tuple((b - a) / (2.0 * nudge) for a, b in zip(behind, ahead, strict=True))


def _of_joints(arm: ArmGeometry, sides: tuple[_Side, _Side], radius: float) -> Blend | None:
    """Return a blend that neither strays from the point between nor passes a joint's range."""
    before, after = sides
    via = before.end
    tip = arm.points(via)[-1]
    most = 0.5
    for _ in range(_TRIES):
        out, into = (min(side.share(tip, radius), most) for side in sides)
        start, ahead = before.points(out)
        end, behind = after.points(into)
        curve = JointCurve(arm, (start, ahead, behind, end))
        postures = [curve.at(index / _LOOKS) for index in range(_LOOKS + 1)]
        furthest = max(math.dist(arm.points(each)[-1], tip) for each in postures)
        if furthest <= radius + _SLACK_MM and _within(arm, postures, (start, via, end)):
            return Blend(curve, before.at(out), after.at(into), furthest)
        radius, most = radius * SHRINKING, most * SHRINKING
    return None


def _within(arm: ArmGeometry, postures: Sequence[Joints], held: Sequence[Joints]) -> bool:
    """Tell whether no joint is beyond its range and beyond what the parts take it to."""
    for bounds, angles, known in zip(
        arm.limits, zip(*postures, strict=True), zip(*held, strict=True), strict=True
    ):
        low, high = min(bounds.low_rad, *known), max(bounds.high_rad, *known)
        if min(angles) < low - _SLACK_RAD or max(angles) > high + _SLACK_RAD:
            return False
    return True
