"""Curves that an arm follows: of the tip with the hand held, or of the joints themselves.

Units: mm and rad. `geometry.Curve` is the interface of all curves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Generic, TypeVar

from kinematics.errors import NoArc, positive
from kinematics.frames.vectors import Vector, add, cross, distance, dot, norm, scale, subtract, unit
from kinematics.geometry import (
    ArmGeometry,
    Follower,
    Hand,
    NotFollowed,
    PathBroken,
    Point,
    Unreachable,
)
from kinematics.limits import turn_near
from kinematics.spaces import Joints, Pose, refuse_yaw
from kinematics.text import shown_name

# Traces: curves of the tip through space, without arm or hand. Points are given at shares (0 to 1).

# The longest part in which an arc is examined: a chord is compared with the curve at three places,
# and there a whole turn may look like no motion.
EIGHTH_RAD = math.pi / 4.0

QUARTER_RAD = math.pi / 2.0

# The parts in which a blend is examined at least, for the same reason.
BLEND_CHORDS = 8


@dataclass(frozen=True, slots=True)
class LineSegment:
    """A straight line between two points."""

    start: Point
    end: Point
    shape = "straight line"
    least_chords = 1

    def at(self, share: float) -> Point:
        """Return the point at a share of the line."""
        if share >= 1.0:
            return self.end
        (a, b, c), (x, y, z) = self.start, self.end
        return a + share * (x - a), b + share * (y - b), c + share * (z - c)

    @property
    def largest_blend_mm(self) -> float:
        """Half of its length."""
        return distance(self.start, self.end) / 2.0

    def share_beside_end(self, radius_mm: float) -> float:
        """Return the share of the line within this distance of an end."""
        return radius_mm / distance(self.start, self.end)

    def slope(self, share: float) -> Vector:  # noqa: ARG002 - the same everywhere
        """Return the vector from end to end."""
        return subtract(self.end, self.start)


@dataclass(frozen=True, slots=True)
class Round:
    """A circular arc about a centre by a sweep in rad; `ahead` is a quarter turn beyond `out`.

    `out` leads from the centre to the start; both have the length of the radius.
    """

    centre: Point
    out: Vector
    ahead: Vector
    sweep_rad: float
    end: Point
    shape = "arc"

    @property
    def least_chords(self) -> int:
        """One part for each eighth of a turn."""
        return max(1, math.ceil(self.sweep_rad / EIGHTH_RAD - 1e-9))

    @property
    def radius_mm(self) -> float:
        """The distance from the centre."""
        return math.hypot(*self.out)

    def at(self, share: float) -> Point:
        """Return the point at a share of the sweep."""
        if share >= 1.0:
            return self.end
        return turned(self.centre, self.out, self.ahead, share * self.sweep_rad)

    @property
    def largest_blend_mm(self) -> float:
        """The distance of an end from the middle, but at most from a quarter of a turn away."""
        return 2.0 * self.radius_mm * math.sin(min(self.sweep_rad / 2.0, QUARTER_RAD) / 2.0)

    def share_beside_end(self, radius_mm: float) -> float:
        """Return the share of the sweep within this straight-line distance of an end."""
        half = min(radius_mm / (2.0 * self.radius_mm), 1.0)
        return 2.0 * math.asin(half) / self.sweep_rad

    def slope(self, share: float) -> Vector:
        """Return the direction of the tangent, as long as the whole arc."""
        angle = share * self.sweep_rad
        tangent = subtract(scale(math.cos(angle), self.ahead), scale(math.sin(angle), self.out))
        return scale(self.sweep_rad, tangent)


@dataclass(frozen=True, slots=True)
class Bezier:
    """A cubic curve from the first of four points to the last, shaped by the two between."""

    points: tuple[Point, Point, Point, Point]
    shape = "blend"
    least_chords = BLEND_CHORDS

    def at(self, share: float) -> Point:
        """Return the point at a share of the curve's parameter."""
        x, y, z = cubic(self.points, share)
        return x, y, z


# A trace that a blend may leave or join; it looks the same from both ends.
Blendable = LineSegment | Round


def turned(centre: Point, out: Vector, ahead: Vector, angle_rad: float) -> Point:
    """Return the point about a centre; see `Round`."""
    off = add(scale(math.cos(angle_rad), out), scale(math.sin(angle_rad), ahead))
    return add(centre, off)


def cubic(points: tuple[tuple[float, ...], ...], share: float) -> tuple[float, ...]:
    """Return the point of a cubic Bezier curve of any dimension (Bernstein's form)."""
    left = 1.0 - share
    a, d = left * left * left, share * share * share
    b, c = 3.0 * left * left * share, 3.0 * left * share * share
    return tuple(
        a * one + b * two + c * three + d * four
        for one, two, three, four in zip(*points, strict=True)
    )


# Arcs through three points: their centre is the circumcentre of the triangle.

# Points nearer to one another, or to a line, define no circle: a motor step moves further.
LEAST_MM = 0.01


