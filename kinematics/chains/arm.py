"""An arm of five or six turning joints, of any build, driven by its link table.

Units: mm and rad. Inverse kinematics uses the closed form if the table has one. Otherwise it is
numerical and starts from the seed, so that a posture near the seed is found first. `HandTask`
defines the meaning of such an arm's poses. Below the arm: its postures along a curve of the tip and
a small step away, and its refusals.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from kinematics.chains.chain import Chain
from kinematics.chains.closed_form import ClosedForm, closed_form
from kinematics.chains.descent import QUICK, Descent
from kinematics.chains.evaluation import Evaluator, evaluator
from kinematics.chains.goals import Goal, HandTask, goal_of, pose_of, task_of
from kinematics.chains.inverse import Reason, Solution, descend, middle, solve_goal
from kinematics.chains.links import Convention, JointKind
from kinematics.errors import KinematicsError, require
from kinematics.frames.orientations import Quaternion, quaternion_of
from kinematics.frames.rotations import Matrix3
from kinematics.frames.transforms import (
    compose,
    homogeneous,
    position_of,
    rotation_of,
    translation,
    z_axis_of,
)
from kinematics.frames.vectors import Vector, cross, norm, subtract
from kinematics.geometry import Branch, Constraint, Hand, Point, Tool, Unreachable
from kinematics.limits import (
    JointRange,
    LimitViolation,
    few_turns_each,
    widened_to,
)
from kinematics.paths.curves import LEAP_RAD, NearFollower, largest_turn, leap_sentence
from kinematics.spaces import Joints, Pose, angles_of
from kinematics.text import shown_name

# Postures tried before a pose is called out of reach: a person is waiting for the answer.
STARTS = 16

# A link shorter than this moves no point.
LENGTH_MM = 1e-9

# The lever of an axis through the tip: not 0, because other joints may move the tip away.
LEAST_LEVER_MM = 1e-6


@dataclass(frozen=True, slots=True)
class ChainArm:
    """A chain that is driven. Raises `KinematicsError` for one that cannot be.

    It needs five or six turning joints, each with both limits.
    """

    chain: Chain
    limits: tuple[JointRange, ...] = field(init=False)
    task: HandTask = field(init=False)
    moving_points: tuple[str, ...] = field(init=False, compare=False)
    _shown: tuple[int, ...] = field(init=False, repr=False, compare=False)
    _evaluator: Evaluator = field(init=False, repr=False, compare=False)
    closed: ClosedForm | None = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        require("a chain", self.chain, Chain, "Chain((DHLink(a_mm=200.0),))")
        object.__setattr__(self, "task", task_of(self.chain))
        object.__setattr__(self, "limits", _limits(self.chain))
        names, shown = _moving(self.chain)
        object.__setattr__(self, "moving_points", names)
        object.__setattr__(self, "_shown", shown)
        object.__setattr__(self, "_evaluator", evaluator(self.chain))
        object.__setattr__(self, "closed", closed_form(self.chain))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints from the table to the hand."""
        return self.chain.joint_names

    @property
    def has_yaw(self) -> bool:
        """Whether poses of this arm have a yaw: those of six joints."""
        return self.task is HandTask.WHOLE

    @property
    def meaning(self) -> Chain:
        """The link table, which gives joint angles their meaning, without the limits."""
        return self.chain.within()

    @property
    def centre(self) -> Vector:
        """A point of the base axis, from which outwards is counted."""
        return position_of(self.chain.base)

    def with_tool(self, tool: Tool) -> ChainArm:
        """Return this arm with a tool in its hand: poses are those of the tool's point."""
        off = translation(*tool.offset_mm)
        return ChainArm(replace(self.chain, tool=compose(self.chain.tool, off)))

    def fk(self, joints: Joints) -> Pose:
        """Return the pose of a posture."""
        return pose_of(self._evaluator.fk(self._directions(joints)), self.task, self.centre)

    def ik(self, pose: Pose, seed: Joints | None = None) -> Joints:
        """Return a posture within the limits, the one near the seed where there is one.

        Raises `Unreachable` with the nearest pose that was found, and `KinematicsError` for a
        yaw that is missing or that this arm cannot take. Without a seed the middle of the ranges
        stands for it.
        """
        found = self._found(pose, seed)
        if isinstance(found, Solution):
            raise _refusal(self, pose, found)
        return found

    def ik_near(self, pose: Pose, seed: Joints) -> Joints:
        """Return the posture a small step from the seed; raises `Unreachable`."""
        joints = self.solve_near(pose, seed)
        if joints is None:
            found = descend(self.chain, self.goal(pose), self._values(seed))
            if not found.ok:
                raise _refusal(self, pose, found)
            joints = self.joints_of(found.joints)
        name, turn = largest_turn(seed, joints)
        if turn > LEAP_RAD:
            reason = leap_sentence(name, turn, "the posture is singular here")
            kind, here = Constraint.NO_POSTURE, self.fk(seed)
            raise Unreachable(reason, kind, turn, 0.0, "rad", goal=pose, nearest=here)
        return joints

    def solve(self, pose: Pose, seed: Joints | None = None) -> Joints | None:
        """Return what `ik` does, or None without reasons."""
        found = self._found(pose, seed)
        return None if isinstance(found, Solution) else found

    def solve_near(self, pose: Pose, seed: Joints) -> Joints | None:
        """Return a posture a small step from the seed, quickly, or None; see `near_posture`."""
        try:
            goal = self.goal(pose)
        except KinematicsError:
            return None
        closed = self.closed
        if closed is not None and closed.solves(goal):
            found = closed.nearest(goal, seed.angles_rad)
        else:
            found = near_posture(self.chain, goal, seed.angles_rad)
        return None if found is None else self.joints_of(found)

    def branches(self, pose: Pose, seed: Joints | None = None) -> tuple[Branch, ...]:
        """Return all postures for a pose in closed form, else the one nearest to the seed."""
        goal, closed = self.goal(pose), self.closed
        if closed is None or not closed.solves(goal):
            joints = self.solve(pose, seed)
            return () if joints is None else (Branch("", joints),)
        found = map(self.joints_of, closed.branches(goal, self._start(seed)))
        return tuple(
            Branch(f"solution {number}", joints, self.violations(joints))
            for number, joints in enumerate(found, 1)
        )

    def nearest_pose(self, pose: Pose, seed: Joints | None = None) -> Pose:
        """Return the pose in reach, the hand held as asked where it can be, that was found."""
        found = self._found(pose, seed)
        return _nearest_of(self, pose, found) if isinstance(found, Solution) else pose

    def goal(self, pose: Pose) -> Goal:
        """Return what a pose asks of the hand."""
        return goal_of(pose, self.task, self.centre)

    def joints_of(self, values: Sequence[float]) -> Joints:
        """Return joint values by this arm's names."""
        return Joints(tuple(values), self.joint_names)

    def points(self, joints: Joints) -> tuple[Point, ...]:
        """Return the foot on the table, the origins of the frames that differ, and the tip."""
        frames = self.chain.frames(self._directions(joints))
        base = position_of(frames[0])
        foot = () if abs(base[2]) <= LENGTH_MM else ((base[0], base[1], 0.0),)
        origins = tuple(position_of(frames[index]) for index in self._shown)
        return (*foot, base, *origins, position_of(compose(frames[-1], self.chain.tool)))

    def violations(self, joints: Joints) -> tuple[LimitViolation, ...]:
        """Return the limits that a posture breaks."""
        return self.chain.violations(self._values(joints))

    def hand_axes(self, joints: Joints) -> Matrix3:
        """Return the axes of the hand's frame as the columns of a matrix in the base frame."""
        return rotation_of(self._evaluator.fk(self._directions(joints)))

    def follower(self, start: Joints) -> NearFollower:
        """Return what keeps a posture along curves of the tip that begin in it."""
        wide = self._widened(start)
        if self.has_yaw:
            whole = _four(quaternion_of(self.hand_axes(start)))
            return WholeHandFollower(wide, whole, WAYPOINT_TURN_RAD)
        origin = self.fk(start)
        return NearFollower(wide, (origin.pitch_rad, origin.roll_rad), WAYPOINT_TURN_RAD)

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
        *frames, tool = self._evaluator.frames(self._directions(joints))
        tips = (subtract(position_of(tool), position_of(frame)) for frame in frames)
        return tuple(
            max(norm(cross(z_axis_of(frame), tip)), LEAST_LEVER_MM) if most > 0.0 else 0.0
            for frame, tip, most in zip(frames, tips, longest, strict=True)
        )

    def _found(self, pose: Pose, seed: Joints | None) -> Joints | Solution:
        """Return the posture for a pose, or the account of the best one if none holds it."""
        near = self._start(seed)
        found = solve_goal(self.chain, self.goal(pose), near, hand_first=True, starts=STARTS)
        return self.joints_of(found.joints) if found.ok else found

    def _start(self, seed: Joints | None) -> tuple[float, ...]:
        """Return the values near which to look: the seed's, or the middle of the ranges."""
        return middle(self.chain) if seed is None else self._values(seed)

    def _widened(self, start: Joints) -> ChainArm:
        """Return the arm with its limits widened to a posture beyond them."""
        if not self.chain.violations(start.angles_rad):
            return self
        wide = widened_to(self.limits, start)
        return ChainArm(self.chain.within((one.low_rad, one.high_rad) for one in wide))

    def _values(self, joints: Joints) -> tuple[float, ...]:
        return angles_of(joints, self.joint_names)

    def _directions(self, joints: Joints) -> tuple[float, ...]:
        """Return the angles, those of many turns as the same direction: formulas add them."""
        return few_turns_each(self._values(joints))


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
            names.append(shown_name(after[0]) if after else "flange")
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


