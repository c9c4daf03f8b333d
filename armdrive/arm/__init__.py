"""`Arm`: the calls of a program. Each call delegates to the collaborator that does the work.

    moving      planned moves and their deadlines; `arm.gripper`
    jogging     jogs that a call waits for, and `arm.jogging`: held jogs and their lease
    reference   home, and `arm.reference`: declaring, confirming and verifying
    device      `arm.io`: inputs and outputs; `arm.controller`: its program and its settings
    connected   `arm.recorder`, handles of motions, the base of the parts
    arguments   the checks of arguments, by annotation

Every call is safe from any thread; `stop`, `estop` and `status` also work while another call waits.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Literal, Self, Unpack, overload

from armdrive.abilities import Abilities
from armdrive.arm.arguments import RULES
from armdrive.arm.connected import Handle, Recorder, finished
from armdrive.arm.device import ControllerMemory, InputsOutputs
from armdrive.arm.jogging import Jogging, JogSessions
from armdrive.arm.moving import Gripper, Moving, Place, move_to_place
from armdrive.arm.reference import ArmReference, GroupReport, home
from armdrive.blocking import blocking, coroutine_of, run_blocking
from armdrive.connect.connection import ProgramView
from armdrive.connect.control_socket import serve
from armdrive.connect.parts import ConnectOptions, Parts, connect
from armdrive.connect.target import DEFAULT_TARGET
from armdrive.dialog import Operator
from armdrive.errors import NoAnswer
from armdrive.errors.arguments import checked_calls, known_attributes, made_of
from armdrive.motion import connecting
from armdrive.motion.execute import Moved
from armdrive.motion.frames import frame_names, pose_in_frame
from armdrive.motion.gripper import Grasped
from armdrive.motion.jog import Jogged
from armdrive.motion.preview import Preview
from armdrive.moves import (
    BASE_FRAME,
    Angles,
    ArcMove,
    GraspMove,
    Jog,
    JogMove,
    JointAngles,
    JointJog,
    JointMove,
    Motion,
    Move,
    MoveSequence,
    ParkMove,
    PathMove,
    Space,
    TipJog,
    by_name,
    jog_axes,
    joint_goal,
)
from armdrive.runtime.arm_state import EMERGENCY_STOP
from armdrive.runtime.clock import PaceChoice
from armdrive.runtime.engine import closed_for_good
from armdrive.runtime.states import Event
from armdrive.status import State, Status
from armdrive.storage.point_file import Points
from armdrive.tasks import unreported
from armdrive.trace.recorder import traced
from kinematics.paths.routes import PathPart
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose

if TYPE_CHECKING:  # few arms and programs need these
    from armdrive.sim.simulated_arm import SimulatedArm


@known_attributes
@traced("")
@checked_calls(RULES)
class Arm:
    """A connected arm. Create it with `Arm.connect` and use it in a `with` statement.

    A call that moves the arm may raise `WrongState`, `NotReferenced`, `OutOfBounds`, or an error of
    the kinematics, before anything is sent; and `Stopped`, `LinkLost`, `NoAnswer` or another
    `DeviceFault` on the way. A stop ends `sleep` and `io.wait` too. If another program stops the
    arm between two such calls, the next one raises `Stopped`.
    """

    def __init__(self, parts: Parts) -> None:
        """Assemble an arm from the parts that `Arm.connect` makes."""
        made_of(Parts, "the parts of a connection", f'Arm.connect("{DEFAULT_TARGET}")')(
            "parts", parts
        )
        self.config = parts.config
        self.operator = parts.operator
        self.simulated = parts.simulated
        self.twin = parts.twin
        self._parts = parts
        self._connection = parts.connection
        try:
            self._jogs = JogSessions(parts)
            self._moving = Moving(parts, self._jogs)
            self._gripper = Gripper(parts, self._moving)
            self._jogging = Jogging(parts, self._jogs)
            self._io = InputsOutputs(parts)
            self._controller = ControllerMemory(parts)
            self._recorder = Recorder(parts)
            if parts.lock is not None:  # what moves must be within reach of `armdrive stop`
                self._connection.guard()
                serve(parts.lock, parts.connection)
        except BaseException:  # the caller gets no arm that could be closed
            run_blocking(self._connection.close())
            raise

    def __repr__(self) -> str:  # takes no lock: a debugger may ask in mid-motion
        kind = "SIMULATED" if self.simulated else "REAL"
        state = "closed" if self.closed else self._parts.core.state.value
        trust = self._parts.core.belief.trust.value
        return f"<{type(self).__name__} {self.config.name}, {kind}: {state}, position {trust}>"

    # -- connecting -----------------------------------------------------------------------------

    @classmethod
    def connect(
        cls,
        target: str | None = None,
        *,
        dialect: str | None = None,
        baud: int | None = None,
        pace: PaceChoice = None,
        allow_restored: bool = False,
        operator: Operator | None = None,
        twin: SimulatedArm | None = None,
        reconnect: bool | None = None,
    ) -> Arm:
        """Connect to an arm: an arm file's name, `sim:` and a dialect, or a port with `dialect=`.

        Without a target, connect to the simulated TeachMover or, in a script under `armdrive run`,
        to the arm that the command names. `baud` belongs to a port. `pace` is "simulated", "real",
        a multiple of real time, or a `SimulatedClock` that several simulated arms share. With
        `allow_restored`, a remembered position needs no confirmation. `home` and `reference.verify`
        ask the function `operator`. With `reconnect`, a lost connection is restored automatically;
        the default is in the arm file. `twin` is the simulated arm to use.

        If the environment has `ARMDRIVE_FORCE_SIM=1`, every arm is simulated. Raises
        `PortUnavailable`, `ArmFileError`, `BadRequest`, `NoAnswer`.
        """
        options = ConnectOptions(
            dialect=dialect,
            baud=baud,
            pace=pace,
            allow_restored=allow_restored,
            operator=operator,
            twin=twin,
            reconnect=reconnect,
        )
        return run_blocking(connected(target, options))

    @blocking
    async def __enter__(self) -> Self:
        if self.closed:
            raise closed_for_good()
        try:
            if self._parts.core.state is State.DISABLED:
                await coroutine_of(self.enable)()
        except BaseException:  # `with Arm.connect()` has no other name for it
            await self._connection.close()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @blocking
    async def close(self) -> None:
        """Stop, save the position, and release the port. Closing twice is no error."""
        await self._connection.close()

    @blocking
    async def reconnect(self) -> None:
        """Try once to restore a lost connection; a USB port is found by its serial number.

        Moves nothing. Afterwards the arm is in error-stop, which `reset` leaves, or disabled if it
        was disabled before. Motions that were running or waiting when the connection was lost do
        not continue. Raises `PortUnavailable` if the port is still missing, `LinkLost` or
        `DeviceFault` if the arm does not answer, and `WrongState` if no connection is lost.
        """
        await self._connection.reconnect()

    @property
    def closed(self) -> bool:
        """Whether the connection is closed."""
        return self._connection.closed

    @property
    def reconnects(self) -> bool:
        """Whether a lost connection is restored automatically."""
        return self._connection.reconnects

    @property
    def program(self) -> ProgramView | None:
        """Describes the running program to other processes; None if none is running."""
        return self._connection.program

    @program.setter
    def program(self, program: ProgramView | None) -> None:
        self._connection.program = program

    # -- switching on and off -------------------------------------------------------------------

    @blocking
    async def enable(self) -> None:
        """Switch the motors on, if the device has a switch for them, and allow motion.

        Moves nothing.
        """
        await self._parts.runner.perform(connecting.enable(self._parts.context))

    @blocking
    async def disable(self) -> None:
        """Switch the motor current off: **the arm can sag**, so `park` first.

        Afterwards the position is suspect. A TeachMover receives `@RESET`.
        """
        self._parts.runner.require(Event.DISABLE)
        await self._parts.runner.perform(connecting.disable(self._parts.context))

    @blocking
    async def reset(self) -> None:
        """Leave error-stop: wait until the line is quiet and read the registers. Moves nothing.

        In standby, or while the motors are off, `reset` unlocks a locked device.
        """
        self._parts.runner.require(Event.RESET)
        await self._parts.runner.stop()
        await self._parts.runner.perform(connecting.reset(self._parts.context))

    # -- referencing ----------------------------------------------------------------------------

    @blocking
    async def home(
        self,
        *,
        operator: Operator | None = None,
        report: GroupReport = unreported,
        stops: int | None = None,
    ) -> Pose:
        """Reference the arm, by its homing switches or by an operator; return its pose.

        With a `[homing]` section in the arm file and a device that homes by itself, the arm
        **moves**: the device seeks its switches. The engine's thread then calls `report` with the
        motor names of each group that has found them; `report` must not block.

        Any other arm needs an operator: `operator` is called with a `PostureRequest`, may jog the
        arm, and returns True once the arm stands in the reference posture. A simulated arm has a
        simulated one; `armdrive run` asks in the terminal. Raises `OperatorNeeded` without one.
        `stops` works as in `start`, except that an operator is also asked after a stop by another
        program.
        """
        asked = operator or self.operator
        return await home(self._parts, self.reference, asked, report, stops)

    @property
    def reference(self) -> ArmReference:
        """What the position rests on: `reference.declare(...)`, `reference.verify()`."""
        return ArmReference(self, self._parts)  # not kept, because it keeps the arm

    # -- moving ---------------------------------------------------------------------------------

    @overload
    def run(self, move: Motion) -> Moved: ...
    @overload
    def run(self, move: GraspMove) -> Grasped: ...
    @overload
    def run(self, move: JogMove) -> Jogged: ...
    @overload
    def run(self, move: MoveSequence) -> Moved | Grasped: ...
    @blocking
    async def run(self, move: Move) -> Moved | Grasped | Jogged:
        """Carry out a move and wait for its end: `run(LineMove(pose, speed=0.5))`.

        The whole move is planned from the current position and checked before the first byte is
        sent. If it would leave the limits, `OutOfBounds` names the joint or guard, and nothing
        moves. The calls below that begin with `move_` or `jog_` are shortcuts for moves.
        """
        return await finished(self._moving.start(move))

    @overload
    def start(self, move: Motion, *, stops: int | None = None) -> Handle[Moved]: ...
    @overload
    def start(self, move: GraspMove, *, stops: int | None = None) -> Handle[Grasped]: ...
    @overload
    def start(self, move: JogMove, *, stops: int | None = None) -> Handle[Jogged]: ...
    @overload
    def start(self, move: MoveSequence, *, stops: int | None = None) -> Handle[Moved | Grasped]: ...
    def start(self, move: Move, *, stops: int | None = None) -> Handle[Moved | Grasped | Jogged]:
        """Start a move, and return a `Handle` to wait for its end or to cancel it.

        `stops` is the value of `arm.stops` when the program decided on the move. If a stop has been
        requested since then, the move does not start and `Stopped` is raised. Without `stops`, that
        happens after a stop by another program that no call has reported yet.
        """
        return self._moving.start(move, stops)

    def preview(self, move: Move) -> Preview:
        """Return what a move would do, or why it is refused. Sends nothing, moves nothing.

        Raises `BadRequest` for an unknown joint, frame or point.
        """
        return self._moving.preview(move)

    @overload
    def move_j(
        self,
        goal: Joints | Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: Literal[True] = True,
        **joints_deg: Unpack[JointAngles],
    ) -> Moved: ...
    @overload
    def move_j(
        self,
        goal: Joints | Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: Literal[False],
        **joints_deg: Unpack[JointAngles],
    ) -> Handle[Moved]: ...
    @blocking
    async def move_j(
        self,
        goal: Joints | Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: bool = True,
        **joints_deg: Unpack[JointAngles],
    ) -> Moved | Handle[Moved]:
        """Move the named joints, `shoulder_deg=40, elbow_deg=-60`; the others stay.

        The path is straight in joint space. `goal` is a posture, such as an earlier `arm.joints`,
        or a mapping for joints with other names: `{"turret_deg": 30}`. With `wait=False`, return a
        `Handle` at once.
        """
        return await self._moving.go(JointMove(joint_goal(goal, joints_deg), speed), wait)

    @overload
    def move_to(
        self,
        goal: Place,
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE_FRAME, wait: Literal[False]
    ) -> Handle[Moved]: ...
    @blocking
    async def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE_FRAME, wait: bool = True
    ) -> Moved | Handle[Moved]:
        """Move the tip to a pose by a joint motion, to the posture nearest to the current one.

        The goal may also be joint angles or a point, `move_to("pick")`, whose joint angles the arm
        moves to; the gripper does not move. `frame` is the pose's frame: "base", a frame of the arm
        file, or "tool", in which the pose is a change from the current pose of the tool.
        Raises `Unreachable` or `OutOfBounds`; their `nearest` is a pose that `move_to` reaches.
        """
        return await self._moving.go(
            move_to_place(goal, line=False, speed=speed, frame=frame), wait
        )

    @overload
    def move_l(
        self,
        goal: Place,
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE_FRAME, wait: Literal[False]
    ) -> Handle[Moved]: ...
    @blocking
    async def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE_FRAME, wait: bool = True
    ) -> Moved | Handle[Moved]:
        """Move the tip along a straight line to the pose of a goal like that of `move_to`.

        The line is straight in x, y, z, pitch and roll. If it ends in a different posture from the
        joint angles or the point, `note` of the result says so.
        `frame` works as in `move_to`: `move_l(Pose.of(x_mm=0, y_mm=0, z_mm=-30, pitch_deg=0),
        frame="tool")` draws the hand back by 30 mm.
        The tip deviates from the line by at most `motion.line_tolerance_mm` of the arm file plus
        one motor step. Raises `kinematics.PathBroken` if the line leaves the arm's reach.
        """
        move = move_to_place(goal, line=True, speed=speed, frame=frame)
        return await self._moving.go(move, wait)

    @overload
    def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[False],
    ) -> Handle[Moved]: ...
    @blocking
    async def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: bool = True,
    ) -> Moved | Handle[Moved]:
        """Move the tip along a circular arc through `via` to a pose.

        Only x, y and z of `via` matter; the hand turns evenly to the goal's pitch and roll. Raises
        `kinematics.NoArc` if the points lie on a line, and `PathBroken` if the arc leaves the
        arm's reach.
        """
        return await self._moving.go(ArcMove(via, goal, speed, frame), wait)

    @overload
    def move_path(
        self,
        parts: Sequence[PathPart],
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    def move_path(
        self,
        parts: Sequence[PathPart],
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[False],
    ) -> Handle[Moved]: ...
    @blocking
    async def move_path(
        self,
        parts: Sequence[PathPart],
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: bool = True,
    ) -> Moved | Handle[Moved]:
        """Move along a path of several parts: `LinePart`, `ArcPart`, `PosePart`, `JointPart`.

        The arm stops at the end of each part, unless the part has a `blend_mm`: that far before its
        end, the arm turns into the next part without stopping. The path keeps one posture. `note`
        of the result names blends that had to be smaller.
        """
        return await self._moving.go(PathMove(tuple(parts), speed, frame), wait)

    @blocking
    async def park(self, *, speed: float = 1.0) -> Moved:
        """Move to the arm file's park posture, by default 30 mm above the reference mark."""
        return await finished(self._moving.start(ParkMove(speed)))

    @blocking
    async def move_motors(
        self, *steps: int, speed: float = 0.25, stops: int | None = None
    ) -> Moved:
        """Move all motors together, each by whole steps: for tests at the bench.

        Needs no reference, and ignores limits and guards. `stops` works as in `start`.
        """
        return await self._moving.move_motors(steps, speed, stops)

    @property
    def gripper(self) -> Gripper:
        """The fingers: `gripper.open()`, `gripper.grasp()`."""
        return self._gripper

    @property
    def points(self) -> Points:
        """The arm's named points, a mapping that is stored in a file: `arm.points["pick"]`."""
        return self._moving.points

    # -- jogging --------------------------------------------------------------------------------

    @blocking
    async def jog_j(
        self,
        amounts: Angles | None = None,
        /,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        **axes: Unpack[JointJog],
    ) -> Jogged:
        """Jog joints: by increments, `shoulder_deg=2, gripper_mm=5`, or for a time.

        With `duration_s`, the axes are directions from -1 to 1, `shoulder=1`, that share the
        speed. A jog ends at a limit or in a pause, and `note` of the result says so; a stop raises
        `Stopped`. An arm without a reference can jog too, slowly and without limits. If a model
        file gives joints other names, use a mapping: `{"turret_deg": 2}`.
        """
        named = jog_axes(by_name(amounts, axes), in_steps=duration_s is None)
        return await self._jogs.jog(Jog(Space.JOINT, named), speed, duration_s)

    @blocking
    async def jog_l(
        self,
        amounts: Angles | None = None,
        /,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        frame: str = BASE_FRAME,
        **axes: Unpack[TipJog],
    ) -> Jogged:
        """Jog the tip: by increments, `x_mm=5, pitch_deg=-2`, or for a time, `x=1`.

        x, y and z are axes of `frame`: "base", "tool", which moves with the hand, or a frame of
        the arm file. `jog_l(frame="tool", z=1, duration_s=1)` moves in the hand's direction.
        """
        named = jog_axes(by_name(amounts, axes), in_steps=duration_s is None)
        return await self._jogs.jog(Jog(Space.CARTESIAN, named, frame), speed, duration_s)

    @property
    def jogging(self) -> Jogging:
        """Jogs for keys and sticks, which no call waits for: `jogging.hold(...)`."""
        return self._jogging

    # -- stopping, waiting and slowing down -----------------------------------------------------

    @blocking
    async def stop(self) -> None:
        """Stop, and wait until the arm stands. Allowed in every state and from any thread.

        A motion that the device cannot abort runs to its end, within `status.stop_time_s`. Raises
        `NoAnswer` if the device does not answer, and `LinkLost` if the connection is lost: then it
        is unknown whether the arm stands.
        """
        stopped = self._parts.engine.under_way
        await self._parts.runner.stop()
        if stopped is not None and isinstance(stopped.error, NoAnswer):
            raise stopped.error
        self._parts.runner.require_reachable()

    def estop(self) -> None:
        """Stop, latch error-stop, and return at once. Only `reset` leaves error-stop.

        A device that can stop without a ramp does so, even if it loses its position. The call does
        not wait for the device; `stop` waits until the arm stands, and can follow. Raises
        `LinkLost` if the connection is lost: nothing can be sent, and error-stop latches if the
        connection comes back.
        """
        self.request_stop(hard=True)  # before taking the lock, because the engine may hold it
        with self._parts.pace.lock:
            self._parts.core.fault(
                "emergency stop: look at the arm, then call `reset()`", EMERGENCY_STOP
            )
            self.request_stop(hard=True)
        self._parts.runner.require_reachable()

    def request_stop(self, *, hard: bool = False) -> None:
        """Request a stop and return at once. A signal handler may call nothing but this."""
        self._parts.runner.request_stop(hard=hard)

    @property
    def stops(self) -> int:
        """The number of stops requested so far; see `start`."""
        return self._parts.runner.stops

    @blocking
    async def sleep(self, time_s: float) -> None:
        """Wait on the arm's own clock, for at most 1,000,000 s.

        Raises `Stopped` if a stop is requested, or if the program or its computer was suspended
        during the wait: an arm that moved on after such a gap would surprise the people around it.
        """
        runner = self._parts.runner
        absences, stops = runner.absences(), runner.known_stops
        await runner.wait(lambda: runner.interrupted(stops, absences), time_s)
        runner.require_present(absences)
        runner.require_no_stop(stops, "while the program slept")

    def pause(self) -> None:
        """Pause the arm after its current burst or segment, until `resume` or a stop.

        `resume` continues the motion with the same plan, unless the arm has been moved. Later
        motions wait too. After 8 h (after 600 s of simulated time, if only the program itself could
        resume), they end with `WrongState`, and the arm stays paused. A running jog ends at once,
        and new jogs are refused. A controller's own homing and a servo's motion can only be
        stopped.
        """
        self._parts.runner.pause()

    def resume(self) -> None:
        """Resume a paused arm. A motion ended by an error, a stop or a lost link stays ended."""
        self._parts.runner.resume()

    @property
    def speed_override(self) -> float:
        """The factor, from 0.01 to 1, by which the arm slows every requested speed.

        A change takes effect with the next burst, segment or jog. Raises `BadRequest`.
        """
        return self._parts.core.speed_override.override

    @speed_override.setter
    def speed_override(self, speed_override: float) -> None:
        self._parts.core.speed_override.set_override(speed_override)

    # -- status and model -----------------------------------------------------------------------

    @property
    def status(self) -> Status:
        """A frozen snapshot of the arm."""
        return self._parts.status

    @property
    def joints(self) -> Joints:
        """The acknowledged joint angles. Raises `NotReferenced` while the position is unknown."""
        return self._parts.joints

    @property
    def pose(self) -> Pose:
        """The acknowledged pose. Raises `NotReferenced` while the position is unknown."""
        return self._parts.pose

    def pose_in(self, frame: str) -> Pose:
        """Return the acknowledged pose in the base frame or in a frame of the arm file."""
        return pose_in_frame(self.config, self.pose, frame)

    @property
    def frames(self) -> tuple[str, ...]:
        """The frames available to goals and jogs: base, tool, and those of the arm file."""
        return frame_names(self.config)

    @property
    def model(self) -> ArmModel:
        """The arm's model: geometry, limits, transmission, reference posture."""
        return self.config.model

    @property
    def abilities(self) -> Abilities:
        """The capabilities of the arm's controller."""
        return self._parts.core.controller.abilities

    # -- the controller and the flight recorder -------------------------------------------------

    @property
    def io(self) -> InputsOutputs:
        """The inputs and outputs: `io.wait(high=3)`, `io.set(1)`."""
        return self._io

    @property
    def controller(self) -> ControllerMemory:
        """What the controller stores: `controller.read_program()`, `controller.fix_settings()`."""
        return self._controller

    @property
    def recorder(self) -> Recorder:
        """The flight recorder: `recorder.save()`, `recorder.log()`."""
        return self._recorder

    @property
    def parts(self) -> Parts:
        """The machinery of the connection, for armdrive's own commands; no program needs it.

        Its parts may change with every version.
        """
        return self._parts


