"""The planned motions of an arm, and the calls of its gripper.

A planned motion is resolved from the current position and checked as a whole before it starts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from functools import partial
from typing import Any, overload

from armdrive.arm.connected import BEFORE, PATIENCE, ArmPart, Handle, finished
from armdrive.arm.jogging import JogSessions
from armdrive.blocking import blocking
from armdrive.connect.parts import Parts
from armdrive.connect.runner import PATIENCE_S
from armdrive.errors import BadRequest, LinkLost, Refused
from armdrive.errors.arguments import BASIC, checked_calls, known_attributes
from armdrive.motion import execute as motion
from armdrive.motion.context import MotionContext
from armdrive.motion.execute import Moved, follow
from armdrive.motion.gripper import (
    Grasped,
    check_grasp,
    check_opening,
    grasp,
    require_gripper,
    set_gripper,
)
from armdrive.motion.jog import Jogged, check_increment
from armdrive.motion.plan import MotionPlan, SpeedLimits
from armdrive.motion.preview import Preview, preview_move
from armdrive.motion.resolve import (
    SAME_IN_EVERY_FRAME,
    Ground,
    PlannedMove,
    PlannedStep,
    is_cartesian,
    prepare,
)
from armdrive.moves import (
    BASE_FRAME,
    GraspMove,
    GripperMove,
    JogMove,
    JointMove,
    LineMove,
    Motion,
    Move,
    MoveSequence,
    PoseMove,
    SingleMove,
    speed_fraction,
)
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.states import Event
from armdrive.status import State, Trust
from armdrive.storage.point_file import Points, points_of
from armdrive.storage.points import Point
from armdrive.tasks import TaskBody
from armdrive.trace.recorder import traced
from kinematics.spaces import Joints, Motors, Pose

# A pose, joint angles, a point, or the name of a point.
Place = Pose | Joints | Point | str


def move_to_place(place: Place, *, line: bool, speed: float, frame: str) -> Motion:
    """Return the move to a place, by a joint motion or along a straight line."""
    goal = place.joints if isinstance(place, Point) else place
    if not isinstance(goal, Joints):
        return LineMove(goal, speed, frame) if line else PoseMove(goal, speed, frame)
    if frame != BASE_FRAME:
        raise BadRequest(SAME_IN_EVERY_FRAME)
    return LineMove(goal, speed) if line else JointMove(goal, speed)


# Carrying out a planned move, step by step.


def carry_out(
    context: MotionContext, speeds: SpeedLimits, planned: PlannedMove
) -> TaskBody[Moved | Grasped]:
    """Carry out a planned move. A stop ends the whole move, including the steps still to come.

    Returns the result of a final grasp; for any other move, the sum of all steps.
    """
    moved: list[Moved] = []
    for step in planned.steps:
        done = yield from _step(context, speeds, step)
        if isinstance(done, Grasped):
            return done
        moved.append(done)
    return _together(moved)


def _step(
    context: MotionContext, speeds: SpeedLimits, step: PlannedStep
) -> TaskBody[Moved | Grasped]:
    match step:
        case PlannedStep(plan=MotionPlan() as plan):
            return (yield from follow(context, plan))
        case PlannedStep(move=GraspMove(force_n=force_n)):
            return (yield from grasp(context, speeds, force_n))
        case PlannedStep(move=GripperMove(opening_mm=float() as opening_mm)):
            return (yield from set_gripper(context, opening_mm))
    raise BadRequest(f"{step.move} was not planned")


def _together(moved: Sequence[Moved]) -> Moved:
    """Return the combined result of several moves: the last position, and their total cost."""
    last = moved[-1]
    if len(moved) == 1:
        return last
    return Moved(
        last.joints,
        last.pose,
        last.rounding_mm,
        math.fsum(each.duration_s for each in moved),
        sum(each.bursts for each in moved),
        max(each.deviation_mm for each in moved),
        "; ".join(filter(None, (each.note for each in moved))),
    )


GRASP_PATIENCE_S = 120.0  # added for a grasp, whose duration is not known in advance
LONGEST_BENCH_S = 600.0  # raw steps know no limits: a slip of three digits would turn for hours


def ground_of(parts: Parts, points: Points, here: ArmCoordinates | None = None) -> Ground:
    """Return the context in which moves are resolved, for the arm at `here` or as it stands."""
    return Ground(
        parts.config,
        parts.speeds,
        parts.core.position.coordinates if here is None else here,
        lambda name: points[name].joints,
    )


def current_point(parts: Parts) -> Point:
    """Return an arm's current position, on whole steps. Raises `NotReferenced`."""
    status = parts.status
    parts.core.require_reference()
    now = datetime.now().replace(microsecond=0)
    return Point(parts.known(status.joints), status.gripper_mm, taught=now)