# The posture of a link table near another: all along a curve of the tip, or a small step away.
#
# Five joints take pitch and roll in proportion, each the shorter way round: a hand is the two
# angles, of any turn. Six turn the hand about one axis, the shorter way, which no angle's own
# degeneracy disturbs: a hand is the unit quaternion of its rotation.

# The furthest that a joint may turn between two waypoints, so that the hand's direction, which
# is no sum of joint angles here, stays within some thousandths of a rad of the line's.
WAYPOINT_TURN_RAD = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class WholeHandFollower(NearFollower):
    """The posture near the one before, of an arm of six joints."""

    arm: ChainArm

    def hand(self, pose: Pose, near: Hand) -> Hand:
        """Return how a pose holds the hand, the shorter way round; refuses one without a yaw."""
        turn = _four(quaternion_of(rotation_of(self.arm.goal(pose).frame)))
        opposite = sum(a * b for a, b in zip(near, turn, strict=True)) < 0.0
        return tuple(-part for part in turn) if opposite else turn

    def between(self, a: Hand, b: Hand, share: float) -> Hand:
        """Return the hand at a share of the turn about one axis; b is exact."""
        return _turned(a, b, share) if share < 1.0 else b

    def pose(self, tip: Point, hand: Hand) -> Pose:
        """Return the pose of a tip and a hand."""
        frame = homogeneous(Quaternion(*hand).rotation(), tip)
        return pose_of(frame, self.arm.task, self.arm.centre)