# Connection overrides: rehearsals, runs and tests replace a program's connections with their own.
#
# An override applies to the whole process on purpose: if a thread of a rehearsed program could
# connect by itself, it would move the real arm.

# Takes the target and options of `Arm.connect`; returns an arm, or None to connect as usual.
#
# The target is None if the program names none.
ConnectionOverride = Callable[[str | None, ConnectOptions], Arm | None]

_OVERRIDES: list[ConnectionOverride] = []


@contextlib.contextmanager
def override_connections(override: ConnectionOverride) -> Iterator[None]:
    """Make every connection of this process through `override`; the innermost one counts."""
    _OVERRIDES.append(override)
    try:
        yield
    finally:
        _OVERRIDES.remove(override)


def overriding_arm(target: str | None, options: ConnectOptions) -> Arm | None:
    """Return the arm of the innermost override; None to connect as usual."""
    return _OVERRIDES[-1](target, options) if _OVERRIDES else None


async def connected(target: str | None, options: ConnectOptions) -> Arm:
    """Connect to an arm, or return the arm of an override."""
    instead = overriding_arm(target, options)
    return Arm(await coroutine_of(connect)(target, options)) if instead is None else instead


def connections_overridden() -> bool:
    """Return whether an override is in force."""
    return bool(_OVERRIDES)