def round_through(start: Point, via: Point, goal: Point, sweep_rad: float | None = None) -> Round:
    """Return the arc through three points, to the third or by a sweep.

    Raises `NoArc`.
    """
    _check_apart(start, via, goal)
    b, c = subtract(via, start), subtract(goal, start)
    normal = cross(b, c)
    weighed = add(
        scale(dot(c, c), cross(normal, b)),
        scale(dot(b, b), cross(c, normal)),
    )
    from_start = scale(0.5 / dot(normal, normal), weighed)
    centre, out = add(start, from_start), scale(-1.0, from_start)
    ahead = cross(unit(normal), out)
    if sweep_rad is None:
        return Round(centre, out, ahead, _angle_about(subtract(goal, centre), out, ahead), goal)
    sweep = positive("sweep_rad", sweep_rad)
    return Round(centre, out, ahead, sweep, turned(centre, out, ahead, sweep))


def _angle_about(point: Vector, out: Vector, ahead: Vector) -> float:
    return math.atan2(dot(point, ahead), dot(point, out)) % math.tau


def _check_apart(start: Point, via: Point, goal: Point) -> None:
    named = {"start": start, "via point": via, "goal": goal}
    pairs = (("start", "via point"), ("via point", "goal"), ("start", "goal"))
    sides = {pair: distance(named[pair[0]], named[pair[1]]) for pair in pairs}
    (one, two), nearest = min(sides.items(), key=lambda side: side[1])
    if nearest < LEAST_MM:
        remedy = "give three points that lie apart"
        if (one, two) == ("start", "goal"):
            remedy += ", or for a full circle another point of it as the goal, and a sweep of 2 pi"
        raise NoArc(f"{one} and {two} are the same point", remedy, nearest)
    off = norm(cross(subtract(via, start), subtract(goal, start))) / max(sides.values())
    if off < LEAST_MM:
        raise NoArc(
            f"start, via point and goal lie in a line, to within {off:.3f} mm",
            "use a straight line, or a via point beside it",
            off,
        )


# What the followers of every build share: turning the hand in proportion, and refusing leaps. If a
# hand is two angles, the first is its pitch and the second its roll, each of any turn.


@dataclass(frozen=True, slots=True, eq=False)
class NearFollower:
    """The posture near the one before, of an arm whose hand is a pitch and a roll.

    `arm` has limits widened to the start. No joint may turn further than `largest_turn_rad` between
    two waypoints.
    """

    arm: ArmGeometry
    first: Hand
    largest_turn_rad: float
    posture = ""

    def hand(self, pose: Pose, near: Hand) -> Hand:
        """Return how a pose holds the hand, pitch and roll the shorter way round."""
        refuse_yaw(pose)
        return turn_near(pose.pitch_rad, near[0]), turn_near(pose.roll_rad, near[1])

    def between(self, a: Hand, b: Hand, share: float) -> Hand:
        """Return the hand at a share of the turn: pitch and roll in proportion."""
        return in_proportion(a, b, share)

    def pose(self, tip: Point, hand: Hand) -> Pose:
        """Return the pose of a tip and a hand."""
        return Pose(*tip, *hand)

    def solve(self, tip: Point, hand: Hand, before: Joints) -> Joints:
        """Return the posture near the one before; raises `NotFollowed`."""
        try:
            joints = self.arm.ik_near(self.pose(tip, hand), before)
        except Unreachable as refusal:
            raise NotFollowed(refusal.reason) from None
        name, turn_rad = largest_turn(before, joints)
        if turn_rad > self.largest_turn_rad:
            raise NotFollowed(leap_sentence(name, turn_rad, "the posture is singular there"))
        return joints


def in_proportion(a: Hand, b: Hand, share: float) -> Hand:
    """Return the hand at a share (0 to 1) of the turn, both angles in proportion; b is exact."""
    if share >= 1.0:
        return b
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def largest_turn(before: Joints, reached: Joints) -> tuple[str, float]:
    """Return the joint that turns furthest, and by how much."""
    turns = [abs(b - a) for a, b in zip(before, reached, strict=True)]
    furthest = max(turns)
    return reached.names[turns.index(furthest)], furthest


# The furthest that a joint may turn in one small step: further is a leap to another posture.
LEAP_RAD = 0.5


def leap_sentence(joint: str, turn_rad: float, why: str) -> str:
    """Return the reason for refusing to turn a joint so far in one step."""
    turn = f"{math.degrees(turn_rad):.0f}° at once"
    return f"the {shown_name(joint)} would have to turn by {turn}, because {why}"


T = TypeVar("T", bound=Blendable | Bezier, covariant=True)


