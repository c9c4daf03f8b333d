"""The controller of CiA 402 drives on a CANopen bus: requests to frames, frames to events.

    a request   `carry_out` runs its script
    bytes       the codec decodes events, `Cia402Exchange.note` records all of them, then the script
                continues with that state
    a stop      `stop_asked` is set; a motion ends its cycle and stops every drive
    time        the script continues, the heartbeat is sent, and drives at rest are watched

Positions come from the drives' encoders. Sources: CiA 301 (CANopen) and CiA 402-2
(IEC 61800-7-201, the drive profile).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from armdrive.abilities import SEGMENTS_AHEAD, Abilities
from armdrive.config.arm import ArmConfig
from armdrive.dialects import Driver
from armdrive.dialects.bus.drives import BUS_REQUESTS, bus_motors
from armdrive.dialects.cia402.compare import compare, fix
from armdrive.dialects.cia402.contact import (
    connect,
    disable,
    enable,
    read,
    reset,
    shutdown_frames,
)
from armdrive.dialects.cia402.drives import FAULTS, Cia402Drive
from armdrive.dialects.cia402.exchange import Cia402Exchange
from armdrive.dialects.cia402.homing import home, read_speeds
from armdrive.dialects.cia402.measuring import measure_units
from armdrive.dialects.cia402.motion import burst, stream
from armdrive.dialects.cia402.settings import TOP_HZ, Cia402Settings, DriveLimits
from armdrive.dialects.cia402.transfers import Script
from armdrive.dialects.controller import (
    HOST_DELAY_S,
    ScriptRunner,
    Search,
    StopPart,
    Stopping,
)
from armdrive.dialects.exchange import Obstructed
from armdrive.errors import Refused
from armdrive.errors.printable import command_line
from armdrive.tasks import (
    DropCurrent,
    FixSetting,
    HomeDevice,
    MeasureUnits,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadSettings,
    Reply,
    Request,
    SwitchOn,
)
from firmware_protocol.canopen import Emergency, HostEvent
from firmware_protocol.frames import Unpacker
from kinematics.spaces import Motors

# The least speed that is commanded, in increments a second: drives count whole ones.
MIN_HZ = 1.0
# How far a drive may be off its share of a burst, since speeds and ramps are whole numbers of
# increments/s; drives with a greater unit of speed may be farther off by as much.
ROUNDING = 2.0


def carry_out(io: Cia402Exchange, config: ArmConfig, request: Request) -> Script[Reply]:
    """Carry out a request; the first one makes contact with the drives before it."""
    for _ in range(2):
        try:
            reply = yield from _attempt(io, config, request)
            break
        except Obstructed as obstructed:
            reply = obstructed.reply
        if not any(drive.dropped_out for drive in io.drives):
            break  # else they missed a heartbeat at rest, and then the question: ask again
    for drive in io.drives:
        if drive.state in FAULTS and not drive.alerted:
            yield from io.explain(drive)
    io.report_troubles()
    return reply


def _attempt(io: Cia402Exchange, config: ArmConfig, request: Request) -> Script[Reply]:
    """Make contact if necessary, and carry out a request. Raises `Obstructed`."""
    _require_unbroken(io, request)
    if not io.contacted:
        yield from connect(io)
        if config.homing is not None:
            yield from read_speeds(io, io.drives)
    if isinstance(request, MoveBy | MoveAlong | HomeDevice):
        _require_units(io, config.name)
    match request:
        case MoveBy(steps, rate_hz, released):
            script = burst(io, steps, rate_hz, released)
        case MoveAlong():
            script = stream(io, request)
        case HomeDevice(groups):
            script = home(io, groups)
        case MeasureUnits(motor, steps):
            script = measure_units(io, io.drives[motor], steps)
        case ReadPosition():
            script = read(io)
        case ReadSettings():
            script = compare(io)
        case FixSetting(line):
            script = fix(io, line)
        case SwitchOn():
            script = enable(io)
        case DropCurrent():
            script = disable(io)
        case _:
            script = reset(io)
    return (yield from script)


def _require_unbroken(io: Cia402Exchange, request: Request) -> None:
    """Raise `Obstructed` if a motion goes on with this request although a drive left it.

    Drives that missed a heartbeat, or that another master took out of operation, may have stopped
    between two bursts of a motion, or between two groups that home. So only a request that moves
    nothing takes them back: at rest, the next reading of the positions, but none midway through a
    motion.
    """
    moves = isinstance(request, MoveBy | MoveAlong | HomeDevice)
    goes_on = moves or (isinstance(request, ReadPosition) and request.midway)
    for drive in io.drives:
        trouble = None if drive.operates else drive.trouble(on=True, moving=True)
        if goes_on and io.on and trouble is not None:
            alert = trouble.alert(drive)
            io.alarm(alert, drive)
            raise Obstructed(alert.text)


def _require_units(io: Cia402Exchange, arm: str) -> None:
    """Raise `Obstructed` for a drive whose unit of speed is unknown: it might turn too fast."""
    for drive in io.drives:
        if not drive.speed_unit_hz:
            measure = command_line("can", "setup", arm)
            raise Obstructed(
                f"{drive} does not report its unit of speed (object 60A9): `{measure}` "
                "measures it, or write cia402.speed_units as its manual says"
            )


class Cia402Controller(ScriptRunner[HostEvent]):
    """Drives the drives of one arm: what the engine calls, and the bounds of stops."""

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: Cia402Settings = config.device
        motors = bus_motors(config, "cia402", settings.ids)
        names = ("ids", "homing_methods", "speed_units", "ramp_units")
        own = {name: getattr(settings, name)[: motors.count] for name in names}
        self.settings = settings = replace(settings, **own)
        self.limits = limits = DriveLimits.of(settings, motors, config.connection.baud)
        order_s = (settings.heartbeat_timeout_ms - settings.heartbeat_period_ms) / 1000.0
        self._exchange = io = Cia402Exchange(settings, limits, motors.names, self.unsolicited)
        super().__init__(replace(abilities, motors=motors.count, order_s=order_s), io.host, io)
        self._config = config
        self._choose()

    # -- requests -----------------------------------------------------------------------------

    def script(self, request: Request) -> Script[Reply]:
        """Carry out a request; earlier transfers are given up."""
        if not isinstance(request, (*BUS_REQUESTS, MeasureUnits)):
            raise Refused(f"CiA 402 drives do not support {type(request).__name__}")
        self.give_up()
        self._exchange.began_s = self.io.now_s
        reply = yield from carry_out(self._exchange, self._config, request)
        self._choose()
        return reply

    def _choose(self) -> None:
        """Stream cyclic targets if the drives and the arm file allow it, else send bursts."""
        queued = SEGMENTS_AHEAD if self._exchange.is_cyclic else 0
        self.abilities = replace(self.abilities, queued_segments=queued)

    @property
    def drives(self) -> tuple[Cia402Drive, ...]:
        """The drives, in the order of the motors."""
        return self._exchange.drives

    def unsolicited(self, event: HostEvent) -> None:
        """Record an event; between requests, report what is wrong."""
        io = self._exchange
        io.note(event)
        if self.busy:
            return
        if isinstance(event, Emergency) and io.contacted:
            io.sync()  # to read the drive's new state
        io.report_troubles()

    def give_up(self) -> None:
        """Give up all transfers."""
        self._exchange.transfers.give_up(self.drives)
        self._exchange.host.silence()

    # -- what the engine calls ----------------------------------------------------------------

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the bus; all events are recorded before a script continues."""
        io = self._exchange
        io.listened.pass_to(now_s)
        io.now_s = now_s
        io.host.receive_data(data)
        while (event := io.host.next_event()) is not None:
            self.unsolicited(event)
        io.out += io.host.owed()
        self._loop.step(None)

    def advance(self, now_s: float) -> bytes:
        """Do what is due, and send the heartbeat in any case."""
        frames = super().advance(now_s)
        beat = self._exchange.beats.beat(now_s)
        self.io.listened.expect(self.next_s())
        return beat + frames

    def next_s(self) -> float:
        """Return when the script continues, or the heartbeat is due."""
        return min(super().next_s(), self._exchange.beats.due_s)

    def stop(self, *, hard: bool) -> None:
        """Stop the script, and discard targets that were not sent yet.

        A drive that has stopped by itself meanwhile would take them as orders to continue.
        """
        if self.busy and not self.io.stop_asked and self.io.now_s > self._exchange.began_s:
            self.io.out.clear()
        super().stop(hard=hard)

    def shutdown_frames(self) -> bytes:
        """Return frames that end the heartbeat watch: the drives then hold without an alarm."""
        return b"" if self.busy else shutdown_frames(self._exchange)

    # -- numbers ------------------------------------------------------------------------------

    @property
    def underruns(self) -> int:
        """How often a cycle was late, or the path ended although more was to come."""
        return self._exchange.underruns

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate within the range that can be commanded."""
        return max(min(rate_hz, TOP_HZ), MIN_HZ)

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long a number of steps takes from rest to rest."""
        return self.limits.lasts_s(steps, self.usable_rate_hz(rate_hz))

    @property
    def _unwatched_s(self) -> float:
        """How long after the host has fallen silent drives that watch its heartbeat notice that."""
        return (
            HOST_DELAY_S
            + (self.settings.heartbeat_timeout_ms + self.settings.heartbeat_period_ms) / 1000.0
        )

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound a stop by the quick stop and its delay; without a host, by the heartbeat too."""
        rate_hz = max((part.rate_hz for part in parts), default=self.limits.fastest_hz)
        ramp_s = self.limits.quick_stop_s(rate_hz)
        begun_s = HOST_DELAY_S + 2.0 * self.limits.cycle_s
        silent_s = self._unwatched_s
        if self.abilities.queued_segments:  # a pause slows down along the path
            smooth_s = self.settings.smoothing_ms / 1000.0
            eases_s = self.limits.ramp_s(rate_hz)
            silent_s = max(silent_s, begun_s + smooth_s + eases_s - ramp_s)
        else:
            ends_s = burst_s + HOST_DELAY_S
            silent_s = min(silent_s, ends_s) if self._exchange.watches else ends_s
        return Stopping(
            begun_s + ramp_s,
            begun_s + ramp_s / 2.0,
            silent_s + ramp_s,
            silent_s + ramp_s / 2.0,
        )

    def search(self, request: HomeDevice) -> Search:
        """Bound the drives' own homing: by their heartbeat watch, else by their searches."""
        found = self._exchange.homing.estimate(request.groups)
        if not self._exchange.watches:
            return Search(found.longest.s, lasts=found.lasts)
        ramp_s, silent_s = self.limits.quick_stop_s(found.rate_hz), self._unwatched_s
        most_steps = (silent_s + ramp_s / 2.0) * found.rate_hz
        return Search(silent_s + ramp_s, most_steps, found.lasts)

    def deviation_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:  # noqa: ARG002
        """Bound each drive's deviation from the straight path, due to rounding in bursts."""
        if self.abilities.queued_segments:
            return (0.0,) * len(steps)
        units = (max(drive.speed_unit_hz, 1.0) for drive in self.drives)
        return tuple(
            ROUNDING * unit if count else 0.0 for count, unit in zip(steps, units, strict=True)
        )

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Return the registers; a drive near where it was left is taken to be there."""
        return Motors(
            drive.found_near(there) if count == drive.goal else count
            for drive, count, there in zip(self.drives, registers, near, strict=True)
        )


DRIVER = Driver(Cia402Settings, Cia402Controller, Unpacker, lambda settings: settings.frame_ids)
