"""The parts of a connected arm: its state, engine and clock, and the runner of its tasks.

`connect` opens the link to an arm or to its simulated twin. `assemble` puts the parts together on
an open link and connects. `Arm(parts)` adds the public calls.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from armdrive.blocking import Wait, blocking, coroutine_of
from armdrive.config.arm import ArmConfig
from armdrive.connect.port import NewLink, Reconnector
from armdrive.connect.target import DEFAULT_TARGET, find, require_real_ports, state_file
from armdrive.dialog import Operator
from armdrive.errors import BadRequest, LinkLost, NoAnswer, NotReferenced, Stopped
from armdrive.motion import connecting
from armdrive.motion.context import MotionContext
from armdrive.motion.plan import SpeedLimits
from armdrive.registry import dialect, simulate
from armdrive.runtime.arm_state import Core, alerted
from armdrive.runtime.clock import Pace, PaceChoice, RealPace, SimulatedClock, pace_of
from armdrive.runtime.engine import Engine, Received, call_limit_s
from armdrive.runtime.overrides import given_up
from armdrive.runtime.states import Event, after
from armdrive.status import State, Status
from armdrive.storage import files as places
from armdrive.storage.arm_lock import ArmLock, hold
from armdrive.storage.record import RecordFile, RecordInMemory, RecordStore, logbook_file
from armdrive.tasks import Alert, Progress, Task, TaskBody
from armdrive.trace.recorder import FlightRecorder
from armdrive.transports.link import Link
from kinematics.spaces import Joints, Pose

if TYPE_CHECKING:  # a real arm loads no simulation
    from armdrive.sim.simulated_arm import SimulatedArm

PATIENCE_S = 60.0
"""A call that should take no time fails after this long."""

CLOSING_S = 10.0
"""Closing waits at most this long for the disk to record the arm's position."""

T = TypeVar("T")


