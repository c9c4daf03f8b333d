"""Routes: joint motions, straight lines and arcs in sequence, with blends between them.

Units: mm and rad. A route becomes sections: corners of a path in joint space that is passed without
stopping, at rest at its ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import add, sub
from typing import NamedTuple, cast

from kinematics.errors import NoArc, check_fields, finite, not_negative, require
from kinematics.frames.numbers import last_that
from kinematics.frames.vectors import add as plus
from kinematics.frames.vectors import scale
from kinematics.geometry import ArmGeometry, Curve, Follower, Hand, PathBroken, Point, Unreachable
from kinematics.paths.chords import (
    LINE_TOLERANCE_MM,
    STILL_RAD,
    Chord,
    corners,
    cut,
    posture_at,
    smooth,
    trim,
)
from kinematics.paths.curves import (
    Arc,
    Bezier,
    Blendable,
    HandCurve,
    JointCurve,
    Line,
    arc_between,
    beginning,
    straight_between,
)
from kinematics.spaces import JOINTS_EXAMPLE, POSE_EXAMPLE, Joints, Pose, angles_of


@dataclass(frozen=True, slots=True)
class JointPart:
    """Every joint turns in proportion, to a posture."""

    goal: Joints
    blend_mm: float = 0.0

    def __post_init__(self) -> None:
        require("goal", self.goal, Joints, JOINTS_EXAMPLE)
        check_fields(self, not_negative, "blend_mm")


@dataclass(frozen=True, slots=True)
class _PartToPose:
    goal: Pose
    blend_mm: float = 0.0

    def __post_init__(self) -> None:
        require("goal", self.goal, Pose, POSE_EXAMPLE)
        check_fields(self, not_negative, "blend_mm")


class PosePart(_PartToPose):
    """Every joint turns in proportion, to the nearest posture for a pose."""

    __slots__ = ()


class LinePart(_PartToPose):
    """A straight line to a pose, in x, y, z and the turn of the hand."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class ArcPart:
    """A circular arc through a via point, of which only x, y and z count, to a pose.

    With `sweep_rad` the arc ends after that angle instead, and the goal only gives a third point of
    the circle and the final orientation of the hand; 2 pi is a full circle.
    """

    via: Pose
    goal: Pose
    blend_mm: float = 0.0
    sweep_rad: float | None = None

    def __post_init__(self) -> None:
        require("via", self.via, Pose, POSE_EXAMPLE)
        require("goal", self.goal, Pose, POSE_EXAMPLE)
        if self.sweep_rad is not None:
            check_fields(self, finite, "sweep_rad")
        check_fields(self, not_negative, "blend_mm")


# One part of a route.
PathPart = JointPart | PosePart | LinePart | ArcPart


# The parts of a route laid end to end, each from stop to stop: its curve and its chords.


class Laid(NamedTuple):
    """A part of a route: its number, from 1, and the chords of its whole curve."""

    number: int
    move: PathPart
    chords: list[Chord]


class _Hold(NamedTuple):
    """The state of tip and hand, and the follower, between lines and arcs."""

    follower: Follower
    tip: Point
    hand: Hand


def lay(
    arm: ArmGeometry, start: Joints, moves: Sequence[PathPart], tolerance_mm: float
) -> list[Laid]:
    """Return the parts of a route. Raises `PathBroken` and `NoArc` that name the part."""
    layer = _Layer(arm, tolerance_mm, start)
    found = []
    for number, move in enumerate(moves, 1):
        try:
            found.append(Laid(number, move, layer.chords(number, move)))
        except (PathBroken, NoArc) as broken:
            raise broken.of_part(number) from broken.__cause__
    return found


class _Layer:
    """The end of the route so far, and the posture in which its lines and arcs are followed."""

    def __init__(self, arm: ArmGeometry, tolerance_mm: float, start: Joints) -> None:
        self._arm = arm
        self._tolerance_mm = tolerance_mm
        self._here = start
        self._hold: _Hold | None = None
        self._posture: tuple[str, int] | None = None

    def chords(self, number: int, move: PathPart) -> list[Chord]:
        """Return the chords of the next part."""
        if isinstance(move, JointPart | PosePart):
            found = self._turn(self._goal(move))
            self._hold = None
        else:
            hold = self._hold or self._begin(number, move)
            curve = _curve(hold, move)
            found = cut(self._arm, curve, self._here, self._tolerance_mm)
            self._hold = _Hold(hold.follower, curve.trace.end, curve.hands[-1])
        self._here = found[-1].end
        return found

    def _turn(self, goal: Joints) -> list[Chord]:
        angles_of(goal, self._here.names)
        curve = JointCurve(self._arm, (self._here, goal))
        return cut(self._arm, curve, self._here, self._tolerance_mm)

    def _goal(self, move: JointPart | PosePart) -> Joints:
        if isinstance(move, JointPart):
            return move.goal
        try:
            return self._arm.ik(move.goal, self._here)
        except Unreachable as refusal:
            reason = f"{refusal.reason}; nearest pose that can be reached: {refusal.nearest}"
            raise PathBroken(1.0, move.goal, reason, shape="joint motion") from refusal

    def _begin(self, number: int, move: LinePart | ArcPart) -> _Hold:
        """Start from the arm's posture; the first start decides the posture of the whole route."""
        follower, tip = beginning(self._arm, self._here)
        posture, part = self._posture = self._posture or (follower.posture, number)
        if follower.posture != posture:
            reason = (
                f"the arm would stand in another posture ({follower.posture}) than in part "
                f"{part} ({posture})"
            )
            shape = "arc" if isinstance(move, ArcPart) else "straight line"
            raise PathBroken(0.0, self._arm.fk(self._here), reason, shape=shape)
        return _Hold(follower, tip, follower.first)


