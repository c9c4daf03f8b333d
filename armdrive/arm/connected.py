"""What every family of calls stands on: an arm from its connection to its close."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from armdrive.abilities import Abilities
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import PATIENCE_S, Parts, TaskRunner
from armdrive.errors import ArmError, NoAnswer, WrongState
from armdrive.motion import reference as referencing
from armdrive.motion.context import MotionContext
from armdrive.motion.resolve import frame_names, pose_in_frame
from armdrive.motion.segments import SpeedLimits
from armdrive.runtime.arm_state import Core
from armdrive.runtime.diagnostics import EMERGENCY_STOP
from armdrive.runtime.drive import Pace
from armdrive.runtime.engine import Engine
from armdrive.runtime.states import Event, after
from armdrive.status import State, Status
from armdrive.tasks import Task, TaskBody, never
from armdrive.trace.entries import TraceEntry
from kinematics.errors import finite
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose

if TYPE_CHECKING:
    from armdrive.trace.log import LogReader

# What is known of a connected arm: its status, its model, its speeds, its frames.

T = TypeVar("T")


class StatusView:
    """The calls that ask and wait for nothing; `Connected` makes what they look at."""

    config: ArmConfig
    core: Core
    engine: Engine
    pace: Pace
    simulated: bool

    @property
    def status(self) -> Status:
        """A frozen picture of this moment."""
        with self.pace.lock:
            wakes = self.pace.lateness.view()
            return self.core.status(self.engine, simulated=self.simulated, wakes=wakes)

    @property
    def speeds(self) -> SpeedLimits:
        """The limits that time is computed from; a device may tell its own once it is connected."""
        return SpeedLimits(
            self.config.model.joint_speeds_rad_s,
            self.config.model.gripper_speed_mm_s,
            self.core.controller.usable_rate_hz(math.inf),
            self.core.transmission,
            self.config.motion.ramp_s,
            self.config.motion.jerk_s,
            self.config.accelerations_rad_s2,
        )

    @property
    def model(self) -> ArmModel:
        """The arm's model: geometry, limits, transmission, reference posture."""
        return self.config.model

    @property
    def abilities(self) -> Abilities:
        """What the arm's controller can do."""
        return self.core.controller.abilities

    @property
    def joints(self) -> Joints:
        """The acknowledged joint angles. Raises `NotReferenced` while the position is unknown."""
        return self.known(self.status.joints)

    @property
    def pose(self) -> Pose:
        """The acknowledged pose. Raises `NotReferenced` while the position is unknown."""
        return self.known(self.status.pose)

    @property
    def frames(self) -> tuple[str, ...]:
        """The frames that goals and jogs can be meant in: base, tool, and the arm file's."""
        return frame_names(self.config)

    def pose_in(self, frame: str) -> Pose:
        """The acknowledged pose as the base or a frame of the arm file sees it."""
        return pose_in_frame(self.config, self.pose, frame)

    def known(self, value: T | None) -> T:
        """Return what a status tells, or raise `NotReferenced` where it tells nothing."""
        if value is None:
            self.core.require_reference()
            raise ArmError("the position is not known")
        return value


# Handing work to the engine and waiting for its end, and stopping whatever is at work.


class TaskCalls(StatusView):
    """The calls that stop, and what every other call waits with."""

    wire: MotionContext
    runner: TaskRunner

    # -- stopping -----------------------------------------------------------------------------

    @property
    def stops(self) -> int:
        """How often a stop was asked for: what was decided on before the latest is not begun."""
        return self.runner.stops

    def request_stop(self, *, hard: bool = False) -> None:
        """Ask for a stop and return at once: the one call that a signal handler may make."""
        self.runner.request_stop(hard=hard)

    def stop(self) -> None:
        """Stop, and wait until the arm stands. Legal in every state, from any thread.

        What a device cannot abort runs to its end; `status.stop_time_s` bounds it.
        """
        self.runner.stop()

    def estop(self) -> None:
        """Stop and latch error-stop; does not wait. Only `reset` leaves it, and moves nothing.

        A device that can stop dead does so, whatever that does to its position.
        """
        self.request_stop(hard=True)  # before the lock: the engine may be holding it
        with self.pace.lock:
            self.core.fault("emergency stop: look at the arm, then call `reset()`", EMERGENCY_STOP)
            self.request_stop(hard=True)

    def reset(self) -> None:
        """Leave error-stop: wait until the line is quiet and read the registers. Moves nothing.

        In standby, or while the motors are off, it unlocks a device that was locked before.
        """
        after(self.core.state, Event.RESET)
        self.stop()
        self.perform(referencing.reset(self.wire))

    def stand_still(self) -> bool:
        """Stop, and tell whether the arm was seen to stand."""
        return self.runner.stand_still()

    # -- waiting ------------------------------------------------------------------------------

    def submit(
        self, flow: TaskBody[T], *, alone: bool = False, within_s: float = math.inf
    ) -> Task[T]:
        """Hand a flow to the engine, as `TaskRunner.submit` says."""
        return self.runner.submit(flow, alone=alone, within_s=within_s)

    def finish(self, task: Task[T], timeout_s: float) -> T:
        """Wait for a task; whatever interrupts the wait stops the arm."""
        return self.runner.finish(task, timeout_s)

    def perform(self, flow: TaskBody[T], within_s: float | None = None) -> T:
        """Hand a flow that moves nothing to the engine and wait for its end."""
        return self.runner.perform(flow, within_s)

    def sleep(self, time_s: float) -> None:
        """Let time pass on the arm's own clock.

        Raises `Stopped` where this program or its computer was suspended meanwhile: who waited
        for something to pass is not to move an arm when nobody expects it any more.
        """
        absences = self.runner.absences()
        self.pace.wait(never, max(finite("time_s", time_s), 0.0))
        self.runner.require_present(absences)