def _four(turn: Quaternion) -> Hand:
    return turn.w, turn.x, turn.y, turn.z


def _turned(a: Hand, b: Hand, share: float) -> Hand:
    """Return the unit quaternion at a share of the turn about one axis (Shoemake, 1985).

    The angle is that of half difference and half sum, which is exact for small turns.
    """
    apart = math.dist(a, b)
    half = 2.0 * math.atan2(apart, math.hypot(*map(float.__add__, a, b)))
    if half == 0.0:
        return a
    sine = math.sin(half)
    first, second = math.sin((1.0 - share) * half) / sine, math.sin(share * half) / sine
    return tuple(first * one + second * two for one, two in zip(a, b, strict=True))


# The posture of a chain a small step from one that is known, quickly, or none. A jog asks for this
# many times in each leg, also for points that cannot be reached, and has no time for reasons:
# `ik_near` gives those.

# How far from a joint's limit the second look begins.
INSIDE_RAD = 0.05


def near_posture(chain: Chain, goal: Goal, start: Sequence[float]) -> tuple[float, ...] | None:
    """Return the posture within the limits a small step from a start that meets a goal, or None.

    A singular posture is often one with a joint at its limit, as a straight elbow is: no slope
    leads out of it, so that a look from further inside comes second.
    """
    descent = Descent(chain, goal)
    found = descent.met(start, QUICK)
    if found is not None:
        return found
    inside = [
        min(max(value, low + INSIDE_RAD), high - INSIDE_RAD)
        for value, (low, high) in zip(start, chain.limits, strict=True)
    ]
    return descent.met(inside, QUICK) if inside != list(start) else None