def _curve(hold: _Hold, move: LinePart | ArcPart) -> Line | Arc:
    follower, tip, hand = hold
    if isinstance(move, ArcPart):
        return arc_between(follower, tip, hand, move.via, move.goal, move.sweep_rad)
    return straight_between(follower, tip, hand, move.goal)


# Blends: from one part of a route to the next, passing the point between them without a corner.
#
# Between lines and arcs a blend is a cubic Bezier curve of the tip and of the hand's turn; next to
# a joint motion, it is a curve of the joint angles. Its two middle points lie two thirds of the way
# along the tangents, so that the direction is continuous at both ends, in space and in the joints;
# between two straight parts it is the parabola with the point between as its control point. A blend
# is inside the hull of its four points, none of which is further from the point between than the
# radius.

# A blend with a smaller radius is a stop.
SMALLEST_MM = 1e-3

# Where a middle point of a blend lies along its tangent towards the point between.
MIDDLE = 2.0 / 3.0

# How many parts of a joint blend, or of half a joint motion, are looked at for where it is.
_LOOKS = 16

# The share of a part over which its slope in joint space is measured.
_NUDGE = 1e-3

# What rounding may add.
_SLACK_MM = 1e-6
_SLACK_RAD = 1e-9

Passing = HandCurve[Blendable]
Angles = tuple[float, ...]


class Blend(NamedTuple):
    """A curve, the share of the previous part at which it begins, and of the next at which it ends.

    During the blend, the tip is within `radius_mm` of the point between the parts.
    """

    curve: Curve
    leave: float
    enter: float
    radius_mm: float


