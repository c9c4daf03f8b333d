"""The moves of an arm: planned motion, increments and held jogs; and the calls of its gripper.

A planned motion is resolved from the current position and checked as a whole before it starts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from typing import Any, Protocol, overload

from armdrive.arm.connected import Handle, finished
from armdrive.blocking import blocking, coroutine_of
from armdrive.connect.parts import PATIENCE_S, Parts
from armdrive.errors import BadRequest, LinkLost, Refused, Stopped, WrongState
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
from armdrive.motion.jog import (
    Jogged,
    check_duration,
    check_increment,
    check_jog,
    jog_session,
)
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
    ContinuousJog,
    GraspMove,
    GripperMove,
    IncrementalJog,
    Jog,
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
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point
from armdrive.tasks import Task, TaskBody
from armdrive.trace.recorder import FlightRecorder, traced
from kinematics.errors import finite
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
        max(each.straying_mm for each in moved),
        "; ".join(filter(None, (each.note for each in moved))),
    )


# Jogging: programs wait for the end of a jog; the desk does not.

LET_GO = "the jog was stopped: let go, then jog again"

BEFORE = "before the motion started"
"""When a stop was requested that keeps a motion from starting."""

LONGEST_LEASE_S = 1.0  # a held jog that is not renewed within this time ends
LATEST_START_S = 1.0  # an increment that starts later than this would surprise the operator


class Jogging:
    """The jogs of one arm. One jog session at a time carries out all requests."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._core = parts.core
        self._session: Task[Jogged] | None = None
        self._held_until_s = -math.inf
        """When the latest hold expires, even if a stop has ended it."""
        self._held_stops = 0
        """The number of stops before the held jog."""

    async def jog(self, jog: Jog, speed: float, duration_s: float | None) -> Jogged:
        """Jog by an increment or for a time, and wait for the end."""
        if duration_s is None:
            return await finished(self.start(JogMove(jog, speed)))
        fraction = speed_fraction(speed)
        with self._parts.pace.lock:
            self._parts.runner.require_no_stop(None, BEFORE)
            if not finite("duration_s", duration_s) > 0.0:
                raise BadRequest(f"duration_s must be above 0, not {duration_s!r}")
            hold = ContinuousJog(jog, fraction, self._parts.pace.now_s() + duration_s)
            self._require(hold)
            check_duration(self._core, self._parts.speeds, hold, duration_s)
            task = self._begin(hold)
        return await self._parts.runner.finish(task, duration_s + PATIENCE_S * 10)

    def start(self, move: JogMove, stops: int | None = None) -> Handle[Jogged]:
        """Start an increment. Raises `WrongState` while another one waits."""
        with self._parts.pace.lock:
            self._parts.runner.require_no_stop(stops, BEFORE)
            nudge = IncrementalJog(move.jog, move.speed)
            # Only one may wait: more would move the arm after the operator's last press.
            if self._core.nudges:
                self._require(nudge)  # what is wrong with the jog itself matters more
                raise WrongState("another increment is already waiting: wait for its end")
            task = self._begin(nudge)
        return Handle(self._parts.runner, task, PATIENCE_S * 10)

    def hold(self, jog: Jog, speed: float, for_s: float) -> None:
        """Jog for a time, unless another call extends the jog; returns at once.

        A stop ends what is held: after it, no call extends the jog.
        """
        pace, runner = self._parts.pace, self._parts.runner
        with pace.lock:
            now_s = pace.now_s()
            asked = ContinuousJog(jog, speed_fraction(speed), now_s + min(for_s, LONGEST_LEASE_S))
            # Renewing a hold must not revive it after a stop. A new hold, begun after the old one
            # has ended, was decided on after the stop.
            extended, self._held_until_s = now_s < self._held_until_s, asked.until_s
            if not extended:
                self._held_stops = runner.stops
                runner.know_of(runner.stops)
            if runner.stops == self._held_stops:
                self._go_on(asked)
            else:
                self._core.notify(LET_GO, Stopped())
        pace.wake()

    def nudge(self, jog: Jog, speed: float) -> None:
        """Jog by one increment, unless another one is already waiting; returns at once."""
        pace = self._parts.pace
        with pace.lock:
            self._parts.runner.know_of(self._parts.runner.stops)
            nudge = IncrementalJog(jog, speed_fraction(speed), pace.now_s() + LATEST_START_S)
            if not self._core.nudges:
                self._go_on(nudge)
        pace.wake()

    def release(self) -> None:
        """End a held jog."""
        self._parts.core.hold, self._held_until_s = None, -math.inf
        self._parts.pace.wake()

    def _require(self, asked: ContinuousJog | IncrementalJog, *, joins: bool = False) -> None:
        """Raise if a jog may not start now; with `joins`, it may extend the running session."""
        core, runner = self._core, self._parts.runner
        runner.require_link()
        if isinstance(asked, IncrementalJog):
            check_increment(core, asked.jog)
        else:
            check_jog(core, asked.jog)
        # a running session has passed the state machine already, and MOVING would refuse it now
        alive = joins and self._session is not None and not self._session.done
        if not alive and core.state is not State.HOMING:
            runner.require(Event.MOVE, "jogging")

    def _begin(self, asked: ContinuousJog | IncrementalJog, *, joins: bool = False) -> Task[Jogged]:
        """Hand a jog to a session. Raises if the jog may not start."""
        core = self._core
        self._require(asked, joins=joins)
        task = self._join_session()
        if isinstance(asked, IncrementalJog):
            core.nudges.append(asked)
        else:
            core.hold = asked
            core.holds += 1
        return task

    def _go_on(self, asked: ContinuousJog | IncrementalJog) -> None:
        """Hand a jog to a session, and report a refusal in the status's notice."""
        try:
            self._begin(asked, joins=True)
        except (Refused, LinkLost) as refusal:
            self._core.notify(str(refusal), refusal)

    def _join_session(self) -> Task[Jogged]:
        """Return the running jog session, or start one."""
        if self._session is None or self._session.done:
            body = jog_session(self._parts.context, self._parts.speeds)
            self._session = self._parts.runner.submit(body, alone=True)
        return self._session