# Why an arm given by its link table cannot take a pose, and which pose it can take instead.
#
# A closed form without a solution proves that the pose is out of reach. A search proves nothing,
# and the message says so.

# An angle of the hand nearer to the goal's than this counts as equal.
HELD_RAD = 1e-6


def _refusal(arm: ChainArm, pose: Pose, found: Solution) -> Unreachable:
    """Return the error that explains the best posture found for a pose."""
    nearest = _nearest_of(arm, pose, found)
    if found.reason is Reason.BEYOND_REACH:
        centre, radius = arm.chain.reach_sphere
        away = math.dist(pose.position_mm, centre)
        reason = (
            f"the tip would be {away - radius:.1f} mm beyond the {radius:.1f} mm that all links "
            "together span"
        )
        return Unreachable(
            reason, Constraint.TOO_FAR, away, radius, "mm", goal=pose, nearest=nearest
        )
    if found.reason is Reason.JOINT_LIMIT and found.violations:
        worst = max(found.violations, key=lambda one: one.excess)
        return Unreachable.by_limit(worst.joint, worst.value, worst.bound, pose, nearest)
    if found.residual_rad > HELD_RAD:
        value, unit = found.residual_rad, "rad"
        misses = f"misses the hand's direction by {math.degrees(value):.2f}°"
    else:
        value, unit = math.dist(pose.position_mm, nearest.position_mm), "mm"
        misses = f"stays {value:.2f} mm away"
    proved = found.reason is Reason.NO_POSTURE
    reason = "no posture meets this" if proved else "no posture was found"
    reason += f"; the nearest posture {misses}"
    if found.at_limit:
        reason += f", with the {shown_name(found.at_limit[0])} at its limit"
    return Unreachable(reason, Constraint.NO_POSTURE, value, 0.0, unit, goal=pose, nearest=nearest)


def _nearest_of(arm: ChainArm, pose: Pose, found: Solution) -> Pose:
    """Return the pose of the best posture found, in the goal's own angles where they are held.

    A tip on the other side of the base axis than the goal holds another pitch and roll, although
    its hand points where the goal's does.
    """
    reached = pose_of(found.frame, arm.task, arm.centre)
    pairs = (
        (pose.pitch_rad, reached.pitch_rad),
        (pose.roll_rad, reached.roll_rad),
        (pose.yaw_rad or 0.0, reached.yaw_rad or 0.0),
    )
    if all(abs(math.remainder(a - b, math.tau)) <= HELD_RAD for a, b in pairs):
        return replace(pose, x_mm=reached.x_mm, y_mm=reached.y_mm, z_mm=reached.z_mm)
    return reached