class TaskRunner:
    """Submits tasks to one arm's engine, waits for their end, and stops them.

    The methods that wait are coroutines that await `Wait` objects; see blocking.py.
    """

    def __init__(self, core: Core, engine: Engine, pace: Pace) -> None:
        self.core = core
        self.engine = engine
        self.pace = pace
        self.stops = 0
        """The number of stops requested so far."""
        self.known_stops = 0
        """The number that this program knows of: its own, those that `Stopped` has reported, and
        those that its user knew of when deciding on a call."""

    # -- stopping -----------------------------------------------------------------------------

    def request_stop(self, *, hard: bool = False, elsewhere: bool = False) -> None:
        """Request a stop and return at once. Takes no lock: a signal handler may call this.

        `elsewhere`: for another program, so that this one does not know of it yet.
        """
        self.stops += 1
        if elsewhere:
            self.engine.stop_why = ": another program asked for it"
        else:
            self.known_stops += 1
        self.core.hold = None
        self.engine.stop_hard = self.engine.stop_hard or hard
        self.engine.stop_asked = True
        self.pace.wake()

    async def stop(self) -> None:
        """Stop, and wait until the arm stands. Raises `NoAnswer` if it does not confirm that."""
        if not await self.stand_still():
            raise NoAnswer("the arm did not confirm that it has stopped: look at it")

    async def stand_still(self) -> bool:
        """Stop; return whether the arm confirms that it stands."""
        self.request_stop()
        # the engine must have handled the stop, or it would stop the next motion
        return await Wait(self.pace, lambda: self.engine.at_rest, PATIENCE_S)

    # -- running ------------------------------------------------------------------------------

    def submit(
        self, body: TaskBody[T], *, alone: bool = False, within_s: float = math.inf
    ) -> Task[T]:
        """Submit a task to the engine. Raises `WrongState` while another task is waiting there.

        With `alone`, also raises while a task is running: a motion never waits for its turn. A task
        that takes longer than `within_s` ends with `NoAnswer`.
        """
        with self.pace.lock:
            task = self.engine.start(body, alone=alone, within_s=within_s)
        self.pace.wake()
        return task

    async def wait(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Wait for `done()`; return False after a timeout. An exception meanwhile stops the arm."""
        try:
            return await Wait(self.pace, done, timeout_s)
        except BaseException:
            await self.stand_still()
            raise

    async def wait_unpaused(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Wait like `wait`, not counting the time for which the arm is paused.

        Raises `WrongState` if the pause lasts too long.
        """
        override = self.core.speed_override
        simulated = not isinstance(self.pace, RealPace)

        def resumed() -> bool:
            if simulated and override.paused and not done():
                override.breathe()
            return done() or not override.paused

        while timeout_s >= 0.0:
            began_s = self.pace.now_s()
            if not await self.wait(lambda: done() or override.paused, timeout_s):
                return False
            if done():
                return True
            timeout_s -= self.pace.now_s() - began_s
            if not await self.wait(resumed, override.longest_s):
                raise given_up(override.longest_s)
        return done()

    async def finish(self, task: Task[T], timeout_s: float) -> T:
        """Wait for a task to end."""
        if not await self._waited(task, timeout_s):
            await self.stand_still()
            raise NoAnswer(f"the motion had not ended after {timeout_s:.0f} s and was stopped")
        return self.result(task)

    def result(self, task: Task[T]) -> T:
        """Return the result of a task that has ended, or raise its error."""
        if isinstance(task.error, Stopped):
            self.know_of(self.stops)
        return task.result()

    async def perform(self, body: TaskBody[T], within_s: float | None = None) -> T:
        """Run a task that moves nothing, and return its result.

        The task takes at most `within_s`, by default `call_limit_s`. If a motion is running, it
        first waits up to a minute for the end of the motion.
        """
        limit_s = self.engine.call_limit_s if within_s is None else within_s
        return await self.finish(self.submit(body, within_s=limit_s), limit_s + PATIENCE_S)

    async def _waited(self, task: Task[Any], timeout_s: float) -> bool:
        """Wait for a task to end; pauses and the speed override extend the timeout."""
        speed_override = self.core.speed_override
        simulated, delay_s = not isinstance(self.pace, RealPace), speed_override.delay_s
        waited_s = -speed_override.waited_s  # pauses of earlier motions do not count

        def ended() -> bool:
            if simulated and not task.done:
                speed_override.nap(waited_s + speed_override.waited_s)
            return task.done

        while not await self.wait(ended, timeout_s):
            timeout_s, delay_s = speed_override.delay_s - delay_s, speed_override.delay_s
            if timeout_s <= 0.0:
                return False
        return True

    # -- requirements of a call ---------------------------------------------------------------

    def require(self, event: Event, action: str = "") -> None:
        """Raise unless the arm may do this now: as `require_link` does, or `WrongState`.

        `action` names the call in the error, if it differs from the event.
        """
        self.require_link()
        after(self.core.state, event, action)

    def require_link(self) -> None:
        """Raise `LinkLost` if the connection was lost, and `WrongState` if it was closed."""
        if (broken := self.engine.broken) is not None:
            raise type(broken)(str(broken))

    def require_stoppable(self) -> None:
        """Raise `LinkLost` if a stop cannot reach the arm."""
        broken = self.engine.broken
        if isinstance(broken, LinkLost):
            raise LinkLost(
                f"the stop did not reach the arm ({broken}): look at the arm, and stop it at its "
                "own switch"
            )

    def require_no_stop(self, since: int | None, when: str) -> None:
        """Raise `Stopped` if a stop was requested since `stops` had the value `since`.

        None stands for the last stop that this program knows of.
        """
        if since is not None:
            self.know_of(since)
        if self.stops != (self.known_stops if since is None else since):
            by = " by another program" if self.stops != self.known_stops else ""
            self.know_of(self.stops)
            raise Stopped(f"a stop was requested{by} {when}")

    def know_of(self, stops: int) -> None:
        """Note that what follows was decided on when there had been this many stops."""
        self.known_stops = max(self.known_stops, stops)

    def absences(self) -> int:
        """Return how often this program or its computer was suspended."""
        with self.pace.lock:
            return self.engine.suspend_count

    def interrupted(self, stops: int, absences: int) -> bool:
        """Return whether a stop or a suspension has come since these counts were taken."""
        return self.stops != stops or self.absences() != absences

    def require_present(self, absences: int) -> None:
        """Raise `Stopped` if this program was suspended since that count was taken."""
        if self.absences() != absences:
            raise Stopped(
                "this program or its computer was suspended: after a suspension, nothing continues "
                "by itself"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """The parts of a connected arm. Call `release` to close them."""

    config: ArmConfig
    pace: Pace
    core: Core
    engine: Engine
    context: MotionContext
    runner: TaskRunner
    reconnector: Reconnector | None
    tracer: FlightRecorder
    operator: Operator | None
    simulated: bool
    twin: SimulatedArm | None = None
    """The simulated device; None for a real arm."""
    logbook: Path | None = None
    """The file of verifications; None for a simulated arm that is not recorded."""
    lock: ArmLock | None = None
    """Keeps other programs off the arm and answers them; None if no program can reach the arm."""
    closers: list[Callable[[], None]] = field(default_factory=list)
    """Functions to call, in this order, once the arm is closed."""

    # -- status -------------------------------------------------------------------------------

    @property
    def status(self) -> Status:
        """A frozen snapshot of the arm."""
        with self.pace.lock:
            jitter = self.pace.lateness.view()
            return self.core.status(self.engine, simulated=self.simulated, scheduling_jitter=jitter)

    @property
    def joints(self) -> Joints:
        """The acknowledged joint angles. Raises `NotReferenced` while the position is unknown."""
        return self.known(self.status.joints)

    @property
    def pose(self) -> Pose:
        """The acknowledged pose. Raises `NotReferenced` while the position is unknown."""
        return self.known(self.status.pose)

    @property
    def speeds(self) -> SpeedLimits:
        """The speed limits for planning; a connected device may report its own limits."""
        config, core = self.config, self.core
        return SpeedLimits(
            config.model.joint_speeds_rad_s,
            config.model.gripper_speed_mm_s,
            core.controller.usable_rate_hz(math.inf),
            core.transmission,
            config.motion.ramp_s,
            config.motion.jerk_s,
            config.accelerations_rad_s2,
        )

    def known(self, value: T | None) -> T:
        """Return a value of the status; raises `NotReferenced` if it is None."""
        if value is None:
            self.core.require_reference("knowing where the arm is needs")
            raise NotReferenced("the position has only just become known: ask again")
        return value

    @blocking
    async def look(self) -> None:
        """Read the device's registers and inputs now."""
        await self.runner.perform(self.context.look())

    # -- closing ------------------------------------------------------------------------------

    def release(self) -> None:
        """Stop the engine, close the link, and finish pending writes."""
        self.pace.close()
        self.engine.link.close()
        self.core.memory.finish(CLOSING_S)
        self.tracer.close()


@blocking
async def assemble(
    config: ArmConfig,
    link: Link,
    pace: Pace,
    *,
    simulated: bool,
    record_store: RecordStore | None = None,
    allow_restored: bool = False,
    operator: Operator | None = None,
    tracer: FlightRecorder | None = None,
    rewiring: NewLink | None = None,
) -> Parts:
    """Connect over an open link; moves nothing. Raises `NoAnswer` if the arm does not answer.

    Without a `record_store`, the position is forgotten at the end of the program.
    """
    with ExitStack() as opened:  # of an arm that does not connect, nothing stays open
        opened.callback(link.close)
        controller = dialect(config.connection.dialect).controller(config)
        # in simulated time a disk takes no time: the record is written at once
        wake = pace.wake if isinstance(pace, RealPace) and record_store is not None else None
        tracer = tracer or FlightRecorder()
        core = Core(config, controller, tracer, record_store or RecordInMemory(), wake)
        core.allow_restored = allow_restored
        core.speed_override.others = isinstance(pace, RealPace)
        core.geometry_known |= simulated  # a simulated arm has the lengths that its file states
        driven = _Driven(core, link, rewiring)
        runner = TaskRunner(core, driven.engine, pace)
        parts = Parts(
            config, pace, core, driven.engine, driven.context, runner, driven.reconnector, tracer,
            operator, simulated,
        )  # fmt: skip
        opened.callback(parts.release)
        tracer.begin(config, link.description, pace.now_s, core.condition, pace.lock)
        pace.start(driven.engine)  # from here on another thread may call the engine
        await runner.perform(connecting.connect(driven.context))
        with pace.lock:
            tracer.opened()
        opened.pop_all()
    return parts


class _Driven:
    """The engine of one arm, which reports stops, losses and alerts to the arm's state."""

    def __init__(self, core: Core, link: Link, rewiring: NewLink | None) -> None:
        self._core = core
        self.engine = Engine(
            link,
            core.controller,
            idle=self._idle,
            stopping=self._stopping,
            lost=self._lost,
            noticed=self._noticed,
            tracer=core.tracer,
            received=Received(dialect(core.config.connection.dialect).driver().frames),
            call_limit_s=call_limit_s(core.config.device),
        )
        self.context = MotionContext(self.engine, core)
        self.reconnector = None if rewiring is None else Reconnector(self.context, rewiring)
        self.engine.reconnect = self.reconnector
        self._idling = connecting.Idling(self.context)

    def _idle(self, now_s: float) -> tuple[float, TaskBody[Any] | None]:
        return self._idling.due(now_s)

    def _stopping(self) -> None:
        self._core.speed_override.end_pause()
        if self._core.state in (State.MOVING, State.HOMING):
            self._core.happen(Event.STOP)
        elif self._core.state is not State.STOPPING and self.engine.stop_why:
            # no call is under way that would report it
            self._core.notify(f"the arm was stopped{self.engine.stop_why}", Stopped())

    def _noticed(self, event: Alert | Progress) -> None:
        if isinstance(event, Progress):
            self._core.position.progress(event.registers)
        else:
            alerted(self._core, event, self.engine.now_s)

    def _lost(self, lost: LinkLost) -> None:
        self._core.lose(lost)
        self._core.remember()
        if self.reconnector is not None:
            self.reconnector.lost(self.engine.now_s)


# Opening the link to an arm, and connecting.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ConnectOptions:
    """The options of `Arm.connect`, which documents each of them."""

    dialect: str | None = None
    baud: int | None = None
    pace: PaceChoice = None
    allow_restored: bool = False
    operator: Operator | None = None
    twin: SimulatedArm | None = None
    reconnect: bool | None = None
    clock: SimulatedClock | None = None
    """The clock of a simulated arm if `pace` is None; by default a clock of its own."""

    @property
    def simulated_pace(self) -> PaceChoice:
        """The pace of a simulated arm."""
        return self.clock if self.pace is None else self.pace


@blocking
async def connect(target: str | None, options: ConnectOptions) -> Parts:
    """Connect; see `Arm.connect`."""
    name = DEFAULT_TARGET if target is None else target
    found = find(name, dialect_name=options.dialect, baud=options.baud)
    if found.simulated:
        return await coroutine_of(connect_simulated)(
            found.config,
            twin=options.twin,
            pace=options.simulated_pace,
            operator=options.operator,
            allow_restored=options.allow_restored,
            reconnect=options.reconnect,
        )
    if options.pace not in (None, "real", 1.0):
        raise BadRequest("a real arm runs in real time: leave out pace=")
    return await coroutine_of(connect_real)(found.config, options)


@blocking
async def connect_simulated(
    config: ArmConfig,
    *,
    twin: SimulatedArm | None = None,
    pace: PaceChoice = None,
    operator: Operator | None = None,
    record_store: RecordStore | None = None,
    allow_restored: bool = False,
    tracer: FlightRecorder | None = None,
    reconnect: bool | None = None,
) -> Parts:
    """Connect to a simulated twin in this process, in simulated time unless `pace` says real."""
    twin, chosen = twin or simulate(config), pace_of(pace)
    parts = await coroutine_of(assemble)(
        config,
        twin.link,
        chosen,
        simulated=True,
        record_store=record_store,
        operator=operator or twin.operator,
        allow_restored=allow_restored,
        tracer=tracer,
        rewiring=_rewiring(twin, chosen, automatic=_wanted(reconnect, config)),
    )
    return replace(parts, twin=twin)


@blocking
async def connect_real(config: ArmConfig, options: ConnectOptions = ConnectOptions()) -> Parts:
    """Open the arm's port and connect; one program at a time holds an arm.

    If another dialect answers, the `DeviceFault` names it.
    """
    from armdrive.connect.port import PortOpening, explaining  # a simulated arm has no port

    require_real_ports()
    wiring = PortOpening(config)
    with ExitStack() as opened:
        lock = opened.enter_context(hold(config.name, wiring.find()))
        recorder = FlightRecorder(places.recordings())
        with explaining(recorder.ring.entries, config.connection):
            parts = await coroutine_of(assemble)(
                config,
                wiring.open(),
                RealPace(),
                simulated=False,
                record_store=RecordFile(state_file(config.name)),
                allow_restored=options.allow_restored,
                operator=options.operator,
                tracer=recorder,
                rewiring=NewLink(wiring.open, _wanted(options.reconnect, config), in_thread=True),
            )
        opened.callback(parts.release)
        logbook = logbook_file(config.name)
        held = replace(parts, logbook=logbook, lock=lock, closers=[lock.release])
        opened.pop_all()
    return held


def _rewiring(twin: SimulatedArm, pace: Pace, *, automatic: bool) -> NewLink | None:
    """Return how to reopen a twin's link; None if a test has replaced the link."""
    link = twin.device_link
    return NewLink(lambda: link.reopen(pace.now_s()), automatic) if twin.link is link else None


def _wanted(reconnect: bool | None, config: ArmConfig) -> bool:
    """Return whether to reconnect automatically; the arm file has the default."""
    return config.connection.reconnect if reconnect is None else reconnect