# The deadline of a motion is PATIENCE times its planned duration, and PATIENCE_S for the rest.

PATIENCE = 4.0
GRASP_PATIENCE_S = 120.0  # added for a grasp, whose duration is not known in advance
LONGEST_BENCH_S = 600.0  # raw steps know no limits: a slip of three digits would turn for hours


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
    def start(self, move: Move, stops: int | None = None) -> Handle[Moved | Grasped | Jogged]: ...
    def start(self, move: Move, stops: int | None = None) -> Handle[Any]:
        """Resolve and plan a move and hand it to the engine, unless a stop is requested meanwhile.

        `stops` is the stop count from which on a stop matters, by default the last known one.
        """
        if isinstance(move, JogMove):
            return self._jogging.start(move, stops)
        runner = self._parts.runner
        since = runner.known_stops if stops is None else stops
        with self._parts.pace.lock:
            self._require(move)
            runner.require(Event.MOVE)
            # planning may take a second, and a stop waits for no lock
            made = prepare(move, self.ground())
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

    def ground(self, here: ArmCoordinates | None = None) -> Ground:
        """Return the context in which moves are resolved, for the arm at `here` or as it stands."""
        core = self._core
        return Ground(
            self._parts.config,
            self._parts.speeds,
            core.position.coordinates if here is None else here,
            lambda name: self.points[name].joints,
        )

    def _require(self, move: Move) -> None:
        """Raise `Refused` if a move of this kind is not possible now, whatever its goal."""
        core = self._core
        self._parts.runner.require_link()  # the loss explains all that follows from it
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
            # last: switching the motors on mends just this
            self._parts.runner.require(Event.MOVE)
        except (Refused, LinkLost) as refusal:
            return refusal
        return None


class TracedArm(Protocol):
    """The gripper's arm, whose tracer also records the gripper's calls."""

    tracer: FlightRecorder

    @overload
    def start(self, move: Motion) -> Handle[Moved]: ...
    @overload
    def start(self, move: GraspMove) -> Handle[Grasped]: ...
    def start(self, move: Motion | GraspMove) -> Handle[Moved] | Handle[Grasped]:
        """Start a move."""


@known_attributes
@traced
@checked_calls(BASIC)
class Gripper:
    """The gripper of an arm."""

    def __init__(self, arm: TracedArm, parts: Parts) -> None:
        self._arm = arm
        self._parts = parts

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self._parts.config.name}>"

    @property
    def opening_mm(self) -> float:
        """The distance between the fingers, from the motors or the width of a gripped object.

        Raises `NotReferenced` while the position is unknown, and `Refused` for a servo that has
        not been commanded yet.
        """
        core = self._parts.core
        require_gripper(core)
        if not core.transmission.has_gripper and core.fingers.share is None:
            raise Refused("the gripper's opening is unknown: open or close the gripper first")
        return self._parts.known(self._parts.status.gripper_mm)

    @property
    def force_n(self) -> float:
        """The gripping force, computed from the motor steps after contact; 0 without a grasp."""
        core = self._parts.core
        return core.fingers.force_n(core.position.coordinates.opening_mm)

    @blocking
    async def open(self, opening_mm: float | None = None, *, speed: float = 1.0) -> Moved:
        """Open the fingers to a width in mm, or all the way."""
        return await finished(self._arm.start(GripperMove(opening_mm, speed)))

    @blocking
    async def close(self, opening_mm: float = 0.0, *, speed: float = 1.0) -> Moved:
        """Close the fingers to a width in mm. To detect an object, use `grasp`."""
        return await coroutine_of(self.move)(opening_mm, speed=speed)

    @blocking
    async def move(self, opening_mm: float, *, speed: float = 1.0) -> Moved:
        """Move the fingers to an opening in mm."""
        return await finished(self._arm.start(GripperMove(opening_mm, speed)))

    @blocking
    async def grasp(self, *, force_n: float = 8.9) -> float:
        """Close the fingers on an object; return its width in mm, or 0.0 if there is none.

        The force, about 2 lb by default, is applied after the grip switch has tripped.
        """
        return (await coroutine_of(self.feel)(force_n=force_n)).width_mm

    @blocking
    async def feel(self, *, force_n: float = 8.9) -> Grasped:
        """Grasp an object like `grasp`, and return the force as well."""
        return await finished(self._arm.start(GraspMove(force_n)))
