"""The driver's end of CiA 402 drives on a CANopen bus: neutral requests to frames and back.

    a request   `script` picks the collaborator that carries it out, after contact was made; what
                hinders it is raised as `Hindered`, with the reply
    bytes       the bus reads events, and `DriveGroup` notes them all; then the script goes on, and
                looks at what is known
    a stop      `stop_asked` is set; a motion ends its turn and stops every drive
    time        the script goes on, the heartbeat is sent, and drives at rest are minded

Position is what the drives' encoders tell. Sources: CiA 301 (CANopen) and CiA 402-2
(IEC 61800-7-201, the drive profile).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from armdrive.abilities import Abilities, segment_s
from armdrive.config.arm import ArmConfig
from armdrive.dialects.bus.group import BUS_REQUESTS
from armdrive.dialects.bus.motors import ALL_SILENT, HOST_S, bus_motors
from armdrive.dialects.bus.observer import unwrapped
from armdrive.dialects.cia402.contact import Cia402Contact, compare, mend
from armdrive.dialects.cia402.exchange import (
    BEATS_LOST,
    Cia402Exchange,
    DriveStates,
    Hindered,
    ObjectTransfers,
    Script,
)
from armdrive.dialects.cia402.leading import MotionLead
from armdrive.dialects.cia402.motion import Cia402Homing, CyclicMotion, ProfileMotion
from armdrive.dialects.cia402.settings import TOP_HZ, Cia402Settings, DriveLimits
from armdrive.dialects.cia402.wire import (
    Cia402Bus,
    DriveGroup,
    Heard,
    HeartbeatProducer,
)
from armdrive.dialects.controller import ScriptRunner, StopPart, Stopping
from armdrive.dialects.dialect import Driver
from armdrive.errors import Refused
from armdrive.tasks import (
    DropCurrent,
    HomeDevice,
    MendSetting,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadSettings,
    Reply,
    Request,
    SwitchOn,
)
from firmware_protocol.canopen import Emergency
from firmware_protocol.frames import Unpacker
from kinematics.spaces import Motors

LEAST_HZ = 1.0
AHEAD = 3
"""So many segments are known ahead: the drives hold the last target alone."""
SEEN_TURNS = 8
"""So many turns pass at most until it is seen that a drive stands, and it is taken back."""
BESIDE = 2.0
"""How far a drive is beside its share of a burst, by speeds and ramps in whole numbers."""


class Cia402Controller(ScriptRunner[Heard]):
    """The drives of one arm, seen from the driver: hands each request to a collaborator."""

    look_at = ALL_SILENT

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: Cia402Settings = config.device
        motors = bus_motors(config, "cia402", settings.ids)
        ids, methods = settings.ids[: motors.count], settings.homing_methods[: motors.count]
        self.settings = settings = replace(settings, ids=ids, homing_methods=methods)
        self.limits = limits = DriveLimits.of(settings, motors, config.connection.baud)
        order_s = (settings.heartbeat_ms - settings.beat_ms) / 1000.0
        self._bus = bus = Cia402Bus(settings.ids)
        super().__init__(replace(abilities, motors=motors.count, order_s=order_s), bus)
        self.io.look_at = ALL_SILENT
        self.group = group = DriveGroup(self.io, settings, motors.names)
        self.beats = beats = HeartbeatProducer(settings.master_id, settings.beat_ms / 1000.0)
        self._exchange = exchange = Cia402Exchange(
            self.io, bus, group, settings.answer_s, limits.cycle_s
        )
        self._transfers = transfers = ObjectTransfers(self.io, bus, group, exchange)
        states = DriveStates(exchange, group)
        lead = MotionLead(self.io, exchange, transfers, group, states, beats, settings)
        self._contact = Cia402Contact(
            self.io, exchange, transfers, group, states, beats, settings, limits.quick_hz_s
        )
        self._cyclic = CyclicMotion(lead, limits)
        self._profile = ProfileMotion(lead, limits)
        self._homing = Cia402Homing(lead, limits)
        self._silent_s = BEATS_LOST * settings.drive_beat_ms / 1000.0
        self.abilities = replace(self.abilities, queued_segments=AHEAD * group.is_cyclic)

    # -- what happens -------------------------------------------------------------------------

    def script(self, request: Request) -> Script[Reply]:
        """Carry out a request; the first one makes contact with the drives before it.

        Nothing that was asked before is waited for any more, and what was found to be wrong
        meanwhile is told.
        """
        if not isinstance(request, BUS_REQUESTS):
            raise Refused(f"CiA 402 drives know no {type(request).__name__}")
        self.give_up()
        self._exchange.began_s = self.io.now_s
        try:
            if not self.group.contacted:
                yield from self._contact.make()
            reply = yield from self._carry_out(request)
        except Hindered as hindered:
            reply = hindered.reply
        for drive in self.group.drives:
            self.group.report(drive)
        self.abilities = replace(self.abilities, queued_segments=AHEAD * self.group.is_cyclic)
        return reply

    def _carry_out(self, request: Request) -> Script[Reply]:
        match request:
            case MoveBy(steps, rate_hz, let_go):
                return self._profile.burst(steps, rate_hz, let_go)
            case MoveAlong():
                return self._cyclic.drive(request)
            case ReadPosition():
                return self._contact.read()
            case ReadSettings():
                return compare(self._transfers, self.settings)
            case MendSetting(line):
                return mend(self._transfers, line)
            case SwitchOn():
                return self._contact.switch_on()
            case DropCurrent():
                return self._contact.switch_off()
            case HomeDevice(groups):
                return self._homing.home(groups)
            case _:
                return self._contact.clear()

    def unasked(self, heard: Heard) -> None:
        """Note what comes; while no script is at work, tell what is wrong."""
        self.group.heed(heard, self._exchange.listened.s)
        drive = self.group.by_node.get(getattr(heard, "node", 0))
        if drive is None or self.busy:
            return
        if isinstance(heard, Emergency) and self.group.contacted:  # what has become of it?
            self._exchange.sync()
        self.group.report(drive)

    def give_up(self) -> None:
        """Wait for no answer any more."""
        self._transfers.give_up()

    # -- what the engine calls ----------------------------------------------------------------

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the bus; all that has come is noted before a script goes on."""
        self._exchange.listened.pass_to(now_s)
        self.io.now_s = now_s
        self._bus.receive_data(data)
        while (heard := self._bus.next_event()) is not None:
            self.unasked(heard)
        self.io.say(self._bus.owed())
        self._loop.step(None)

    def advance(self, now_s: float) -> bytes:
        """Do what is due by now; the heartbeat is, whatever else."""
        self._exchange.listened.pass_to(now_s)
        self.io.now_s = now_s
        if self.group.on and self.group.contacted and not self.busy:
            self._exchange.mind(self._silent_s, self.beats.period_s)
        said = super().advance(now_s)
        beat = self.beats.say(now_s)
        self._exchange.listened.expect(self.next_s())
        return beat + said

    def next_s(self) -> float:
        """Tell when the script wants to go on, or the heartbeat is due."""
        return min(super().next_s(), self.beats.due_s)

    def stop(self, *, hard: bool) -> None:
        """Have the script know of a stop; a target that was not said yet never is.

        To a drive that has stopped by itself meanwhile it is an order to go on.
        """
        if self.busy and not self.io.stop_asked and self.io.now_s > self._exchange.began_s:
            self.io.out.clear()
        super().stop(hard=hard)

    def farewell(self) -> bytes:
        """Have drives that stand mind the heartbeat no more: they hold, and none of them alarms."""
        return b"" if self.busy else self._contact.farewell()

    # -- numbers ------------------------------------------------------------------------------

    @property
    def underruns(self) -> int:
        """How often a cyclic motion was late, or had nothing to drive though more was to come."""
        return self._cyclic.underruns

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return any rate that can be written; the drives are as fast as their motors."""
        return max(min(rate_hz, TOP_HZ), LEAST_HZ)

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long so many steps take from rest to rest."""
        return self.limits.lasts_s(steps, self.usable_rate_hz(rate_hz))

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Return a quick stop and what passes before it; without a host, the missing heartbeat."""
        rate_hz = max((part.rate_hz for part in parts), default=self.limits.fastest_hz)
        share = min(rate_hz / self.limits.fastest_hz, 1.0)
        ramp_s, begun_s = self.settings.quick_stop_s * share, HOST_S + 2.0 * self.limits.cycle_s
        beats_ms = self.settings.heartbeat_ms + self.settings.beat_ms
        silent_s = HOST_S + beats_ms / 1000.0
        if self.abilities.queued_segments:  # a pause drives what was drawn to its end
            smooth_s = self.settings.smoothing_ms / 1000.0
            eases_s = self.settings.ramp_s * share
            silent_s = max(silent_s, segment_s(burst_s) + smooth_s + eases_s - ramp_s)
        else:
            silent_s = min(silent_s, burst_s + HOST_S)
        return Stopping(
            begun_s + ramp_s,
            begun_s + ramp_s / 2.0,
            silent_s + ramp_s,
            silent_s + ramp_s / 2.0,
            begun_s + ramp_s + SEEN_TURNS * self.limits.cycle_s,
        )

    def strays_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:  # noqa: ARG002
        """Bound how far a drive is beside the straight way: of a burst, by whole numbers."""
        if self.abilities.queued_segments:
            return (0.0,) * len(steps)
        return tuple(BESIDE if count else 0.0 for count in steps)

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Take a drive that was found within reach of where it was left for being there still."""
        return unwrapped(
            [drive.shaft for drive in self.group.drives], registers, near, self.io.now_s
        )


DRIVER = Driver(Cia402Settings, Cia402Controller, Unpacker)
