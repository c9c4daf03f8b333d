"""Curves that an arm follows: of the tip with the hand held, or of the joints themselves.

Units: mm and rad. `geometry.Curve` is the interface of all curves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Generic, TypeVar

from kinematics.errors import PathBroken
from kinematics.geometry import ArmGeometry, Follower, Hand, NotFollowed, Point
from kinematics.limits import turn_near
from kinematics.paths.traces import BLEND_CHORDS, LineSegment, Round, Trace, cubic, round_through
from kinematics.spaces import Joints, Pose

# What the followers of every build share: turning the hand in proportion, and refusing leaps. If a
# hand is two angles, the first is its pitch and the second its roll, each of any turn.


def hand_near(pose: Pose, near: Hand) -> Hand:
    """Return a pose's pitch and roll, each the shorter way round from another hand."""
    return turn_near(pose.pitch_rad, near[0]), turn_near(pose.roll_rad, near[1])


def in_proportion(a: Hand, b: Hand, share: float) -> Hand:
    """Return the hand at a share (0 to 1) of the turn, both angles in proportion; b is exact."""
    if share >= 1.0:
        return b
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def refuse_leap(before: Joints, reached: Joints, most_rad: float) -> None:
    """Raise `NotFollowed` if a joint would turn by more than `most_rad` between waypoints."""
    name, turn_rad = largest_turn(before, reached)
    if turn_rad > most_rad:
        raise NotFollowed(leap_sentence(name, turn_rad, "the posture is singular there"))


def largest_turn(before: Joints, reached: Joints) -> tuple[str, float]:
    """Return the joint that turns furthest, and by how much."""
    turns = [abs(b - a) for a, b in zip(before, reached, strict=True)]
    furthest = max(turns)
    return reached.names[turns.index(furthest)], furthest


def leap_sentence(joint: str, turn_rad: float, why: str) -> str:
    """Return the reason for refusing to turn a joint so far in one step."""
    turn = f"{math.degrees(turn_rad):.0f}° at once"
    return f"the {joint.replace('_', ' ')} would have to turn by {turn}, because {why}"


T = TypeVar("T", bound=Trace, covariant=True)

LARGEST_BASE_TURN_RAD = 0.5
"""The furthest that the base may turn between two corners of a curve of the tip."""


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
        if turn <= LARGEST_BASE_TURN_RAD:
            return None
        return leap_sentence("base", turn, f"the {self.shape} meets the base axis")


Line = HandCurve[LineSegment]
"""A straight line of the tip."""


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
        if fraction >= 1.0:
            return self.points[-1]
        angles = tuple(each.angles_rad for each in self.points)
        if len(angles) == 2:
            moved = tuple(a + fraction * (b - a) for a, b in zip(*angles, strict=True))
        else:
            moved = cubic(angles, fraction)
        return Joints(moved, self.points[0].names)

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
    end = goal.x_mm, goal.y_mm, goal.z_mm
    return HandCurve(follower, LineSegment(start, end), (hand, follower.hand(goal, hand)))


Arc = HandCurve[Round]
"""An arc of the tip."""


def beginning(arm: ArmGeometry, start: Joints) -> tuple[Follower, Point]:
    """Return the follower of a start posture, and the position of the tip."""
    here = arm.fk(start)
    return arm.line(start, here).follower, (here.x_mm, here.y_mm, here.z_mm)


def arc_between(
    follower: Follower, tip: Point, hand: Hand, via: Pose, goal: Pose, sweep_rad: float | None
) -> Arc:
    """Return the arc from a tip and a hand; see `arc_path`. Raises `NoArc`."""
    middle, end = ((each.x_mm, each.y_mm, each.z_mm) for each in (via, goal))
    trace = round_through(tip, middle, end, sweep_rad)
    return HandCurve(follower, trace, (hand, follower.hand(goal, hand)))