class Moving:
    """The planned motions of one arm, and the named points that they lead to."""

    def __init__(self, parts: Parts, jogs: JogSessions) -> None:
        self._parts = parts
        self._jogs = jogs
        self._core = parts.core
        here = partial(current_point, parts)  # no method: an arm in a cycle would be lost late
        self.points = points_of(parts.config.name, parts.config.model.arm, here)

    @overload
    def start(self, move: Motion, stops: int | None = None) -> Handle[Moved]: ...
    @overload
    def start(self, move: GraspMove, stops: int | None = None) -> Handle[Grasped]: ...
    @overload
    def start(self, move: Move, stops: int | None = None) -> Handle[Moved | Grasped | Jogged]: ...
    def start(self, move: Move, stops: int | None = None) -> Handle[Any]:
        """Resolve and plan a move and hand it to the engine, unless a stop is requested meanwhile.

        `stops` is the stop count from which on a stop matters, by default the last known one.
        """
        if isinstance(move, JogMove):
            return self._jogs.start(move, stops)
        runner = self._parts.runner
        since = runner.known_stops if stops is None else stops
        with self._parts.pace.lock:
            self._require(move)
            runner.require(Event.MOVE)
            # planning may take a second, and a stop waits for no lock
            made = prepare(move, ground_of(self._parts, self.points))
            runner.require_no_stop(since, BEFORE)
            body = carry_out(self._parts.context, self._parts.speeds, made)
            task = runner.submit(body, alone=True)
        longest_s = made.duration_s * PATIENCE + PATIENCE_S
        if isinstance(made.steps[-1].move, GraspMove):
            longest_s += GRASP_PATIENCE_S
        return Handle(runner, task, longest_s)

    async def go(self, move: Motion, wait: bool) -> Moved | Handle[Moved]:
        """Start a move, and wait for its end if `wait` is true."""
        handle = self.start(move)
        return await finished(handle) if wait else handle

    def preview(self, move: Move) -> Preview:
        """Return what a move would do, or why it is refused."""
        with self._parts.pace.lock:
            ground, controller = ground_of(self._parts, self.points), self._core.controller
            hindrance = self._hindrance(move)
            known = self._core.belief.trust is not Trust.UNKNOWN
        return (
            preview_move(ground, controller, move, hindrance) if known else Preview(None, hindrance)
        )

    async def move_motors(self, steps: Sequence[int], speed: float, stops: int | None) -> Moved:
        """Move each motor by whole steps; see `Arm.move_motors`."""
        core, runner = self._core, self._parts.runner
        motors, needed = Motors(tuple(steps)), core.controller.abilities.motors
        if len(motors) != needed:
            raise BadRequest(f"{needed} step counts are needed, not {len(motors)}")
        fraction = speed_fraction(speed)
        with self._parts.pace.lock:
            if core.state is not State.HOMING:
                runner.require(Event.MOVE, "turning motors")
            runner.require_no_stop(stops, BEFORE)
            takes_s = self._bench_duration_s(motors, fraction)
            body = motion.bench_move(self._parts.context, self._parts.speeds, motors, fraction)
            task = runner.submit(body, alone=True)
        return await runner.finish(task, takes_s * PATIENCE + PATIENCE_S)

    def _bench_duration_s(self, motors: Motors, fraction: float) -> float:
        """Return how long motors turn. Raises `BadRequest` for what must be a slip."""
        position = self._core.position
        goal = position.coordinates_of(position.acknowledged + motors)
        takes_s = self._parts.speeds.duration_s(position.coordinates, goal, fraction)
        if takes_s > LONGEST_BENCH_S:
            raise BadRequest(
                f"the motors would turn for {takes_s:.0f} s, and move_motors takes at most "
                f"{LONGEST_BENCH_S:.0f} s: use fewer steps or a higher speed; nothing was moved"
            )
        return takes_s

    # -- requirements of a move ---------------------------------------------------------------

    def _require(self, move: Move) -> None:
        """Raise `Refused` if a move of this kind is not possible now, whatever its goal."""
        core = self._core
        self._parts.runner.require_link()  # the loss explains all that follows from it
        if core.state is State.ERROR_STOP:  # the arm takes no reference either
            self._parts.runner.require(Event.MOVE)
        if is_cartesian(move):
            core.require_geometry()
        for each in move.moves if isinstance(move, MoveSequence) else (move,):
            self._require_fingers(each)
            if isinstance(each, JogMove):
                check_increment(core, each.jog)
            elif not self._commanded(each):
                core.require_reference()

    def _require_fingers(self, move: SingleMove) -> None:
        if isinstance(move, GraspMove):
            check_grasp(self._core, move.force_n)
        elif isinstance(move, GripperMove):
            require_gripper(self._core)
            if self._commanded(move) and move.opening_mm is not None:
                check_opening(self._core, move.opening_mm)

    def _commanded(self, move: SingleMove) -> bool:
        """Return whether a move only commands a gripper servo, which needs no reference."""
        return isinstance(move, GripperMove) and not self._core.transmission.has_gripper

    def _hindrance(self, move: Move) -> Refused | LinkLost | None:
        try:
            self._require(move)
            self._core.require_settings()
            # last: switching the motors on fixes just this
            self._parts.runner.require(Event.MOVE)
        except (Refused, LinkLost) as refusal:
            return refusal
        return None


