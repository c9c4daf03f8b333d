"""The parts of a connected arm: its state, engine and clock, its connection and its runner.

`connect` opens the link to an arm or to its simulated twin. `assemble` puts the parts together on
an open link and connects. `Arm(parts)` adds the public calls.
"""

from __future__ import annotations

import math
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

from armdrive.blocking import blocking, coroutine_of
from armdrive.config.arm import ArmConfig
from armdrive.connect.connection import ArmConnection, hold_arm
from armdrive.connect.port import NewLink, Reconnector
from armdrive.connect.runner import TaskRunner
from armdrive.connect.target import DEFAULT_TARGET, find, require_real_ports, state_file
from armdrive.dialog import Operator
from armdrive.errors import BadRequest, LinkLost, NotReferenced, Stopped
from armdrive.motion import connecting
from armdrive.motion.context import MotionContext
from armdrive.motion.plan import SpeedLimits
from armdrive.registry import dialect, simulate
from armdrive.runtime.arm_state import Core, alerted
from armdrive.runtime.clock import Pace, PaceChoice, RealPace, SimulatedClock, pace_of
from armdrive.runtime.engine import Engine, call_limit_s
from armdrive.runtime.states import Event
from armdrive.status import State, Status
from armdrive.storage import files as places
from armdrive.storage.arm_lock import ArmLock
from armdrive.storage.record import RecordFile, RecordInMemory, RecordStore
from armdrive.tasks import Alert, Progress, TaskBody
from armdrive.trace.recorder import FlightRecorder
from armdrive.transports.link import Link
from kinematics.spaces import Joints, Pose

if TYPE_CHECKING:  # a real arm loads no simulation
    from armdrive.sim.simulated_arm import SimulatedArm

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """The parts of a connected arm."""

    config: ArmConfig
    pace: Pace
    core: Core
    engine: Engine
    context: MotionContext
    runner: TaskRunner
    connection: ArmConnection
    tracer: FlightRecorder
    operator: Operator | None
    simulated: bool
    twin: SimulatedArm | None = None
    """The simulated device; None for a real arm."""
    lock: ArmLock | None = None
    """Keeps other programs off the arm and answers them; None if no program can reach the arm."""

    # -- status -------------------------------------------------------------------------------

    @property
    def status(self) -> Status:
        """A frozen snapshot of the arm."""
        return self.connection.status

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

    A link of which no arm comes is closed by its opener.

    Without a `record_store`, the position is forgotten at the end of the program.
    """
    with ExitStack() as opened:  # of an arm that does not connect, nothing stays open
        controller = dialect(config.connection.dialect).controller(config)
        # in simulated time a disk takes no time: the record is written at once
        wake = pace.wake if pace.real_time and record_store is not None else None
        tracer = tracer or FlightRecorder()
        core = Core(config, controller, tracer, record_store or RecordInMemory(), wake)
        core.allow_restored = allow_restored
        core.speed_override.others = pace.real_time
        core.geometry_known |= simulated  # a simulated arm has the lengths that its file states
        driven = _Driven(core, link, rewiring)
        runner = TaskRunner(core, driven.engine, pace)
        connection = ArmConnection(runner, driven.reconnector, simulated=simulated)
        opened.callback(connection.release)
        if pace.real_time:  # its thread would drive the arm on
            connection.guard()
        parts = Parts(
            config, pace, core, driven.engine, driven.context, runner, connection, tracer,
            operator, simulated,
        )  # fmt: skip
        tracer.begin(config, link.description, pace.now_s, core.condition, pace.lock)
        record = connecting.believe_record(core, pace.now_s())
        pace.start(driven.engine)  # from here on another thread may call the engine
        await runner.perform(connecting.connect(driven.context, record))
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
        # The lock comes before the port: opening a port resets some boards, also one that another
        # program is driving. It goes by both names, because two arm files may name one port.
        lock = opened.enter_context(hold_arm(config.name, wiring.find()))
        recorder = FlightRecorder(places.recordings())
        with explaining(recorder.ring.entries, config.connection):
            link = opened.enter_context(closing(wiring.open()))
            parts = await coroutine_of(assemble)(
                config,
                link,
                RealPace(),
                simulated=False,
                record_store=RecordFile(state_file(config.name)),
                allow_restored=options.allow_restored,
                operator=options.operator,
                tracer=recorder,
                rewiring=NewLink(wiring.open, _wanted(options.reconnect, config), in_thread=True),
            )
        opened.callback(parts.connection.release)
        parts.connection.closers.append(lock.release)
        held = replace(parts, lock=lock)
        opened.pop_all()
    return held


def _rewiring(twin: SimulatedArm, pace: Pace, *, automatic: bool) -> NewLink | None:
    """Return how to reopen a twin's link; None if a test has replaced the link."""
    link = twin.device_link
    return NewLink(lambda: link.reopen(pace.now_s()), automatic) if twin.link is link else None


def _wanted(reconnect: bool | None, config: ArmConfig) -> bool:
    """Return whether to reconnect automatically; the arm file has the default."""
    return config.connection.reconnect if reconnect is None else reconnect
