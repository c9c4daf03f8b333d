"""Resolving moves: from a request to an absolute move, and to its plan.

An absolute move means the same from any position: it is in the base frame, gives every joint, and
names no saved point. Only absolute moves are planned, previewed, executed and journalled, so that a
relative request is never applied twice. `prepare` resolves and plans a whole move; each step of a
sequence starts at the end of the previous one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import PARK_HEIGHT_MM
from armdrive.errors import BadRequest, OutOfBounds, Refused
from armdrive.motion.frames import goal_in_base
from armdrive.motion.jog.course import stride
from armdrive.motion.plan import (
    MotionPlan,
    SpeedLimits,
    named_joints,
    plan_joints,
    plan_line,
    plan_route,
    posture_for,
)
from armdrive.moves import (
    BASE_FRAME,
    TOOL_FRAME,
    ArcMove,
    GraspMove,
    GripperMove,
    JogMove,
    JointMove,
    LineMove,
    Move,
    MoveSequence,
    ParkMove,
    PathMove,
    PoseMove,
    SingleMove,
    Space,
    in_order,
)
from armdrive.runtime.position import ArmCoordinates, alike
from kinematics.geometry import PathBroken, Unreachable
from kinematics.paths.routes import ArcPart, JointPart, PathPart
from kinematics.spaces import Joints, Pose

ALIKE_RAD = math.radians(0.5)  # joints within this angle are in the posture of a saved point

OTHER_POSTURE = (
    "this is the point's pose in another posture, because a straight line keeps its posture"
)

SAME_IN_EVERY_FRAME = "a saved point is a set of joint angles, which are the same in every frame"

PARK_RISE_MM = 60.0  # `park` rises this far first if a guard is in its way


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """What a move is resolved against: the arm, its speeds, its points and its present position."""

    config: ArmConfig
    speeds: SpeedLimits
    here: ArmCoordinates
    point: Callable[[str], Joints]
    """Returns the joint angles of a named point; raises `UnknownPoint`."""

    def at(self, here: ArmCoordinates) -> Ground:
        """Return the same ground with the arm at another position."""
        return replace(self, here=here)

    def in_base(self, pose: Pose, frame: str) -> Pose:
        """Convert a pose from a frame to the base frame."""
        return goal_in_base(self.config, self.here.joints, pose, frame)

    def posture(self, joints: Joints) -> Joints:
        """Return the angles of all joints in the arm's order. Raises `BadRequest` for others."""
        return in_order(joints, self.config.model.arm.joint_names)


# Resolving.


def resolve(move: SingleMove, ground: Ground) -> SingleMove:
    """Return the absolute form of a move. Resolving it again changes nothing.

    Raises `UnknownPoint`, and `BadRequest` for a joint or a frame that the arm does not have.
    `ParkMove` and `JogMove` depend on obstacles: `prepare` resolves them while planning.
    """
    match move:
        case JointMove(goal=Mapping() as angles):
            return replace(move, goal=named_joints(ground.here.joints, angles))
        case JointMove(goal=Joints() as joints):
            return replace(move, goal=ground.posture(joints))
        case PoseMove():
            goal = _goal(move.goal, move.frame, ground)
            if isinstance(goal, Joints):
                return JointMove(goal, move.speed)
            return PoseMove(goal, move.speed)
        case LineMove():
            return LineMove(_goal(move.goal, move.frame, ground), move.speed)
        case ArcMove():
            via, goal = (ground.in_base(pose, move.frame) for pose in (move.via, move.goal))
            return ArcMove(via, goal, move.speed)
        case PathMove():
            parts = tuple(_part_in_base(part, move.frame, ground) for part in move.parts)
            return PathMove(parts, move.speed)
        case GripperMove(opening_mm=None):
            return replace(move, opening_mm=ground.config.model.gripper_range_mm[1])
        case _:
            return move


def resolved(move: Move, ground: Ground) -> Move:
    """Return the absolute form of any move, planning it only if necessary.

    Planning is necessary for `park`, for an increment, and for a sequence in which a move depends
    on where the previous one ends.
    """
    if _needs_plan(move):
        return prepare(move, ground).resolved
    if isinstance(move, MoveSequence):
        return MoveSequence(tuple(resolve(each, ground) for each in move.moves))
    return resolve(move, ground)