@known_attributes
@traced("gripper")
@checked_calls(BASIC)
class Gripper(ArmPart):
    """The gripper of an arm."""

    def __init__(self, parts: Parts, moving: Moving) -> None:
        super().__init__(parts)
        self._moving = moving

    @property
    def opening_mm(self) -> float:
        """The distance between the fingers, from the motors or the width of a gripped object.

        Raises `NotReferenced` while the position is unknown, and `Refused` for a servo that has
        not been commanded yet.
        """
        core = self._core
        require_gripper(core)
        if not core.transmission.has_gripper and core.fingers.share is None:
            raise Refused("the gripper's opening is unknown: open or close the gripper first")
        return self._parts.known(self._parts.status.gripper_mm)

    @property
    def force_n(self) -> float:
        """The gripping force, computed from the motor steps after contact; 0 without a grasp."""
        core = self._core
        return core.fingers.force_n(core.position.coordinates.opening_mm)

    @blocking
    async def open(self, opening_mm: float | None = None, *, speed: float = 1.0) -> Moved:
        """Open the fingers to a width in mm, or all the way."""
        return await finished(self._moving.start(GripperMove(opening_mm, speed)))

    @blocking
    async def close(self, opening_mm: float = 0.0, *, speed: float = 1.0) -> Moved:
        """Close the fingers to a width in mm. To detect an object, use `grasp`."""
        return await finished(self._moving.start(GripperMove(opening_mm, speed)))

    @blocking
    async def grasp(self, *, force_n: float = 8.9) -> float:
        """Close the fingers on an object; return its width in mm, or 0.0 if there is none.

        The force, about 2 lb by default, is applied after the grip switch has tripped.
        """
        return (await finished(self._moving.start(GraspMove(force_n)))).width_mm
