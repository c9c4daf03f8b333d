"""`Arm`: all that a program calls. Each call hands its work to the collaborator that does it.

All calls may be made from any thread; `stop`, `estop` and `status` while another call waits.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Self, Unpack, overload

from armdrive.abilities import Abilities
from armdrive.arm.arguments import RULES
from armdrive.arm.connected import Connection, Handle, Recording, finished
from armdrive.arm.device import InputsOutputs, Lines, PendantMemory
from armdrive.arm.gripper import Gripper
from armdrive.arm.jogging import Jogging
from armdrive.arm.moving import Moving, Place, Places, move_to_place
from armdrive.arm.reference import Accept, Referencing, Told, unreported
from armdrive.blocking import Wait, blocking, coroutine_of, run_blocking
from armdrive.connect.control_socket import serve
from armdrive.connect.parts import PATIENCE_S, ConnectOptions, Parts, connect
from armdrive.dialog.operator import Operator, PostureRequest
from armdrive.errors.arguments import checked_calls
from armdrive.motion import device as device_tasks
from armdrive.motion import reference as reference_tasks
from armdrive.motion.device import RowReport
from armdrive.motion.execute import Moved
from armdrive.motion.frames import frame_names, pose_in_frame
from armdrive.motion.gripper import Grasped
from armdrive.motion.jog.session import Jogged
from armdrive.motion.plan import SpeedLimits
from armdrive.motion.preview import Preview
from armdrive.motion.reference import Verified
from armdrive.moves import (
    BASE_FRAME,
    Angles,
    ArcMove,
    GraspMove,
    GripperMove,
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
)
from armdrive.runtime.arm_state import EMERGENCY_STOP
from armdrive.runtime.clock import PaceChoice
from armdrive.runtime.states import Event, after
from armdrive.status import State, Status
from armdrive.storage.point_file import Points
from armdrive.tasks import DeviceSettings, never
from armdrive.trace.calls import traced
from kinematics.errors import finite
from kinematics.paths.parts import PathPart
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose

if TYPE_CHECKING:  # what few arms and programs need
    from armdrive.registry.pendant import PendantProgram
    from armdrive.sim.simulated_arm import SimulatedArm
    from armdrive.trace.log import LogReader


@traced
@checked_calls(RULES)
class Arm:
    """One arm, connected. Make one with `Arm.connect`; use it in a `with` statement."""

    program: Callable[[], dict[str, Any]] | None = None
    """Tells other programs what program the arm is at work on, as plain data; None of none."""

    def __init__(self, parts: Parts) -> None:
        """Take the parts of a connected arm; `Arm.connect` makes them."""
        self.config = parts.config
        self.core = parts.core
        self.engine = parts.engine
        self.pace = parts.pace
        self.wire = parts.wire
        self.runner = parts.runner
        self.reconnector = parts.reconnector
        self.tracer = parts.tracer
        self.operator = parts.operator
        self.simulated = parts.simulated
        self.twin = parts.twin
        self.logbook = parts.logbook
        self.connection = Connection(parts)
        self._parts = parts
        self.places = Places(parts)
        self._jogging = Jogging(parts)
        self.moving = Moving(parts, self.places, self._jogging)
        self.referencing = Referencing(self, parts, self.moving)
        self._lines = InputsOutputs(parts)
        self._gripper = Gripper(self, parts)
        if parts.lock is not None:
            serve(parts.lock, self)

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
        """Connect to an arm by the name of its arm file, a port with `dialect=`, or `sim:NAME`.

        Without any it is the simulated TeachMover, and in a script under `armdrive run` the arm
        that the command names.
        Options: `dialect`, `baud`, `pace` ("simulated", "real", a factor of real time, or a
        `SimulatedClock` that several simulated arms share), `allow_restored`, `operator`,
        `reconnect` (look for a lost wire until it is back; by default as the arm file says). With
        `ARMDRIVE_FORCE_SIM=1` in the environment every arm is its simulated twin. Raises
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
        if self.core.state is State.DISABLED:
            await coroutine_of(self.enable)()
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
        """Stop, remember the position, and give the port back. Closing twice is no error."""
        await self.connection.close()

    @blocking
    async def reconnect(self) -> None:
        """Look for the lost wire once, by its USB serial number where it had one. Moves nothing.

        Ends in error-stop (`reset` leaves it), or disabled where the arm was disabled before.
        What was under way or waiting when the wire was lost is not taken up again. Raises
        `PortUnavailable` while the wire is not there, `LinkLost` or `DeviceFault` where the arm
        does not answer over it, and `WrongState` while nothing is lost.
        """
        await self.connection.reconnect()

    @property
    def closed(self) -> bool:
        """Whether the connection was given back."""
        return self.connection.closed

    @property
    def reconnects(self) -> bool:
        """Whether a lost wire is looked for without anybody asking, until it is back."""
        return self.connection.reconnects

    # -- switching on and off -------------------------------------------------------------------

    @blocking
    async def enable(self) -> None:
        """Switch the motors on where that can be done, and allow motion. Moves nothing."""
        await self.runner.perform(reference_tasks.enable(self.wire))

    @blocking
    async def disable(self) -> None:
        """Switch the motor current off: **the arm can sag**, so `park` first.

        The position is suspect from then on. On a TeachMover this is `@RESET`.
        """
        after(self.core.state, Event.DISABLE)
        await self.runner.perform(reference_tasks.disable(self.wire))

    @blocking
    async def reset(self) -> None:
        """Leave error-stop: wait until the line is quiet and read the registers. Moves nothing.

        In standby, or while the motors are off, it unlocks a device that was locked before.
        """
        after(self.core.state, Event.RESET)
        await self.runner.stop()
        await self.runner.perform(reference_tasks.reset(self.wire))

    # -- referencing ----------------------------------------------------------------------------

    @blocking
    async def home(self, *, operator: Operator | None = None, told: Told = unreported) -> Pose:
        """Take the reference posture, which an operator has to confirm; return its pose.

        An arm whose file has a `[homing]` section, on a device that homes by its own switches,
        **moves**: the device seeks its switches. Any other needs somebody who looks: `operator`
        is called with a `PostureRequest`, may jog the arm, and returns True when it stands there.
        Without one, `OperatorNeeded`. A simulated arm has a simulated operator. `told` is called by
        the engine's thread with the names of each group of motors that has found its switches; it
        must not wait for anything.
        """
        return await self.referencing.home(operator or self.operator, told)

    @blocking
    async def confirm_reference(self) -> None:
        """Say that the arm stands in its reference posture now."""
        await self.referencing.confirm_reference()

    @blocking
    async def declare_posture(self, posture: Joints | Pose, *, opening_mm: float = 0.0) -> None:
        """Say that the arm stands in this posture now, by joints or by pose."""
        await self.referencing.declare_posture(posture, opening_mm)

    @blocking
    async def confirm_restored(self) -> None:
        """Say that the arm stands as its record shows it: planned motion is allowed again."""
        await self.referencing.confirm_restored()

    def reference_request(self) -> PostureRequest:
        """Return the posture that a reference is taken in."""
        return self.referencing.request()

    @blocking
    async def verify(
        self, *, operator: Operator | None = None, accept: Accept = False, speed: float = 0.5
    ) -> Verified:
        """Measure how far the registers are from what the reference posture should read.

        **Moves** above the reference mark, planned, and then as the operator jogs: he is called
        with a `MarkRequest`, brings the finger tips onto the mark and returns True. With `accept`,
        or where it returns True for what was found, the posture becomes the new reference; else a
        position that is off is suspect from then on. Raises `NotReferenced` where there is no
        position to verify, and `OperatorNeeded` where nobody looks or confirms.
        """
        by = operator or self.operator
        return await self.referencing.verify(by, accept, speed, self.logbook)

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

        The move is resolved from where the arm stands, planned and audited as a whole before the
        first byte: `OutOfBounds` names the joint or guard, and nothing has moved. Every call below
        that begins with `move_` or `jog_` is short for a move.
        """
        return await finished(self.moving.start(move))

    @overload
    def start(self, move: Motion, *, stops: int | None = None) -> Handle[Moved]: ...
    @overload
    def start(self, move: GraspMove, *, stops: int | None = None) -> Handle[Grasped]: ...
    @overload
    def start(self, move: JogMove, *, stops: int | None = None) -> Handle[Jogged]: ...
    @overload
    def start(self, move: MoveSequence, *, stops: int | None = None) -> Handle[Moved | Grasped]: ...
    def start(self, move: Move, *, stops: int | None = None) -> Handle[Moved | Grasped | Jogged]:
        """Begin a move, and return a `Handle` that waits for its end or cancels it.

        With `stops`, the count of stops when the move was decided on, one that came since then
        keeps it from beginning: raises `Stopped`.
        """
        return self.moving.start(move, stops)

    def preview(self, move: Move) -> Preview:
        """Return what a move would be, or why it is refused. Sends nothing, moves nothing.

        A refusal is part of the answer: its typed error, and where the arm could go instead.
        Raises `BadRequest` for a joint, a frame or a point that the arm does not have.
        """
        return self.moving.preview(move)

    @overload
    def move_j(
        self,
        angles_deg: Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: Literal[True] = True,
        **joints_deg: Unpack[JointAngles],
    ) -> Moved: ...
    @overload
    def move_j(
        self,
        angles_deg: Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: Literal[False],
        **joints_deg: Unpack[JointAngles],
    ) -> Handle[Moved]: ...
    @blocking
    async def move_j(
        self,
        angles_deg: Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: bool = True,
        **joints_deg: Unpack[JointAngles],
    ) -> Moved | Handle[Moved]:
        """Move the named joints, `shoulder_deg=40, elbow_deg=-60`; the others stay.

        Joints that a model file names otherwise are given in a mapping, `{"turret_deg": 30}`.
        Straight in joint space. With `wait=False` a `Handle` is returned at once.
        """
        return await self.moving.go(JointMove(by_name(angles_deg, joints_deg), speed), wait)

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
        """Move the tip to a pose by a joint motion, to the posture nearest to the present one.

        Or to a named point, `move_to("pick")`: to its joints; the fingers stay as they are.
        The pose is one of `frame`: the base, a frame of the arm file, or the tool, in which it is
        a change from where the tool is.
        Raises `kinematics.Unreachable` or `OutOfBounds` with the nearest pose that is allowed.
        """
        return await self.moving.go(move_to_place(goal, line=False, speed=speed, frame=frame), wait)

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
        """Move the tip to a pose, or to a named point's, along a straight line.

        Straight in x, y, z, pitch and roll. Of a point, `note` says so where the line ends in
        another posture than it was taught in.
        `frame` is as of `move_to`: `move_l(Pose.of(x_mm=0, y_mm=0, z_mm=-30, pitch_deg=0),
        frame="tool")` draws the hand 30 mm back.
        The tip leaves the line by at most `motion.line_tolerance_mm` of the arm file and what one
        motor step is worth. Raises `kinematics.PathBroken` where the line leaves the reach.
        """
        return await self.moving.go(move_to_place(goal, line=True, speed=speed, frame=frame), wait)

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
        """Move the tip along the arc of a circle, through `via`, to a pose.

        Of `via` only x, y and z count; the hand turns evenly to the goal's pitch and roll. Raises
        `kinematics.NoArc` for points on one line, and `PathBroken` where the arc leaves the reach.
        """
        return await self.moving.go(ArcMove(via, goal, speed, frame), wait)

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
        """Move through several parts as one: `LinePart`, `ArcPart`, `PosePart`, `JointPart`.

        A part with `blend_mm` is left for the next one so far before its end, without stopping;
        without, the arm stops there. The whole way is audited first, in one posture of the arm.
        `note` of the result tells of blends that had to be smaller.
        """
        return await self.moving.go(PathMove(tuple(parts), speed, frame), wait)

    @blocking
    async def move_gripper(self, opening_mm: float, speed: float = 1.0) -> Moved:
        """Bring the fingers to an opening in mm; `arm.gripper` knows more of them."""
        return await finished(self.moving.start(GripperMove(opening_mm, speed)))

    @blocking
    async def park(self, *, speed: float = 1.0) -> Moved:
        """Go to the park posture of the arm file; by default, 30 mm above the reference mark."""
        return await finished(self.moving.start(ParkMove(speed)))

    @blocking
    async def move_motors(
        self, *steps: int, speed: float = 0.25, stops: int | None = None
    ) -> Moved:
        """Move each motor by whole steps from where it is, all together: for the bench.

        Knows neither limits nor guards and needs no reference. With `stops`, the count of stops
        when it was asked for, one that came since then keeps it from beginning: raises `Stopped`.
        """
        return await self.moving.move_motors(steps, speed, stops)

    @property
    def gripper(self) -> Gripper:
        """The fingers."""
        return self._gripper

    @property
    def points(self) -> Points:
        """The named points of this arm, a mapping over its file: `arm.points["pick"]`."""
        return self.places.points

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

        With `duration_s` the axes are directions from -1 to 1, `shoulder=1`, that share the
        speed. Limits are met by stopping at them; `note` of the result says so. Allowed without
        a reference, then slow and without limits. Joints that a model file names otherwise are
        given in a mapping, `{"turret_deg": 2}`.
        """
        named = jog_axes(by_name(amounts, axes), in_steps=duration_s is None)
        return await self._jogging.jog(Jog(Space.JOINT, named), speed, duration_s)

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

        x, y and z are those of the `frame`: "base", "tool", which goes with the hand, or a frame
        of the arm file. `jog_l(frame="tool", z=1, duration_s=1)` goes where the hand points.
        """
        named = jog_axes(by_name(amounts, axes), in_steps=duration_s is None)
        return await self._jogging.jog(Jog(Space.CARTESIAN, named, frame), speed, duration_s)

    def hold(self, jog: Jog, *, speed: float, for_s: float) -> None:
        """Jog for `for_s` seconds and no longer unless called again; never waits.

        A refusal is the `notice` of the status.
        """
        self._jogging.hold(jog, speed, for_s)

    def nudge(self, jog: Jog, *, speed: float) -> None:
        """Jog by one increment; at most one more waits behind the one under way. Never waits.

        One that has not begun within a second is dropped.
        """
        self._jogging.nudge(jog, speed)

    def release(self) -> None:
        """End a held jog: what is queued is given up; a burst under way is the last."""
        self._jogging.release()

    # -- stopping, waiting and slowing down -----------------------------------------------------

    @blocking
    async def stop(self) -> None:
        """Stop, and wait until the arm stands. Legal in every state, from any thread.

        What a device cannot abort runs to its end; `status.stop_time_s` bounds it.
        """
        await self.runner.stop()

    def estop(self) -> None:
        """Stop and latch error-stop; does not wait. Only `reset` leaves it, and moves nothing.

        A device that can stop dead does so, whatever that does to its position.
        """
        self.request_stop(hard=True)  # before the lock: the engine may be holding it
        with self.pace.lock:
            self.core.fault("emergency stop: look at the arm, then call `reset()`", EMERGENCY_STOP)
            self.request_stop(hard=True)

    def request_stop(self, *, hard: bool = False) -> None:
        """Ask for a stop and return at once: the one call that a signal handler may make."""
        self.runner.request_stop(hard=hard)

    @property
    def stops(self) -> int:
        """How often a stop was asked for: what was decided on before the latest is not begun."""
        return self.runner.stops

    @blocking
    async def sleep(self, time_s: float) -> None:
        """Let time pass on the arm's own clock.

        Raises `Stopped` where this program or its computer was suspended meanwhile: who waited
        for something to pass is not to move an arm when nobody expects it any more.
        """
        absences = self.runner.absences()
        await Wait(self.pace, never, max(finite("time_s", time_s), 0.0))
        self.runner.require_present(absences)

    def pause(self) -> None:
        """Have the arm stand behind its next burst or segment, until `resume` or a stop.

        The motion under way goes on with the same plan when it is resumed, unless the arm was
        moved meanwhile; motions that are asked for later wait as well. After 8 h they are given up
        with `WrongState`, and the arm stays paused; on simulated time, a call gives up after 600 s
        where only its own program could resume. Jogs are given up at once, and refused. The
        controller's own homing and a servo's way are not paused, only stopped.
        """
        self.core.speed_override.pause()
        self.pace.wake()

    def resume(self) -> None:
        """Let a paused arm go on. Nothing goes on that an error, a stop or a lost wire ended."""
        self.core.speed_override.end_pause()
        self.pace.wake()

    @property
    def paused(self) -> bool:
        """Whether somebody wants the arm to wait: `status.paused`, cheap to ask for."""
        return self.core.speed_override.paused

    @property
    def speed_override(self) -> float:
        """The share of the speed asked for that the arm goes with, from 0.01 to 1.

        A change holds for what is sent next: bursts, segments and jogs. Raises `BadRequest`.
        """
        return self.core.speed_override.override

    @speed_override.setter
    def speed_override(self, speed_override: float) -> None:
        self.core.speed_override.set_override(speed_override)

    # -- what is known --------------------------------------------------------------------------

    @property
    def status(self) -> Status:
        """A frozen picture of this moment."""
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
        """The acknowledged pose as the base or a frame of the arm file sees it."""
        return pose_in_frame(self.config, self.pose, frame)

    @property
    def frames(self) -> tuple[str, ...]:
        """The frames that goals and jogs can be meant in: base, tool, and the arm file's."""
        return frame_names(self.config)

    @property
    def model(self) -> ArmModel:
        """The arm's model: geometry, limits, transmission, reference posture."""
        return self.config.model

    @property
    def speeds(self) -> SpeedLimits:
        """The limits that time is computed from; a device may tell its own once it is connected."""
        return self._parts.speeds

    @property
    def abilities(self) -> Abilities:
        """What the arm's controller can do."""
        return self.core.controller.abilities

    # -- inputs, outputs and the controller's memory --------------------------------------------

    @blocking
    async def read_inputs(self) -> int:
        """Read the input bits now."""
        return await self._lines.read_inputs()

    @blocking
    async def wait_inputs(
        self, *, high: Lines = (), low: Lines = (), within_s: float | None = None
    ) -> int:
        """Wait until inputs, counted from 1, are high and low; return the input bits.

        `wait_inputs(high=3, low=(1, 2), within_s=10)`, on the arm's own clock. Other calls may go
        on meanwhile: a standing arm is looked at 20 times a second, one in motion as often as its
        controller tells. Raises `InputTimeout` at the deadline, `Stopped` where the arm is stopped
        or this program was suspended, what broke where its wire is lost, `WrongState` for an arm
        that nobody looks at, and `Refused` for one that has no inputs.
        """
        return await self._lines.wait_inputs(high=high, low=low, within_s=within_s)

    @blocking
    async def set_output(self, number: int, on: bool = True) -> None:
        """Switch one output, counted from 1; the others stay. Moves nothing.

        Outputs that this connection has not written yet are taken to be off, as they are when the
        controller is switched on: no such controller tells how they are.
        """
        await self._lines.set_output(number, on)

    @blocking
    async def set_outputs(self, bits: int) -> None:
        """Write the output bits. Moves nothing."""
        await self._lines.set_outputs(bits)

    @blocking
    async def read_pendant_program(self) -> PendantProgram:
        """Read the program in the arm's own memory; takes some seconds, and moves nothing.

        It is read until two readings agree. Where the position is trusted, the program says as
        well what its rows mean (`origin`). Raises `Refused` for an arm that keeps no program, and
        `DeviceFault`.
        """
        return await PendantMemory(self._parts).read()

    @blocking
    async def write_pendant_program(
        self,
        program: PendantProgram,
        *,
        leave_others: bool = False,
        told: RowReport = device_tasks.unreported,
    ) -> int:
        """Write a program into the arm's memory, and read it back; moves nothing.

        Returns how many rows were not there already; `told` is called by the engine's thread with
        the number of each as it is in the arm, and must not wait for anything. Raises `Refused`
        where the program's rows were read under another reference, so that they mean other places
        now (`moved_to` shifts them), or where rows of other numbers would stay, unless
        `leave_others`. An end before the end raises `ProgramHalfWritten`, which names the rows
        that are in the arm.
        """
        memory = PendantMemory(self._parts)
        return await memory.write(program, leave_others=leave_others, told=told)

    @blocking
    async def mend_settings(self, lines: Sequence[str] | None = None) -> DeviceSettings:
        """Write the lines that bring the device's settings to what the arm file says.

        Without `lines`, all that `status.notice` and `armdrive doctor` show. Moves nothing.
        """
        chosen = [each.mend for each in self.core.differences] if lines is None else lines
        body = device_tasks.mend_settings(self.wire, tuple(chosen))
        return await self.runner.perform(body, PATIENCE_S)

    # -- the flight recorder --------------------------------------------------------------------

    def save_recording(self, path: Path | str | None = None) -> Path:
        """Write what the flight recorder holds, and return the file.

        Without a path it goes into the folder of recordings. Raises `StateFileError` where it
        cannot be written, and `WrongState` where nothing is recorded.
        """
        return Recording(self._parts, self.tracer).save(path)

    def log(self, *, back: int | None = None) -> LogReader:
        """Return a reader of what passes on the wire and in the driver, in words.

        It begins with the latest `back` entries (2000 where none is named), and each `read()` goes
        on from where the last one ended. Raises `WrongState` where nothing is recorded.
        """
        return Recording(self._parts, self.tracer).reader(back)


# Who connects in the place of a program's own connections: a rehearsal, a run, a test.
#
# What stands in is of the whole process on purpose: a thread that the program starts is no way
# around it, since in a rehearsal its connection would move the real arm.

Standin = Callable[[str | None, ConnectOptions], Arm | None]
"""Gets what `Arm.connect` was called with; returns an arm, or None to let it go on as it says.

The target is None where the program named none.
"""

_PRESENT: list[Standin] = []


@contextlib.contextmanager
def standing_in(standin: Standin) -> Iterator[None]:
    """Have every connection of this process made by somebody else meanwhile; the latest counts."""
    _PRESENT.append(standin)
    try:
        yield
    finally:
        _PRESENT.remove(standin)


def stood_in(target: str | None, options: ConnectOptions) -> Arm | None:
    """Return the arm that somebody gives instead; None where nobody stands in."""
    return _PRESENT[-1](target, options) if _PRESENT else None


async def connected(target: str | None, options: ConnectOptions) -> Arm:
    """Connect, unless somebody gives an arm instead."""
    instead = stood_in(target, options)
    return Arm(await coroutine_of(connect)(target, options)) if instead is None else instead


def anybody() -> bool:
    """Tell whether somebody stands in at present."""
    return bool(_PRESENT)
