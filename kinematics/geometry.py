"""The interface of every arm that can be driven, whatever its build, and its refusals.

Units: mm and rad. Paths, guards, the driver and the simulator know an arm only by this interface.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, fields
from enum import Enum
from typing import Protocol

from kinematics.errors import KinematicsError, finite, limit_sentence, not_negative
from kinematics.frames.rotations import Matrix3
from kinematics.limits import JointRange, LimitViolation
from kinematics.spaces import Joints, Pose

Point = tuple[float, float, float]

# A tip nearer to the base axis than this is on the axis, where no direction is outwards.
#
# Rounding of a pose moves the tip by some 1e-13 mm, a motor step by 0.1 mm: the bound is far from
# both. On the axis the base may have any angle, which moves the tip by at most this distance.
AXIS_MM = 1e-6

# The orientation of the hand, as numbers of the follower that made them.
Hand = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Branch:
    """One posture that holds the hand at a pose, and the limits it would break.

    `name` says which one it is, in words if the arm's build has words for its postures.
    """

    name: str
    joints: Joints
    violations: tuple[LimitViolation, ...] = ()

    @property
    def within_limits(self) -> bool:
        """Whether the arm can take this posture."""
        return not self.violations

    @property
    def excess_rad(self) -> float:
        """The largest excess over a limit, 0 within the limits."""
        return max((violation.excess for violation in self.violations), default=0.0)


class NotFollowed(Exception):
    """The arm cannot follow in its present posture; the message says why."""


class Follower(Protocol):
    """One posture of an arm, such as elbow up, that is kept along curves of the tip."""

    @property
    def posture(self) -> str:
        """The posture in words; empty if the arm's build has no names for its postures."""

    @property
    def first(self) -> Hand:
        """The orientation of the hand at the start of the curve."""

    def hand(self, pose: Pose, near: Hand) -> Hand:
        """Return the hand's orientation in a pose, by the shorter turn from another orientation."""

    def between(self, a: Hand, b: Hand, share: float) -> Hand:
        """Return the orientation at a fraction (0 to 1) of the turn from one to another."""

    def pose(self, tip: Point, hand: Hand) -> Pose:
        """Return the pose of a tip and an orientation of the hand."""

    def solve(self, tip: Point, hand: Hand, before: Joints) -> Joints:
        """Return the posture for a tip and an orientation, near the previous posture.

        Raises `NotFollowed`.
        """


class Curve(Protocol):
    """A curve that an arm follows, solved point by point in one posture."""

    @property
    def shape(self) -> str:
        """The kind of curve, in words: a straight line, an arc."""

    @property
    def straight(self) -> bool:
        """Whether every joint turns in proportion, so that the ends describe the curve fully."""

    @property
    def least_chords(self) -> int:
        """How many equal parts the curve is cut into before it is examined."""

    def pose(self, fraction: float) -> Pose:
        """Return the curve's pose at a fraction (0 to 1) of its way."""

    def tip(self, fraction: float) -> Point:
        """Return the point of the curve at a fraction of its way."""

    def solve(self, fraction: float, before: Joints) -> Joints:
        """Return the posture at a fraction, near the one before; raises `PathBroken`."""

    def leap(self, before: Joints, reached: Joints) -> str | None:
        """Return why one joint motion may not lead from one posture to the next, or None."""


class ArmGeometry(Protocol):
    """An arm: joints with ranges, forward and inverse kinematics, and its points in space.

    An arm is a value: results computed for it may be cached with the arm as their key.
    """

    def __hash__(self) -> int: ...

    @property
    def limits(self) -> tuple[JointRange, ...]:
        """The range of each joint."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints from the table to the hand."""

    @property
    def has_yaw(self) -> bool:
        """Whether poses of this arm have a yaw."""

    @property
    def moving_points(self) -> tuple[str, ...]:
        """Names of the last of `points`, those that move, the tip at the end."""

    @property
    def meaning(self) -> Hashable:
        """The dimensions behind the joint angles, as a value with a stable `repr`."""

    def with_tool(self, tool: Tool) -> ArmGeometry:
        """Return this arm with a tool in its hand: poses are those of the tool's point."""

    def fk(self, joints: Joints) -> Pose:
        """Return the pose of a posture."""

    def ik(self, pose: Pose, seed: Joints | None = None) -> Joints:
        """Return a posture for a pose; raises `Unreachable`."""

    def ik_near(self, pose: Pose, seed: Joints) -> Joints:
        """Return the posture a small step from the seed, quickly; raises `Unreachable`."""

    def solve(self, pose: Pose, seed: Joints | None = None) -> Joints | None:
        """Return the result of `ik`, or None instead of an error."""

    def solve_near(self, pose: Pose, seed: Joints) -> Joints | None:
        """Return a posture a small step from the seed, quickly; None instead of an error."""

    def branches(self, pose: Pose, seed: Joints | None = None) -> tuple[Branch, ...]:
        """Return the postures for a pose, each angle of the allowed turn nearest to the seed.

        All of them, those beyond the limits included, where a closed form knows them; else the one
        nearest to the seed. Empty if no posture holds the hand there.
        """

    def nearest_pose(self, pose: Pose, seed: Joints | None = None) -> Pose:
        """Return a pose in reach near this one."""

    def points(self, joints: Joints) -> tuple[Point, ...]:
        """Return points of the arm from the table to the tip."""

    def violations(self, joints: Joints) -> tuple[LimitViolation, ...]:
        """Return the limits that a posture violates."""

    def hand_axes(self, joints: Joints) -> Matrix3:
        """Return the hand's up, side and along as the columns of a matrix in the base frame."""

    def follower(self, start: Joints) -> Follower:
        """Return the follower that keeps this posture along curves of the tip."""

    def travel_bound_mm(self, changes_rad: Sequence[float]) -> float:
        """Return a bound on the travel of any point while the joints turn by this together."""

    def levers_mm(self, joints: Joints | None) -> tuple[float, ...]:
        """Return each joint axis's distance from the tip; without a posture, the greatest possible.

        0 if turning the joint never moves the tip, whatever the others do.
        """