def blend(
    arm: ArmGeometry, before: Sequence[Chord], after: Sequence[Chord], radius_mm: float
) -> Blend | None:
    """Return the blend between two parts, each given by the chords of its whole curve.

    The radius is limited to half of the shorter neighbour. None means a stop: no radius is
    requested, the tip does not move along a line, or a blend of joint motions would stray.
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
    """Return a line or an arc; None for a joint motion."""
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
    """A part next to a joint blend; `sign` says on which side of the point between."""

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
        return last_that(lambda share: not outside(share), high - 0.5 / _LOOKS, high)

    def at(self, share: float) -> float:
        """Return the share of the part at that distance from the point between."""
        return 1.0 - share if self._before else share

    def points(self, share: float) -> tuple[Joints, Joints]:
        """Return where the blend meets the part, and the middle point on the tangent there."""
        at = self.at(share)
        posture = posture_at(self._chords, at)
        towards = MIDDLE * share if self._before else -MIDDLE * share
        slope = self._slope(at, posture)
        angles = tuple(map(add, posture, (towards * rate for rate in slope)))
        return posture, Joints(angles, posture.names)

    def _slope(self, at: float, posture: Joints) -> Angles:
        """Return how fast the joints turn with the share of the path."""
        if self._passing is None:
            return tuple(map(sub, self._chords[-1].end, self._chords[0].start))
        nudge = min(_NUDGE, at / 2.0, (1.0 - at) / 2.0)
        behind, ahead = (self._curve.solve(at + step, posture) for step in (-nudge, nudge))
        return tuple((b - a) / (2.0 * nudge) for a, b in zip(behind, ahead, strict=True))


def _of_joints(arm: ArmGeometry, sides: tuple[_Side, _Side], radius: float) -> Blend | None:
    """Return a blend that neither strays from the point between nor exceeds a joint's range.

    The arm stops there (None) where it would: fewer than one in a hundred do.
    """
    before, after = sides
    via = before.end
    tip = arm.points(via)[-1]
    out, into = (side.share(tip, radius) for side in sides)
    start, ahead = before.points(out)
    end, behind = after.points(into)
    curve = JointCurve(arm, (start, ahead, behind, end))
    postures = [curve.at(index / _LOOKS) for index in range(_LOOKS + 1)]
    furthest = max(math.dist(arm.points(each)[-1], tip) for each in postures)
    if furthest > radius + _SLACK_MM or not _within(arm, postures, (start, via, end)):
        return None
    return Blend(curve, before.at(out), after.at(into), furthest)


def _within(arm: ArmGeometry, postures: Sequence[Joints], held: Sequence[Joints]) -> bool:
    """Return whether every joint stays within its range, or within where the parts take it."""
    for bounds, angles, known in zip(
        arm.limits, zip(*postures, strict=True), zip(*held, strict=True), strict=True
    ):
        low, high = min(bounds.low_rad, *known), max(bounds.high_rad, *known)
        if min(angles) < low - _SLACK_RAD or max(angles) > high + _SLACK_RAD:
            return False
    return True


@dataclass(frozen=True, slots=True)
class Route:
    """The start of the arm, and what it does from there, in order."""

    start: Joints
    parts: tuple[PathPart, ...]


@dataclass(frozen=True, slots=True)
class PathSection:
    """A path that is passed without stopping: at rest at its first and last corner.

    Between corners every joint turns in proportion. `parts` are the numbers, from 1, of the route's
    parts in it. For each of them `blends_mm` is the radius of the blend at its end: the greatest
    distance of the tip from the end of the part while it passes. It may be less than requested; for
    the last part, where the arm stops, it is 0.
    """

    corners: tuple[Joints, ...]
    parts: tuple[int, ...]
    blends_mm: tuple[float, ...]


def route_sections(
    arm: ArmGeometry, route: Route, tolerance_mm: float = LINE_TOLERANCE_MM
) -> tuple[PathSection, ...]:
    """Return the sections of a route; a section ends at each stop.

    All lines and arcs of the route are followed in one posture of the arm. Between corners the tip
    is never further than `tolerance_mm` from the line, the arc or the blend. At a corner the path's
    direction in joint space turns by at most 15 degrees, unless the joints turn by less than a
    thousandth of a rad there (see `chords`).

    Joint motions are not checked against joint limits, and nothing is checked against guards: the
    driver examines all corners. Raises `PathBroken`, which names the part and the point, and
    `NoArc`.
    """
    if not route.parts:
        return ()
    laid = lay(arm, route.start, route.parts, tolerance_mm)
    blends = [
        blend(arm, here.chords, after.chords, here.move.blend_mm) for here, after in pairwise(laid)
    ]
    return tuple(
        _section(arm, run, joins, tolerance_mm) for run, joins in _runs(laid, [*blends, None])
    )


def _runs(
    laid: Sequence[Laid], blends: Sequence[Blend | None]
) -> Iterator[tuple[list[Laid], list[Blend]]]:
    """Yield the runs of parts between stops, and the blends within each run."""
    run: list[Laid] = []
    joins: list[Blend] = []
    for part, join in zip(laid, blends, strict=True):
        run.append(part)
        if join is None:
            yield run, joins
            run, joins = [], []
        else:
            joins.append(join)


def _section(
    arm: ArmGeometry, run: Sequence[Laid], joins: Sequence[Blend], tolerance_mm: float
) -> PathSection:
    leaves = [*(join.leave for join in joins), 1.0]
    enters = [0.0, *(join.enter for join in joins)]
    chords: list[Chord] = []
    for part, enter, leave, join in zip(run, enters, leaves, [*joins, None], strict=True):
        _append(chords, trim(part.chords, enter, leave))
        if join is None:
            break
        try:
            _append(chords, cut(arm, join.curve, chords[-1].end, tolerance_mm))
        except PathBroken as broken:
            raise broken.of_part(part.number) from None
    return PathSection(
        corners(smooth(_moving(chords))),
        tuple(part.number for part in run),
        (*(join.radius_mm for join in joins), 0.0),
    )


def _append(chords: list[Chord], more: Sequence[Chord]) -> None:
    """Append chords that begin, up to rounding, where the others end."""
    for chord in more:
        chords.append(chord._replace(start=chords[-1].end) if chords else chord)


def _moving(chords: Sequence[Chord]) -> list[Chord]:
    """Return the chords in which something turns; the ends of the path stay the same."""
    found: list[Chord] = []
    for chord in chords:
        if max(abs(b - a) for a, b in zip(chord.start, chord.end, strict=True)) > STILL_RAD:
            found.append(chord._replace(start=found[-1].end) if found else chord)
    found = found or [chords[-1]]
    found[0] = found[0]._replace(start=chords[0].start)
    found[-1] = found[-1]._replace(end=chords[-1].end)
    return found