def _needs_plan(move: Move) -> bool:
    if isinstance(move, MoveSequence):
        first, *rest = move.moves
        return _needs_plan(first) or any(map(_is_relative, rest))
    return isinstance(move, ParkMove | JogMove)


def _is_relative(move: SingleMove) -> bool:
    """Return whether the meaning of a move depends on the arm's position."""
    match move:
        case JointMove(goal=Mapping()) | ParkMove() | JogMove():
            return True
        case PoseMove(frame=frame) | LineMove(frame=frame) | ArcMove(frame=frame):
            return frame == TOOL_FRAME
        case _:
            return False


def _goal(goal: str | Pose | Joints, frame: str, ground: Ground) -> Pose | Joints:
    """Return a goal in the base frame; the joint angles of a point, which are so in every frame."""
    if isinstance(goal, Pose):
        return ground.in_base(goal, frame)
    if isinstance(goal, Joints):
        return ground.posture(goal)
    if frame != BASE_FRAME:
        raise BadRequest(SAME_IN_EVERY_FRAME)
    return ground.posture(ground.point(goal))


def _part_in_base(part: PathPart, frame: str, ground: Ground) -> PathPart:
    if isinstance(part, JointPart):
        return replace(part, goal=ground.posture(part.goal))
    goal = ground.in_base(part.goal, frame)
    if isinstance(part, ArcPart):
        return replace(part, goal=goal, via=ground.in_base(part.via, frame))
    return replace(part, goal=goal)


def is_cartesian(move: Move) -> bool:
    """Return whether a move depends on the arm's lengths."""
    match move:
        case MoveSequence():
            return any(map(is_cartesian, move.moves))
        case PoseMove():
            return isinstance(move.goal, Pose)
        case JogMove():
            return move.jog.space is Space.CARTESIAN
        case _:
            return isinstance(move, LineMove | ArcMove | PathMove | ParkMove)


def pose_of(move: SingleMove, ground: Ground) -> Pose | None:
    """Return the goal pose of an absolute move; None if its goal is joint angles."""
    match move:
        case PoseMove(goal=Pose() as pose) | LineMove(goal=Pose() as pose) | ArcMove(goal=pose):
            return pose
        case LineMove(goal=Joints() as joints):
            return ground.config.model.arm.fk(joints)
        case _:
            return None


# Planning.


@dataclass(frozen=True, slots=True)
class PlannedStep:
    """An absolute move and its audited plan.

    There is no plan for a grasp, which ends at the object, and for fingers without a stepper motor.
    """

    move: SingleMove
    plan: MotionPlan | None


@dataclass(frozen=True, slots=True)
class PlannedMove:
    """A move, resolved and audited as a whole. Nothing has been sent yet."""

    steps: tuple[PlannedStep, ...]

    @property
    def resolved(self) -> Move:
        """The absolute move."""
        moves = tuple(step.move for step in self.steps)
        return moves[0] if len(moves) == 1 else MoveSequence(moves)

    @property
    def plans(self) -> tuple[MotionPlan, ...]:
        """The plans of the steps, end to end."""
        return tuple(step.plan for step in self.steps if step.plan is not None)

    @property
    def plan(self) -> MotionPlan | None:
        """All legs as one plan; None if no step can be planned."""
        if not self.plans:
            return None
        legs = tuple(leg for plan in self.plans for leg in plan.legs)
        notes = "; ".join(filter(None, (plan.note for plan in self.plans)))
        return MotionPlan(self.plans[0].start, legs, notes)

    @property
    def duration_s(self) -> float:
        """The total duration of the plans."""
        return math.fsum(plan.duration_s for plan in self.plans)


def prepare(move: Move, ground: Ground) -> PlannedMove:
    """Resolve a move from the arm's position, then plan and audit all of it.

    Raises the reason if any part is refused; nothing is executed then.
    """
    match move:
        case MoveSequence():
            steps: list[PlannedStep] = []
            for each in move.moves:
                made = prepare(each, ground)
                steps += made.steps
                ground = ground.at(made.plans[-1].end if made.plans else ground.here)
            return PlannedMove(tuple(steps))
        case ParkMove():
            return _prepared_park(move, ground)
        case JogMove():
            return _prepared_jog(move, ground)
        case _:
            absolute = resolve(move, ground)
            with naming_frame(move):
                return PlannedMove((PlannedStep(absolute, plan_of(absolute, ground)),))


