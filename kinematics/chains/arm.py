"""An arm of five or six turning joints, of any build, driven by its link table.

Units: mm and rad. Inverse kinematics is found by numbers, from the seed first, so that the
posture near the seed is found where there is one; see chain_task.py for what its poses mean.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from kinematics.chains.chain import Chain
from kinematics.chains.generated import Generated, generated
from kinematics.chains.goals import Goal, Part
from kinematics.chains.inverse import Descent, Effort, First, Solution, account, solve_goal
from kinematics.chains.links import Convention, JointKind
from kinematics.chains.task import Task, goal_of, pose_of, task_of
from kinematics.errors import JointLimit, KinematicsError
from kinematics.frames.transforms import position_of, rotation_of
from kinematics.frames.vectors import Vector, cross, norm, subtract
from kinematics.geometry import Point
from kinematics.limits import JointRange, LimitViolation
from kinematics.spaces import Joints, Pose

if TYPE_CHECKING:
    from kinematics.frames.rotations import Matrix3
    from kinematics.paths.curves import Line

EFFORT = Effort(starts=16)
"""Postures tried before a pose is called out of reach: a person is waiting for the answer."""

HAND_FIRST: First = (
    frozenset({Part.HEADING, Part.PITCH, Part.ROLL}),
    frozenset({Part.POSITION}),
)
"""Where not all can be met, hold the hand as asked and come as near as that lets the arm."""

AT_ONCE_RAD = 0.5
"""The furthest that a joint may turn in one small step; further is another posture."""

LENGTH_MM = 1e-9
"""A link shorter than this moves no point."""

LEAST_LEVER_MM = 1e-6
"""An axis through the tip may leave it as soon as other joints turn: it still counts as a lever."""


@dataclass(frozen=True, slots=True)
class ChainArm:
    """A chain that is driven. Raises `KinematicsError` for one that cannot be.

    It needs five or six turning joints, each with both limits.
    """

    chain: Chain
    limits: tuple[JointRange, ...] = field(init=False)
    task: Task = field(init=False)
    moving_points: tuple[str, ...] = field(init=False, compare=False)
    _shown: tuple[int, ...] = field(init=False, repr=False, compare=False)
    _made: Generated = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "task", task_of(self.chain))
        object.__setattr__(self, "limits", _limits(self.chain))
        names, shown = _moving(self.chain)
        object.__setattr__(self, "moving_points", names)
        object.__setattr__(self, "_shown", shown)
        object.__setattr__(self, "_made", generated(self.chain))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints from the table to the hand."""
        return self.chain.joint_names

    @property
    def has_yaw(self) -> bool:
        """Whether poses of this arm have a yaw: those of six joints."""
        return self.task is Task.WHOLE

    @property
    def meaning(self) -> Chain:
        """The link table, which gives joint angles their meaning, without the limits."""
        free = tuple(replace(link, low=-math.inf, high=math.inf) for link in self.chain.links)
        return replace(self.chain, links=free)

    @property
    def centre(self) -> Vector:
        """A point of the base axis, from which outwards is counted."""
        return position_of(self.chain.base)

    def with_limits(self, limits: Sequence[JointRange]) -> ChainArm:
        """Return this arm with other ranges of its joints."""
        links = tuple(
            replace(link, low=one.low_rad, high=one.high_rad)
            for link, one in zip(self.chain.links, limits, strict=True)
        )
        return ChainArm(replace(self.chain, links=links))

    def fk(self, joints: Joints) -> Pose:
        """Return the pose of a posture."""
        return pose_of(self._made.fk(self._values(joints)), self.task, self.centre)

    def ik(self, pose: Pose, seed: Joints | None = None) -> Joints:
        """Return a posture within the limits, the one near the seed where there is one.

        Raises `Unreachable` with the nearest pose that was found, and `KinematicsError` for a
        yaw that is missing or that this arm cannot take. Without a seed the middle of the ranges
        stands for it.
        """
        found = self._hunt(pose, seed)
        if found.ok:
            return self.joints_of(found.joints)
        from kinematics.chains.task import chain_refusal  # it looks at arms

        raise chain_refusal(self, pose, found)

    def ik_near(self, pose: Pose, seed: Joints) -> Joints:
        """Return the posture a small step from the seed, by one descent; raises `Unreachable`."""
        found = self.meet(self.goal(pose), seed)
        joints = self.joints_of(found.joints)
        turned = max(abs(b - a) for a, b in zip(seed, joints, strict=True))
        if found.ok and turned <= AT_ONCE_RAD:
            return joints
        from kinematics.chains.task import step_refusal  # it looks at arms

        raise step_refusal(self, pose, found, seed)

    def solve(self, pose: Pose, seed: Joints | None = None) -> Joints | None:
        """Return what `ik` does, or None without reasons."""
        found = self._hunt(pose, seed)
        return self.joints_of(found.joints) if found.ok else None

    def nearest_pose(self, pose: Pose, seed: Joints | None = None) -> Pose:
        """Return the pose in reach, the hand held as asked where it can be, that was found."""
        from kinematics.chains.task import nearest_of  # it looks at arms

        found = self._hunt(pose, seed)
        return pose if found.ok else nearest_of(self, pose, found)

    def goal(self, pose: Pose) -> Goal:
        """Return what a pose asks of the hand."""
        return goal_of(pose, self.task, self.centre)

    def meet(self, goal: Goal, seed: Joints, chain: Chain | None = None) -> Solution:
        """Return where one descent from the seed ends; `chain` may have other limits."""
        chain = chain or self.chain
        values = Descent(chain, goal, ()).meet(self._values(seed))
        return account(chain, goal, values, EFFORT.tolerance_mm, EFFORT.tolerance_rad, 1)

    def joints_of(self, values: Sequence[float]) -> Joints:
        """Return joint values by this arm's names."""
        return Joints(tuple(values), self.joint_names)

    def points(self, joints: Joints) -> tuple[Point, ...]:
        """Return the foot on the table, the origins of the frames that differ, and the tip."""
        frames = self.chain.frames(self._values(joints))
        base = position_of(frames[0])
        foot = () if abs(base[2]) <= LENGTH_MM else ((base[0], base[1], 0.0),)
        origins = tuple(position_of(frames[index]) for index in self._shown)
        return (*foot, base, *origins, position_of(self._made.fk(self._values(joints))))

    def violations(self, joints: Joints) -> tuple[LimitViolation, ...]:
        """Return the limits that a posture breaks."""
        return tuple(
            LimitViolation(one.joint, one.value, one.bound)
            for one in self.chain.violations(self._values(joints))
        )

    def check(self, joints: Joints) -> None:
        """Raise `JointLimit` for the joint that passes its limit furthest, if any does."""
        broken = self.violations(joints)
        if broken:
            worst = max(broken, key=lambda violation: violation.excess_rad)
            raise JointLimit(worst.joint, worst.value_rad, worst.bound_rad)

    def hand_axes(self, joints: Joints) -> Matrix3:
        """Return the axes of the hand's frame as the columns of a matrix in the base frame."""
        return rotation_of(self._made.fk(self._values(joints)))

    def line(self, start: Joints, goal: Pose) -> Line:
        """Return the straight line from a posture to a pose."""
        from kinematics.chains.follow import chain_line  # a line is made of an arm

        return chain_line(self, start, goal)

    def travel_bound_mm(self, changes_rad: Sequence[float]) -> float:
        """Return a distance that no point exceeds while the joints turn by this much."""
        levers = _longest_levers(self.chain)
        return sum(abs(turn) * lever for turn, lever in zip(changes_rad, levers, strict=True))

    def levers_mm(self, joints: Joints | None) -> tuple[float, ...]:
        """Return each joint axis's distance from the tip; of no posture, the most there can be.

        0 where turning the joint never moves the tip, whatever the others do.
        """
        longest = _longest_levers(self.chain)
        if joints is None:
            return longest
        values = self._values(joints)
        tip = position_of(self._made.fk(values))
        return tuple(
            max(norm(cross(axis, subtract(tip, point))), LEAST_LEVER_MM) if most > 0.0 else 0.0
            for (point, axis), most in zip(self.chain.axes(values), longest, strict=True)
        )

    def _hunt(self, pose: Pose, seed: Joints | None) -> Solution:
        near = None if seed is None else self._values(seed)
        return solve_goal(self.chain, self.goal(pose), near, first=HAND_FIRST, effort=EFFORT)

    def _values(self, joints: Joints) -> tuple[float, ...]:
        if len(joints.angles_rad) != len(self.chain):
            raise KinematicsError(f"this arm has {len(self.chain)} joints, not {len(joints)}")
        return joints.angles_rad