@dataclass(frozen=True, slots=True, eq=False)
class HandCurve(Generic[T]):
    """A path of the tip along which the hand turns, in the posture that a follower keeps.

    `hands` are two for a proportional turn, or the four control points of a cubic Bezier curve.
    """

    follower: Follower
    trace: T
    hands: tuple[Hand, ...]
    straight = False

    @property
    def shape(self) -> str:
        """The kind of curve, in words."""
        return self.trace.shape

    @property
    def least_chords(self) -> int:
        """How many equal parts the curve is cut into before it is examined."""
        return self.trace.least_chords

    def tip(self, fraction: float) -> Point:
        """Return the point of the curve at a fraction of its length."""
        return self.trace.at(fraction)

    def hand(self, fraction: float) -> Hand:
        """Return the hand at a fraction (de Casteljau's construction)."""
        hands, between = self.hands, self.follower.between
        while len(hands) > 2:
            hands = tuple(between(a, b, fraction) for a, b in pairwise(hands))
        return between(hands[0], hands[1], fraction)

    def pose(self, fraction: float) -> Pose:
        """Return the curve's pose at a fraction (0 to 1) of its length."""
        return self.follower.pose(self.tip(fraction), self.hand(fraction))

    def solve(self, fraction: float, before: Joints) -> Joints:
        """Return the posture at a fraction, near the previous one. Raises `PathBroken`."""
        try:
            return self.follower.solve(self.trace.at(fraction), self.hand(fraction), before)
        except NotFollowed as reason:
            broken = PathBroken(fraction, self.pose(fraction), str(reason), shape=self.shape)
            raise broken from None

    def leap(self, before: Joints, reached: Joints) -> str | None:
        """Refuse a base that swings round because the tip passed its axis."""
        turn = abs(reached.angles_rad[0] - before.angles_rad[0])
        if turn <= LEAP_RAD:
            return None
        return leap_sentence("base", turn, f"the {self.shape} meets the base axis")


# A straight line of the tip.
Line = HandCurve[LineSegment]


@dataclass(frozen=True, slots=True)
class JointPath:
    """A motion in which every joint turns in proportion, from one posture to another."""

    start: Joints
    goal: Joints

    def at(self, fraction: float) -> Joints:
        """Return the posture at a fraction (0 to 1) of the path; the ends are exact."""
        if fraction >= 1.0:
            return self.goal
        return Joints(
            tuple(a + fraction * (b - a) for a, b in zip(self.start, self.goal, strict=True)),
            self.start.names,
        )

    @property
    def changes_rad(self) -> tuple[float, ...]:
        """How far each joint turns."""
        return tuple(b - a for a, b in zip(self.start, self.goal, strict=True))


@dataclass(frozen=True, slots=True)
class JointCurve:
    """A motion of the joints: straight between two postures, or a cubic Bezier curve of four."""

    arm: ArmGeometry
    points: tuple[Joints, ...]

    @property
    def straight(self) -> bool:
        """Whether every joint turns in proportion."""
        return len(self.points) == 2

    @property
    def shape(self) -> str:
        """The kind of curve, in words."""
        return "joint motion" if self.straight else "blend"

    @property
    def least_chords(self) -> int:
        """How many equal parts the curve is cut into before it is examined."""
        return 1 if self.straight else BLEND_CHORDS

    def at(self, fraction: float) -> Joints:
        """Return the posture at a fraction of the path; the ends are exact."""
        start, *_, end = self.points
        if self.straight or fraction >= 1.0:
            return JointPath(start, end).at(fraction)
        return Joints(cubic(tuple(each.angles_rad for each in self.points), fraction), start.names)

    def pose(self, fraction: float) -> Pose:
        """Return the pose at a fraction (0 to 1) of the path."""
        return self.arm.fk(self.at(fraction))

    def tip(self, fraction: float) -> Point:
        """Return the position of the tip at a fraction of the path."""
        return self.arm.points(self.at(fraction))[-1]

    def solve(self, fraction: float, before: Joints) -> Joints:  # noqa: ARG002 - as of any curve
        """Return the posture at a fraction."""
        return self.at(fraction)

    def leap(self, before: Joints, reached: Joints) -> None:
        """Refuse nothing: the joints turn exactly as requested."""


def straight_between(follower: Follower, start: Point, hand: Hand, goal: Pose) -> Line:
    """Return the straight line from a tip and a hand to a pose."""
    end = goal.position_mm
    return HandCurve(follower, LineSegment(start, end), (hand, follower.hand(goal, hand)))


# An arc of the tip.
Arc = HandCurve[Round]


def beginning(arm: ArmGeometry, start: Joints) -> tuple[Follower, Point]:
    """Return the follower of a start posture, and the position of the tip."""
    return arm.follower(start), arm.fk(start).position_mm


def straight_line(arm: ArmGeometry, start: Joints, goal: Pose) -> Line:
    """Return the straight line from a posture to a pose, in the posture that it starts in."""
    follower, tip = beginning(arm, start)
    return straight_between(follower, tip, follower.first, goal)


def arc_between(
    follower: Follower, tip: Point, hand: Hand, via: Pose, goal: Pose, sweep_rad: float | None
) -> Arc:
    """Return the arc from a tip and a hand through a point to a pose; see `ArcPart`.

    The hand turns in proportion to the sweep; how `via` holds it is ignored. Raises `NoArc`.
    """
    middle, end = (each.position_mm for each in (via, goal))
    trace = round_through(tip, middle, end, sweep_rad)
    return HandCurve(follower, trace, (hand, follower.hand(goal, hand)))