@contextmanager
def naming_frame(move: Move) -> Iterator[None]:
    """Add to a refusal with poses that they are in the base frame, if the move's goal is not."""
    try:
        yield
    except (Unreachable, PathBroken, OutOfBounds) as refusal:
        has_pose = not isinstance(refusal, OutOfBounds) or refusal.nearest is not None
        if has_pose and getattr(move, "frame", BASE_FRAME) != BASE_FRAME:
            refusal.args = (f"{refusal.args[0]} (in the base frame)",)
        raise


def plan_of(move: SingleMove, ground: Ground) -> MotionPlan | None:
    """Return the audited plan of an absolute move; None if it cannot be planned."""
    config, speeds, here = ground.config, ground.speeds, ground.here
    match move:
        case JointMove(goal=Joints() as joints):
            end = ArmCoordinates(joints, here.opening_mm)
            return plan_joints(config, speeds, here, end, move.speed)
        case PoseMove(goal=Pose() as pose):
            end = ArmCoordinates(posture_for(config, pose, here.joints), here.opening_mm)
            return plan_joints(config, speeds, here, end, move.speed)
        case LineMove(goal=Pose() as pose):
            return plan_line(config, speeds, here, pose, move.speed)
        case LineMove(goal=Joints() as joints):
            made = plan_line(config, speeds, here, config.model.arm.fk(joints), move.speed)
            same = alike(made.end.joints, joints, ALIKE_RAD)
            return made if same else replace(made, note=OTHER_POSTURE)
        case ArcMove():
            return plan_route(config, speeds, here, [ArcPart(move.via, move.goal)], move.speed)
        case PathMove():
            return plan_route(config, speeds, here, move.parts, move.speed)
        case GripperMove(opening_mm=float() as opening_mm) if (
            ground.speeds.transmission.has_gripper
        ):
            end = ArmCoordinates(here.joints, opening_mm)
            return plan_joints(config, speeds, here, end, move.speed)
        case GripperMove() | GraspMove():
            return None
        case _:
            raise BadRequest(f"{move} is not absolute yet: resolve it first")


def _prepared_park(move: ParkMove, ground: Ground) -> PlannedMove:
    """Plan the motion to the park pose; if a guard is in the way, rise first."""
    there = PoseMove(move.goal or park_pose(ground.config), move.speed)
    try:
        return prepare(there, ground)
    except OutOfBounds:
        above = raised(ground.config.model.arm.fk(ground.here.joints), PARK_RISE_MM)
        return prepare(MoveSequence((LineMove(above, move.speed), there)), ground)


def _prepared_jog(move: JogMove, ground: Ground) -> PlannedMove:
    """Plan an increment as far as the bounds allow; its end point is the absolute goal."""
    made = stride(ground.config, ground.speeds, move.jog, move.speed, ground.here, known=True)
    plan = MotionPlan(ground.here, made.legs, made.ended.note)
    joints = plan.end.joints
    if move.jog.space is Space.CARTESIAN:
        return PlannedMove((PlannedStep(LineMove(joints, move.speed), plan),))
    return PlannedMove((PlannedStep(JointMove(joints, move.speed), plan),))


# The goals of `park` and of a verification.


def raised(pose: Pose, by_mm: float) -> Pose:
    """Return a pose straight above another."""
    return replace(pose, z_mm=pose.z_mm + by_mm)


def park_pose(config: ArmConfig) -> Pose:
    """Return the park pose: that of the arm file, otherwise a pose above the reference mark."""
    return config.park or above_mark(config)


def above_mark(config: ArmConfig) -> Pose:
    """Return a pose just above the reference mark. Raises `Refused` without a reference."""
    if config.model.reference is None:
        raise Refused("this arm has no park pose: write [park] into its arm file")
    return raised(config.model.reference.pose, PARK_HEIGHT_MM)