def _limits(chain: Chain) -> tuple[JointRange, ...]:
    for name, kind, bounds in zip(chain.joint_names, chain.kinds, chain.limits, strict=True):
        if kind is not JointKind.REVOLUTE:
            raise KinematicsError(f"joint {name!r} slides: only arms whose joints turn are driven")
        if not all(map(math.isfinite, bounds)):
            raise KinematicsError(f"joint {name!r} has no limits: an arm that is driven needs them")
    return tuple(JointRange(low, high) for low, high in chain.limits)


def _moving(chain: Chain) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Return names of the origins that are not the one before them, the tip's too, and which.

    In the standard convention frame i stands on the axis of joint i + 1, in Craig's on that of
    joint i.
    """
    standard = chain.convention is Convention.STANDARD
    names, shown = [], []
    for index, link in enumerate(chain.links, 1):
        apart = math.hypot(link.a_mm, link.d_mm) > LENGTH_MM
        ends_at_tip = index == len(chain) and norm(position_of(chain.tool)) <= LENGTH_MM
        if apart and not ends_at_tip:
            after = chain.joint_names[index:] if standard else chain.joint_names[index - 1 :]
            names.append(after[0].replace("_", " ") if after else "flange")
            shown.append(index)
    return (*names, "tip"), tuple(shown)


def _longest_levers(chain: Chain) -> tuple[float, ...]:
    """Return how far from each joint's axis the arm beyond it can reach, the tip included.

    A joint's own distance along its axis is no lever; in Craig's convention neither is the length
    of its row, which comes before the joint.
    """
    standard = chain.convention is Convention.STANDARD
    beyond = norm(position_of(chain.tool))
    tool_x, tool_y, _ = position_of(chain.tool)
    across = math.hypot(tool_x, tool_y)  # about the last axis, as long as nothing tilts it
    found = []
    for index, link in reversed(list(enumerate(chain.links))):
        own = abs(link.a_mm) if standard else 0.0
        last = index == len(chain) - 1
        aligned = last and (not standard or abs(math.sin(link.alpha_rad)) <= LENGTH_MM)
        found.append(own + (across if aligned else beyond))
        beyond += math.hypot(link.a_mm, link.d_mm)
    return tuple(reversed(found))