class Connected(TaskCalls):
    """An arm on an open link. Its calls hand flows to the engine and wait for their end."""

    def __init__(self, parts: Parts) -> None:
        """Take the parts of a connected arm (connect/parts.py), and give them back in `close`."""
        self.config = parts.config
        self.pace = parts.pace
        self.core = parts.core
        self.engine = parts.engine
        self.wire = parts.wire
        self.runner = parts.runner
        self.mender = parts.mender
        self.witness = parts.witness
        self.operator = parts.operator
        self.simulated = parts.simulated
        self.twin = parts.twin
        self.logbook = parts.logbook
        self.closed = False
        self._parts = parts
        self._on_close: list[Callable[[], None]] = []

    def save_recording(self, path: Path | str | None = None) -> Path:
        """Write what the flight recorder holds, and return the file.

        Without a path it goes into the folder of recordings. Raises `StateFileError` where it
        cannot be written, and `WrongState` where nothing is recorded.
        """
        with self.pace.lock:
            write = self.witness.snapshot("asked for")
        return write(None if path is None else Path(path))

    def log(self, *, back: int | None = None) -> LogReader:
        """Return a reader of what passes on the wire and in the driver, in words.

        It begins with the latest `back` entries (2000 where none is named), and each `read()` goes
        on from where the last one ended. Raises `WrongState` where nothing is recorded.
        """
        from armdrive.trace.log import BACK, LogReader  # few programs read it, and all start up

        dialect, began_s = self.config.connection.dialect, self.witness.began_s
        return LogReader(self._since, dialect, began_s, back=BACK if back is None else back)

    def _since(self, number: int, most: int, back: int) -> tuple[int, tuple[TraceEntry, ...]]:
        with self.pace.lock:
            return self.witness.since(number, most, back)

    # -- the end ------------------------------------------------------------------------------

    def close(self) -> None:
        """Stop, remember the position, and give the port back. Closing twice is no error."""
        try:
            if self.core.state is not State.DISCONNECTED:
                self.stop()
                with self.pace.lock:
                    if self.engine.broken is None:  # else the mark of motion has to stay
                        self.core.mark_still()
        finally:
            with self.pace.lock:
                self.closed = True
                if self.mender is not None:
                    self.mender.close()
                self.core.happen(Event.LOST)
                self.engine.close()
            self._release()

    def on_close(self, call: Callable[[], None]) -> None:
        """Have something done once when the arm is closed."""
        self._on_close.append(call)

    def _release(self) -> None:
        self._parts.release()
        calls, self._on_close = self._on_close, []
        for call in calls:
            call()


# Pausing, resuming and slowing an arm: for whoever watches it while a program moves it.


class Overrides(Connected):
    """The calls that change when and how fast the arm goes, not where. None of them waits."""

    program: Callable[[], dict[str, Any]] | None = None
    """Tells other programs what program the arm is at work on, as plain data; None of none."""

    def pause(self) -> None:
        """Have the arm stand behind its next burst or segment, until `resume` or a stop.

        The motion under way goes on with the same plan when it is resumed, unless the arm was
        moved meanwhile; motions that are asked for later wait as well. After 8 h they are given up
        with `WrongState`, and the arm stays paused; on simulated time, a call gives up after 600 s
        where only its own program could resume. Jogs are given up at once, and refused. The
        controller's own homing and a servo's way are not paused, only stopped.
        """
        self.core.tempo.pause()
        self.pace.wake()

    def resume(self) -> None:
        """Let a paused arm go on. Nothing goes on that an error, a stop or a lost wire ended."""
        self.core.tempo.end_pause()
        self.pace.wake()

    @property
    def paused(self) -> bool:
        """Whether somebody wants the arm to wait: `status.paused`, cheap to ask for."""
        return self.core.tempo.paused

    @property
    def speed_override(self) -> float:
        """The share of the speed asked for that the arm goes with, from 0.01 to 1.

        A change holds for what is sent next: bursts, segments and jogs. Raises `BadRequest`.
        """
        return self.core.tempo.override

    @speed_override.setter
    def speed_override(self, speed_override: float) -> None:
        self.core.tempo.set_override(speed_override)


# Getting the arm back after its wire was lost, by hand.


class Reconnecting(Connected):
    """The call that looks for a lost wire."""

    @property
    def reconnects(self) -> bool:
        """Whether a lost wire is looked for without anybody asking, until it is back."""
        return self.mender is not None and self.mender.automatic

    def reconnect(self) -> None:
        """Look for the lost wire once, by its USB serial number where it had one. Moves nothing.

        Ends in error-stop (`reset` leaves it), or disabled where the arm was disabled before.
        What was under way or waiting when the wire was lost is not taken up again. Raises
        `PortUnavailable` while the wire is not there, `LinkLost` or `DeviceFault` where the arm
        does not answer over it, and `WrongState` while nothing is lost.
        """
        mender = self.mender
        with self.pace.lock:
            if self.engine.broken is None:
                raise WrongState("the wire is there: nothing has to be reconnected")
            if mender is None or self.closed:
                raise WrongState("this connection was closed for good: connect anew")
            before = mender.ask(self.pace.now_s())
        self.pace.wake()
        if not self.pace.wait(lambda: mender.tries > before, PATIENCE_S):
            raise NoAnswer("nobody knows whether the wire is back: look for it again")
        if self.core.state is State.DISCONNECTED and mender.trouble is not None:
            raise mender.trouble
