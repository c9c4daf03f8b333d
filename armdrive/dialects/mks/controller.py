"""The driver's end of MKS SERVO42D/57D drives on a CAN bus: neutral requests to frames and back.

Position is what the drives' encoders tell. Sources: makerbase-motor/MKS-SERVO42D-57D, the CAN
manuals 1.0.6 and 1.0.9.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from armdrive.abilities import Abilities
from armdrive.config.arm import ArmConfig
from armdrive.dialects.bus.group import BUS_REQUESTS
from armdrive.dialects.bus.motors import HOST_S, bus_motors
from armdrive.dialects.bus.observer import LATE_S, unwrapped
from armdrive.dialects.bus.way import trapezoid_s
from armdrive.dialects.controller import ScriptRunner, StopPart, Stopping
from armdrive.dialects.dialect import Driver
from armdrive.dialects.mks.bursts import MksBursts
from armdrive.dialects.mks.compare import MksComparing
from armdrive.dialects.mks.contact import MksContact
from armdrive.dialects.mks.homing import MksHoming
from armdrive.dialects.mks.inquiry import MksInquiry
from armdrive.dialects.mks.motion import MksMotion
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.steering import CATCH_UP, CATCH_UP_RPM, catch_up_rpm
from armdrive.dialects.mks.stops import STOP_POLL_S, MksStops
from armdrive.dialects.mks.wire import MksWire, Script
from armdrive.errors import Refused
from armdrive.tasks import (
    Done,
    DropCurrent,
    HomeDevice,
    MendSetting,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadSettings,
    Request,
    RequestRejected,
    SwitchOn,
)
from firmware_protocol.frames import Unpacker
from firmware_protocol.mks import COUNTS_S_PER_RPM, SPEED_MAX_RPM, Ability, Event, slope_of
from kinematics.spaces import Motors

STEERED = 3
"""So many segments are known ahead: the drives hold the last order alone."""


class MksController(ScriptRunner[Event]):
    """The drives of one arm, seen from the driver."""

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: MksSettings = config.device
        motors = bus_motors(config, "mks", settings.ids)
        settings = replace(settings, ids=settings.ids[: motors.count])
        self.settings = settings
        self._slope = slope_of(settings.acceleration)
        self._fastest_hz = min(motors.fastest_hz, _TOP_HZ)
        self.ramp_s = self._fastest_hz / self._slope
        """How long the fastest drive of the arm brakes."""
        self._wire = wire = MksWire(settings, motors.names)
        super().__init__(replace(abilities, motors=motors.count), wire.host, wire)
        self._stops = MksStops(wire, self.ramp_s)
        self._inquiry = MksInquiry(wire)
        self._contact = MksContact(wire, self._stops, self._inquiry, self._choose)
        self._motion = MksMotion(wire, self._stops, self._inquiry)
        self._bursts = MksBursts(wire, self._stops, self._inquiry, self._motion)
        self._homing = MksHoming(wire, self._stops, motors.ranges)
        self._comparing = MksComparing(wire)
        if settings.version is None and not settings.segment_s:
            self._choose()

    def _choose(self) -> None:
        """Steer where the firmware and the arm file let us, else send bursts."""
        told = not self._contact.firmware or self._wire.can(Ability.RETARGET)
        steered = bool(self.settings.segment_s) and told
        self.abilities = replace(
            self.abilities, coordinated=steered, queued_segments=STEERED if steered else 0
        )

    @property
    def firmware(self) -> str:
        """The oldest firmware of the drives, as far as it is known."""
        return self._contact.firmware

    @property
    def watched(self) -> bool:
        """Whether every drive is known to stop when the bus is silent."""
        return self._contact.watched

    @property
    def underruns(self) -> int:
        """How often drives stood still although more of their motion was to come."""
        return self._motion.underruns

    # -- requests -----------------------------------------------------------------------------

    def script(self, request: Request) -> Script:
        """Carry out a request; the first one makes contact with the drives before it."""
        if not isinstance(request, BUS_REQUESTS):
            raise Refused(f"MKS drives know no {type(request).__name__}")
        return self._script_of(request)

    def _script_of(self, request: Request) -> Script:
        contact = self._contact
        if not contact.made and (hindrance := (yield from contact.make())) is not None:
            return hindrance
        match request:
            case MoveBy() | MoveAlong() | HomeDevice():
                return (yield from self._move(request))
            case ReadPosition():
                return (yield from self._read())
            case ReadSettings():
                return (yield from self._comparing.compare(contact.firmware))
            case MendSetting(line):
                return (yield from self._comparing.mend(line))
            case SwitchOn():
                return (yield from contact.switch_on())
            case DropCurrent():
                return (yield from contact.switch_off())
            case _:
                return (yield from contact.clear())

    def _move(self, request: MoveBy | MoveAlong | HomeDevice) -> Script:
        if (hindrance := (yield from self._motion.prepare(held=self._contact.on))) is not None:
            return hindrance
        match request:
            case HomeDevice(groups):
                homed = yield from self._homing.home(groups)
                rests = None if homed != Done() else (yield from self._contact.take_up())
                return rests or homed
            case MoveBy(steps, rate_hz, let_go) if not self.abilities.queued_segments:
                return (yield from self._bursts.burst(steps, rate_hz, let_go))
            case MoveBy(let_go=let_go):
                along = MoveAlong(iter((request,)), request.duration_s + 1.0, let_go=let_go)
                return (yield from self._motion.along(along))
            case MoveAlong():
                return (yield from self._motion.along(request))

    def _read(self) -> Script:
        """Read every encoder; a drive that holds, and is not where it should be, is looked into."""
        wire = self._wire
        began_s = wire.now_s
        if missing := (yield from wire.look()):
            absence = wire.absence(missing, began_s)
            return replace(absence, moved=True) if isinstance(absence, RequestRejected) else absence
        for drive in wire.drives:
            if not self._contact.on or drive.moving or drive.is_near:
                continue
            wire.tell((yield from self._inquiry.found_at_rest(drive)))
            drive.rest_at(drive.count or 0, wire.now_s)
        return wire.registers()

    # -- what the engine calls ----------------------------------------------------------------

    def begin(self, request: Request, now_s: float) -> None:
        """Take up a request; nothing that was asked before is waited for any more."""
        if not self.busy:
            self.give_up()
        super().begin(request, now_s)

    def give_up(self) -> None:
        """Wait for no answer any more."""
        self._wire.give_up()

    def unasked(self, heard: Event) -> None:
        """Weigh what no script was waiting for."""
        self._wire.unasked(heard)

    # -- numbers ------------------------------------------------------------------------------

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate in whole rpm in bursts; steered, any rate up to the fastest."""
        if self.abilities.queued_segments:
            return max(min(rate_hz, _TOP_HZ), COUNTS_S_PER_RPM / 100.0)
        rpm = SPEED_MAX_RPM if math.isinf(rate_hz) else math.floor(rate_hz / COUNTS_S_PER_RPM)
        return min(max(rpm, 1), SPEED_MAX_RPM) * COUNTS_S_PER_RPM

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long so many steps take from rest to rest."""
        return trapezoid_s(steps, self.usable_rate_hz(rate_hz), self._slope)

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Return a ramp and what passes before it; without a host, what was sent ahead as well.

        A drive that lags is told to go faster than planned, so that it brakes for longer; it makes
        up for no more than it may lag.
        """
        begun_s = HOST_S + 2.0 * STOP_POLL_S
        seen_s = 3.0 * STOP_POLL_S + 2.0 * self.settings.answer_s
        silent_s = max(burst_s, 1.5 * self.settings.segment_s)
        if self.watched:
            silent_s = min(silent_s, self.settings.watchdog_s)
        rate_hz = max((part.rate_hz for part in parts), default=self._fastest_hz)
        fastest_hz = catch_up_rpm(rate_hz / COUNTS_S_PER_RPM) * COUNTS_S_PER_RPM
        brakes_s = fastest_hz / self._slope
        asked = self._way_of_laggards(begun_s + brakes_s / 2.0, rate_hz)
        silent = self._way_of_laggards(silent_s + brakes_s / 2.0, rate_hz)
        return Stopping(
            begun_s + brakes_s,
            asked[0],
            silent_s + brakes_s + HOST_S,
            silent[0],
            begun_s + brakes_s + seen_s,
            asked[1],
            silent[1],
        )

    def _way_of_laggards(self, time_s: float, rate_hz: float) -> tuple[float, float]:
        """Return how much of their motion drives make in a time, and how many counts besides.

        Those that lag go faster, each for itself, and make up for what they may lag: whichever is
        less.
        """
        besides_hz = (CATCH_UP - 1.0) * rate_hz + CATCH_UP_RPM * COUNTS_S_PER_RPM
        faster = time_s, besides_hz * time_s
        made_up = time_s + LATE_S, float(self.settings.corridor_counts)
        return min(faster, made_up, key=lambda way: way[0] * rate_hz + way[1])

    def strays_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:
        """Bound how far a drive is beside the straight way: of a burst, by rpm, ramps, starts."""
        if self.abilities.queued_segments:
            return (0.0,) * len(steps)
        return self._bursts.strays_of(steps, rate_hz)

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Take a drive that was found within reach of where it was left for being there still."""
        return unwrapped(self._wire.drives, registers, near, self._wire.now_s)


_TOP_HZ = SPEED_MAX_RPM * COUNTS_S_PER_RPM
DRIVER = Driver(MksSettings, MksController, Unpacker)