# A tool in the fingers: where its point is, seen from the finger tips.
#
# Lengths in mm, along the axes of the hand's frame (`closed_form`): `along` the hand, away from
# the wrist; `up` from the hand's back where the roll is zero; `side` completes a right-handed frame
# of up, side, along: for a hand that points outwards it is to the right.

# No tool is longer: the built-in arms reach less than half of it.
LONGEST_MM = 1000.0


@dataclass(frozen=True, slots=True)
class Tool:
    """The tool centre point, relative to the finger tips; all zero means no tool.

    `radius_mm` is the tool's thickness, for the guards that check links.
    """

    along_mm: float = 0.0
    up_mm: float = 0.0
    side_mm: float = 0.0
    radius_mm: float = 0.0

    def __post_init__(self) -> None:
        for each in fields(self):
            value = finite(f"tool.{each.name}", getattr(self, each.name))
            if abs(value) > LONGEST_MM:
                raise KinematicsError(
                    f"tool.{each.name} is within {LONGEST_MM:g} mm either way, not {value:g}"
                )
            object.__setattr__(self, each.name, value)
        not_negative("tool.radius_mm", self.radius_mm)

    def __bool__(self) -> bool:
        return any(self.offset_mm)

    @property
    def offset_mm(self) -> Point:
        """The point along the axes of the hand's frame: up, side, along."""
        return self.up_mm, self.side_mm, self.along_mm

    @property
    def beside_mm(self) -> float:
        """How far the point is from the hand's own line, about which the hand rolls."""
        return math.hypot(self.up_mm, self.side_mm)

    @property
    def reach_mm(self) -> float:
        """How far the point is from the finger tips."""
        return math.hypot(*self.offset_mm)


NO_TOOL = Tool()


# Refusals: poses out of reach, and paths that an arm cannot follow.


class Constraint(Enum):
    """Why a pose is out of reach."""

    TOO_FAR = "too far"
    TOO_NEAR = "too near"
    JOINT_LIMIT = "joint limit"
    NO_POSTURE = "no posture found"


class Unreachable(KinematicsError):
    """A pose that no posture within the limits reaches.

    `value`, `bound` and `excess` are in `unit` ("mm" for the distance of the wrist from the
    shoulder axis, or for how far the nearest posture that a search found stays away; "rad" for a
    joint's angle); `joint` is None unless a joint limit is the reason.
    `nearest` is a pose that can be reached: the nearest one of this pitch and roll, or, where
    none holds them, of the nearest pitch or roll that can be held. In a call of an arm, a joint
    motion leads there from the current posture; it is None if none does.
    """

    def __init__(
        self,
        reason: str,
        constraint: Constraint,
        value: float,
        bound: float,
        unit: str,
        *,
        goal: Pose,
        nearest: Pose | None,
        joint: str | None = None,
    ) -> None:
        self.reason = reason
        self.constraint = constraint
        self.joint = joint
        self.value = value
        self.bound = bound
        self.excess = abs(value - bound)
        self.unit = unit
        self.goal = goal
        self.nearest = nearest
        instead = ""
        if nearest is not None:
            held = " with this pitch" if nearest.pitch_rad == goal.pitch_rad else ""
            instead = f"; nearest pose that can be reached{held}: {nearest}"
        super().__init__(f"{goal} is out of reach: {reason}{instead}")

    @classmethod
    def by_limit(
        cls, joint: str, value: float, bound: float, goal: Pose, nearest: Pose
    ) -> Unreachable:
        """Return the refusal of a goal that needs a joint beyond its limit, in rad."""
        reason = limit_sentence(joint, value, bound)
        constraint = Constraint.JOINT_LIMIT
        return cls(reason, constraint, value, bound, "rad", goal=goal, nearest=nearest, joint=joint)

    def instead(self, nearest: Pose | None) -> Unreachable:
        """Return the same refusal with another nearest pose."""
        return Unreachable(
            self.reason,
            self.constraint,
            self.value,
            self.bound,
            self.unit,
            goal=self.goal,
            nearest=nearest,
            joint=self.joint,
        )


class PathBroken(KinematicsError):
    """A line, an arc, a blend or a part of a route that cannot be followed in one posture.

    `shape` says which of them it is ("straight line", "arc", "blend", "joint motion"), `fraction`
    (0 to 1) how far along its way it breaks, and `point` is the pose that it asks for there.
    `part` is the number, from 1, of the part of a route; a blend has that of the part before it.
    """

    def __init__(
        self,
        fraction: float,
        point: Pose,
        reason: str,
        *,
        shape: str = "straight line",
        part: int | None = None,
    ) -> None:
        self.fraction = fraction
        self.point = point
        self.reason = reason
        self.shape = shape
        self.part = part
        where = f" of part {part} of the route" if part is not None else ""
        super().__init__(
            f"the {shape}{where} breaks at {fraction:.0%} of its length, at {point}: {reason}; "
            f"{_WAYS_ROUND[shape]}"
        )

    def of_part(self, number: int) -> PathBroken:
        """Return the same refusal with the number of the part of a route that it is about."""
        return PathBroken(self.fraction, self.point, self.reason, shape=self.shape, part=number)


_WAYS_ROUND = {
    "straight line": "use a joint motion, or a line that keeps clear of this point",
    "arc": "use a joint motion, or an arc that keeps clear of this point",
    "blend": "use a smaller blend radius, or none",
    "joint motion": "choose another goal for it",
}
