"""Planned motion: resolved from the current position, checked as a whole, run by the engine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from typing import Any, overload

from armdrive.arm.connected import Handle, finished
from armdrive.arm.jogging import Jogging
from armdrive.connect.parts import PATIENCE_S, Parts
from armdrive.errors import BadRequest, Refused, Stopped
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
from armdrive.motion.jog.session import Jogged, check_jog
from armdrive.motion.plan import MotionPlan, SpeedLimits
from armdrive.motion.preview import Preview, preview_move
from armdrive.motion.resolve import (
    SAME_IN_EVERY_FRAME,
    Ground,
    PlannedMove,
    PlannedStep,
    is_cartesian,
    prepare,
    resolved,
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
from armdrive.runtime.states import Event, after
from armdrive.status import State, Trust
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point
from armdrive.tasks import TaskBody
from kinematics.spaces import Motors, Pose

Place = Pose | Point | str
"""A pose, a point, or the name of a point."""


def move_to_place(place: Place, *, line: bool, speed: float, frame: str) -> Motion:
    """Return the move to a place, by a joint motion or along a straight line."""
    if not isinstance(place, Point):
        return LineMove(place, speed, frame) if line else PoseMove(place, speed, frame)
    if frame != BASE_FRAME:
        raise BadRequest(SAME_IN_EVERY_FRAME)
    return LineMove(place.joints, speed) if line else JointMove(place.joints, speed)


# Carrying out a planned move, step by step.


def carry_out(
    wire: MotionContext, speeds: SpeedLimits, planned: PlannedMove
) -> TaskBody[Moved | Grasped]:
    """Carry out a planned move. A stop ends the whole move, including the steps still to come.

    Returns the result of a final grasp; for any other move, the sum of all steps.
    """
    moved: list[Moved] = []
    for step in planned.steps:
        done = yield from _step(wire, speeds, step)
        if isinstance(done, Grasped):
            return done
        moved.append(done)
    return _together(moved)


def _step(wire: MotionContext, speeds: SpeedLimits, step: PlannedStep) -> TaskBody[Moved | Grasped]:
    match step:
        case PlannedStep(plan=MotionPlan() as plan):
            return (yield from follow(wire, plan))
        case PlannedStep(move=GraspMove(force_n=force_n)):
            return (yield from grasp(wire, speeds, force_n))
        case PlannedStep(move=GripperMove(opening_mm=float() as opening_mm)):
            return (yield from set_gripper(wire, opening_mm))
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
        max(each.straying_mm for each in moved),
        "; ".join(filter(None, (each.note for each in moved))),
    )


# The deadline of a motion is PATIENCE times its planned duration, and PATIENCE_S for the rest.

PATIENCE = 4.0
GRASP_PATIENCE_S = 120.0  # added for a grasp, whose duration is not known in advance


class Moving:
    """The planned motions of one arm, and the named points that they lead to."""

    def __init__(self, parts: Parts, jogging: Jogging) -> None:
        self._parts = parts
        self._jogging = jogging
        self._core = parts.core
        self.points = points_of(parts.config.name, parts.config.model.arm, self._here)

    def _here(self) -> Point:
        """Return the current position, on whole steps. Raises `NotReferenced`."""
        status = self._parts.status
        self._core.require_reference()
        now = datetime.now().replace(microsecond=0)
        return Point(self._parts.known(status.joints), status.gripper_mm, taught=now)

    @overload
    def start(self, move: Motion, stops: int | None = None) -> Handle[Moved]: ...
    @overload
    def start(self, move: GraspMove, stops: int | None = None) -> Handle[Grasped]: ...
    @overload
    def start(self, move: JogMove, stops: int | None = None) -> Handle[Jogged]: ...
    @overload
    def start(self, move: MoveSequence, stops: int | None = None) -> Handle[Moved | Grasped]: ...
    def start(self, move: Move, stops: int | None = None) -> Handle[Any]:
        """Resolve and plan a move and hand it to the engine, unless a stop is requested meanwhile.

        `stops` is the stop count from which on a stop matters, by default the current one.
        """
        if isinstance(move, JogMove):
            return self._jogging.start(move)
        runner = self._parts.runner
        asked = runner.stops if stops is None else stops
        with self._parts.pace.lock:
            self._require(move)
            made = prepare(move, self.ground())
            if runner.stops != asked:
                raise Stopped("a stop was requested before the motion started")
            body = carry_out(self._parts.wire, self._parts.speeds, made)
            task = runner.submit(body, alone=True)
        longest_s = made.duration_s * PATIENCE + PATIENCE_S
        if isinstance(made.steps[-1].move, GraspMove):
            longest_s += GRASP_PATIENCE_S
        return Handle(runner, task, longest_s)

    async def go(self, move: Motion, wait: bool) -> Moved | Handle[Moved]:
        """Start a move, and wait for its end if `wait` is true."""
        handle = self.start(move)
        return await finished(handle) if wait else handle

    def resolved(self, move: Move) -> Move:
        """Return the absolute form of a move; see `resolve.resolved`."""
        with self._parts.pace.lock:
            return resolved(move, self.ground())

    def preview(self, move: Move) -> Preview:
        """Return what a move would do, or why it is refused."""
        with self._parts.pace.lock:
            ground, controller = self.ground(), self._core.controller
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
                after(core.state, Event.MOVE)
            if stops is not None and runner.stops != stops:
                raise Stopped("a stop was requested before the motors started")
            body = motion.bench_move(self._parts.wire, self._parts.speeds, motors, fraction)
            task = runner.submit(body, alone=True)
        return await runner.finish(task, PATIENCE_S * 10)

    # -- requirements of a move ---------------------------------------------------------------

    def ground(self, here: ArmCoordinates | None = None) -> Ground:
        """Return the context in which moves are resolved, for the arm at `here` or as it stands."""
        core = self._core
        return Ground(
            self._parts.config,
            self._parts.speeds,
            core.position.coordinates if here is None else here,
            lambda name: self.points[name].joints,
            core.transmission.has_gripper,
        )

    def _require(self, move: Move) -> None:
        """Raise `Refused` if a move of this kind may not start now, whatever its goal."""
        core = self._core
        if is_cartesian(move):
            core.require_geometry()
        for each in move.moves if isinstance(move, MoveSequence) else (move,):
            self._require_fingers(each)
            if isinstance(each, JogMove):
                check_jog(core, each.jog)
            elif not self._commanded(each):
                core.require_reference()
        after(core.state, Event.MOVE)

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

    def _hindrance(self, move: Move) -> Refused | None:
        try:
            self._require(move)
            self._core.require_settings()
        except Refused as refusal:
            return refusal
        return None
