"""What every family of calls stands on: an arm from its connection to its close."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from armdrive.connect.reconnect import Mender
from armdrive.errors import ArmError, LinkLost, NoAnswer, Stopped
from armdrive.motion import idle as idling
from armdrive.motion import reference as referencing
from armdrive.motion.context import Wire
from armdrive.motion.resolve import frame_names, pose_in_frame
from armdrive.motion.segments import Speeds
from armdrive.registry import dialect
from armdrive.runtime.arm_state import Core
from armdrive.runtime.deadlines import call_limit_s
from armdrive.runtime.diagnostics import EMERGENCY_STOP
from armdrive.runtime.drive import RealPace
from armdrive.runtime.engine import Engine
from armdrive.runtime.received import Received
from armdrive.runtime.registers import alerted
from armdrive.runtime.states import Event, after
from armdrive.status import State
from armdrive.tasks import Alert, Flow, Progress, never
from armdrive.trace.calls import NO_WITNESS, Witness
from kinematics import ArmModel, Joints, Pose
from kinematics.errors import finite

if TYPE_CHECKING:
    from armdrive.abilities import Abilities
    from armdrive.config.arm import ArmConfig
    from armdrive.connect.reconnect import Rewiring
    from armdrive.dialog import Operator
    from armdrive.runtime.drive import Pace
    from armdrive.sim.simulated_arm import Twin
    from armdrive.status import Status
    from armdrive.storage.record import Recorder
    from armdrive.tasks import Task
    from armdrive.trace.entries import Entry
    from armdrive.trace.log import LogReader
    from armdrive.transports.link import Link


# What is known of a connected arm: its status, its model, its speeds, its frames.

T = TypeVar("T")


class Knowing:
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
    def speeds(self) -> Speeds:
        """The limits that time is computed from; a device may tell its own once it is connected."""
        return Speeds(
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

PATIENCE_S = 60.0
"""Whatever should take no time at all is given up after this long."""


class Waiting(Knowing):
    """The calls that stop, and what every other call waits with."""

    wire: Wire
    stops = 0
    """How often a stop was asked for: what was decided on before the latest is not begun."""
    # -- stopping -----------------------------------------------------------------------------

    def request_stop(self, *, hard: bool = False) -> None:
        """Ask for a stop and return at once: the one call that a signal handler may make."""
        self.stops += 1
        self.core.hold = None
        self.engine.stop_hard = self.engine.stop_hard or hard
        self.engine.stop_asked = True
        self.pace.wake()

    def stop(self) -> None:
        """Stop, and wait until the arm stands. Legal in every state, from any thread.

        What a device cannot abort runs to its end; `status.stop_time_s` bounds it.
        """
        if not self.stand_still():
            raise NoAnswer("the arm did not confirm that it stands; look at it")

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
        self.request_stop()
        # a stop that the engine has not seen yet would be taken for one of the next motion
        return self.pace.wait(lambda: self.engine.at_rest, PATIENCE_S)

    # -- waiting ------------------------------------------------------------------------------

    def submit(self, flow: Flow[T], *, alone: bool = False, within_s: float = math.inf) -> Task[T]:
        """Hand a flow to the engine. Raises `WrongState` while another is waiting there.

        With `alone` also while one is at work: what moves the arm never waits for its turn. The
        engine ends a flow that takes longer than `within_s`, with `NoAnswer`.
        """
        with self.pace.lock:
            task = self.engine.start(flow, alone=alone, within_s=within_s)
        self.pace.wake()
        return task

    def finish(self, task: Task[T], timeout_s: float) -> T:
        """Wait for a task; whatever interrupts the wait stops the arm."""
        try:
            ended = self._waited(task, timeout_s)
        except BaseException:
            self.stand_still()
            raise
        if not ended:
            self.stand_still()
            raise NoAnswer(f"the motion had not ended after {timeout_s:.0f} s and was stopped")
        return task.result()

    def _waited(self, task: Task[Any], timeout_s: float) -> bool:
        """Wait for a task, and for as much longer as it is paused or slowed down."""
        tempo = self.core.tempo
        simulated, delay_s = not isinstance(self.pace, RealPace), tempo.delay_s
        waited_s = -tempo.waited_s

        def ended() -> bool:
            if simulated and not task.done:
                tempo.breathe(waited_s + tempo.waited_s)
            return task.done

        while not self.pace.wait(ended, timeout_s):
            timeout_s, delay_s = tempo.delay_s - delay_s, tempo.delay_s
            if timeout_s <= 0.0:
                return False
        return True

    def perform(self, flow: Flow[T], within_s: float | None = None) -> T:
        """Hand a flow that moves nothing to the engine and wait for its end.

        It ends within `call_limit_s`, or `within_s` where that is given. A motion that is under
        way is waited for before that, for a minute at most.
        """
        limit_s = self.engine.call_limit_s if within_s is None else within_s
        return self.finish(self.submit(flow, within_s=limit_s), limit_s + PATIENCE_S)

    def sleep(self, time_s: float) -> None:
        """Let time pass on the arm's own clock.

        Raises `Stopped` where this program or its computer was suspended meanwhile: who waited
        for something to pass is not to move an arm when nobody expects it any more.
        """
        absences = self._absences()
        self.pace.wait(never, max(finite("time_s", time_s), 0.0))
        self._require_present(absences)

    def _absences(self) -> int:
        with self.pace.lock:
            return self.engine.absences

    def _require_present(self, absences: int) -> None:
        """Raise `Stopped` where this program has stood still since that count was taken."""
        if self._absences() != absences:
            raise Stopped(
                "the wait was ended: this program or its computer had been suspended, and nothing "
                "goes on by itself after that"
            )


CLOSING_S = 10.0
"""A disk that takes longer to remember where the arm was left is not waited for."""


class Connected(Waiting):
    """An arm on an open link. Its calls hand flows to the engine and wait for their end."""

    def __init__(
        self,
        config: ArmConfig,
        link: Link,
        pace: Pace,
        *,
        simulated: bool,
        recorder: Recorder | None = None,
        allow_restored: bool = False,
        operator: Operator | None = None,
        witness: Witness = NO_WITNESS,
        rewiring: Rewiring | None = None,
    ) -> None:
        """Connect over an open link. Raises `NoAnswer` where no such arm answers; moves nothing."""
        self.config = config
        self.pace = pace
        self.simulated = simulated
        self.twin: Twin | None = None
        self.operator = operator
        self.witness = witness
        self._on_close: list[Callable[[], None]] = []
        controller = dialect(config.connection.dialect).controller(config)
        # on simulated time a disk takes no time: what has to be written is written at once
        wake = pace.wake if isinstance(pace, RealPace) else None
        self.core = Core(config, controller, recorder, wake)
        self.core.allow_restored = allow_restored
        self.core.witness = witness
        self.core.tempo.others = isinstance(pace, RealPace)
        self.core.geometry_known |= simulated  # a simulated arm is what its numbers say
        self.engine = Engine(
            link,
            controller,
            idle=self._idle,
            stopping=self._stopping,
            lost=self._lost,
            noticed=self._noticed,
            witness=witness,
            received=Received(on_bus=dialect(config.connection.dialect).can),
            call_limit_s=call_limit_s(config.device),
        )
        self.wire = Wire(self.engine, self.core)
        self._idling = idling.Idling(self.wire)
        self.closed = False
        self.mender = None if rewiring is None else Mender(self.wire, rewiring)
        self.engine.mending = self.mender
        witness.begin(config, link.description, pace.now_s, self.core.condition)
        pace.start(self.engine)
        try:
            self.perform(referencing.connect(self.wire))
            with pace.lock:
                witness.opened()
        except BaseException:
            self._release()
            raise

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
        from armdrive.trace.log import BACK, LogReader

        dialect, began_s = self.config.connection.dialect, self.witness.began_s
        return LogReader(self._since, dialect, began_s, back=BACK if back is None else back)

    def _since(self, number: int, most: int, back: int) -> tuple[int, tuple[Entry, ...]]:
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
        self.pace.close()
        self.engine.link.close()
        self.core.memory.finish(CLOSING_S)
        self.witness.close()
        calls, self._on_close = self._on_close, []
        for call in calls:
            call()

    # -- what the engine calls ----------------------------------------------------------------

    def _idle(self, now_s: float) -> tuple[float, Flow[Any] | None]:
        return self._idling.due(now_s)

    def _stopping(self) -> None:
        self.core.tempo.end_pause()
        if self.core.state in (State.MOVING, State.HOMING):
            self.core.happen(Event.STOP)

    def _noticed(self, event: Alert | Progress) -> None:
        if isinstance(event, Progress):
            self.core.progress(event.registers)
        else:
            alerted(self.core, event, self.engine.now_s)

    def _lost(self, lost: LinkLost) -> None:
        self.core.lose(lost)
        self.core.remember()
        if self.mender is not None:
            self.mender.lost(self.engine.now_s)
