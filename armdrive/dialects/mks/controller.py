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
from armdrive.dialects.bus.motors import bus_motors
from armdrive.dialects.bus.segments import trapezoid_s
from armdrive.dialects.controller import StopPart, Stopping
from armdrive.dialects.dialect import Driver
from armdrive.dialects.mks.bursts import MksBursts
from armdrive.dialects.mks.compare import MksComparing
from armdrive.dialects.mks.drive import COUNTS_S_PER_RPM, WAY_S, slope_of
from armdrive.dialects.mks.exchange import Script
from armdrive.dialects.mks.homing import MksHoming
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.steering import CATCH_UP, CATCH_UP_RPM
from armdrive.dialects.mks.stops import STOP_POLL_S
from armdrive.errors import Refused
from armdrive.tasks import (
    ClearFault,
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
from firmware_protocol.mks import SPEED_MAX_RPM, Ability
from kinematics.spaces import Motors

HOST_S = 0.03
"""What an operating system, an adapter and a bus with other traffic may add to a frame's way."""
STEERED = 3
"""So many segments are known ahead: the drives hold the last order alone."""


class MksController(MksBursts, MksHoming, MksComparing):
    """The drives of one arm, seen from the driver."""

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: MksSettings = config.device
        motors = bus_motors(config, "mks", settings.ids)
        settings = replace(settings, ids=settings.ids[: motors.count])
        super().__init__(replace(abilities, motors=motors.count), settings, motors.names)
        self.ranges = motors.ranges
        self._slope = slope_of(settings.acceleration)
        self._fastest_hz = min(motors.fastest_hz, _TOP_HZ)
        self.ramp_s = self._fastest_hz / self._slope
        if settings.version is None and not settings.segment_s:
            self.choose()

    def choose(self) -> None:
        """Steer where the firmware and the arm file let us, else send bursts."""
        steered = bool(self.settings.segment_s) and (not self.able or Ability.RETARGET in self.able)
        self.abilities = replace(
            self.abilities, coordinated=steered, queued_segments=STEERED if steered else 0
        )

    def script(self, request: Request) -> Script:
        """Carry out a request; the first one makes contact with the drives before it."""
        if not isinstance(request, _KNOWN):
            raise Refused(f"MKS drives know no {type(request).__name__}")
        return self._script_of(request)

    def _script_of(self, request: Request) -> Script:
        if not self.contacted and (hindrance := (yield from self.contact())) is not None:
            return hindrance
        match request:
            case MoveBy(steps, rate_hz, let_go) if not self.abilities.queued_segments:
                return (yield from self.burst(steps, rate_hz, let_go))
            case MoveBy(let_go=let_go):
                along = MoveAlong(iter((request,)), request.duration_s + 1.0, let_go=let_go)
                return (yield from self.drive_along(along))
            case MoveAlong():
                return (yield from self.drive_along(request))
            case ReadPosition():
                return (yield from self._read())
            case ReadSettings():
                return (yield from self.compare())
            case MendSetting(line):
                return (yield from self.mend(line))
            case SwitchOn():
                return (yield from self.switch_on())
            case DropCurrent():
                return (yield from self.switch_off())
            case HomeDevice(groups):
                return (yield from self.home(groups))
            case _:
                return (yield from self.clear())

    def _read(self) -> Script:
        """Read every encoder; a drive that holds, and is not where it should be, is looked into."""
        began_s = self.now_s
        if missing := (yield from self.look()):
            absence = self.absence(missing, began_s)
            return replace(absence, moved=True) if isinstance(absence, RequestRejected) else absence
        for drive in self.drives:
            off = abs((drive.seen or 0) - drive.target)
            if not self.on or drive.moving or off <= self.reach:
                continue
            self.tell((yield from self.found_at(drive.node)))
            drive.rest_at(drive.seen or 0, self.now_s)
        return self.registers()

    # -- what the engine calls ----------------------------------------------------------------

    def begin(self, request: Request, now_s: float) -> None:
        """Take up a request; nothing that was asked before is waited for any more."""
        if not self.busy:
            self.give_up()
        super().begin(request, now_s)

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
        silent_s = burst_s + self.settings.segment_s
        if self.watched:
            silent_s = min(silent_s, self.settings.watchdog_s)
        rate_hz = max((part.rate_hz for part in parts), default=self._fastest_hz)
        brakes_s = self.catching_up_hz(rate_hz) / self._slope
        asked = self._way_of_laggards(begun_s + brakes_s / 2.0, rate_hz)
        silent = self._way_of_laggards(silent_s + brakes_s / 2.0 + HOST_S, rate_hz)
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

        Those that lag go faster, and make up for what they may lag: whichever is less.
        """
        faster = CATCH_UP * time_s, CATCH_UP_RPM * COUNTS_S_PER_RPM * time_s
        made_up = time_s + WAY_S, float(self.settings.corridor_counts)
        return min(faster, made_up, key=lambda way: way[0] * rate_hz + way[1])

    def strays_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:
        """Bound how far a drive is beside the straight way: of a burst, by rpm, ramps, starts."""
        if self.abilities.queued_segments:
            return (0.0,) * len(steps)
        return self.strays_of(steps, rate_hz)

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Take a drive that was found within reach of where it was left for being there still.

        An encoder trembles by a few counts, and a closed loop holds within some. The count that is
        expected of it is its own from then on. Nothing wraps: the encoder counts 48 bits.
        """
        return Motors(
            drive.found_near(there, self.reach) if count == drive.target else count
            for drive, count, there in zip(self.drives, registers, near, strict=True)
        )


_TOP_HZ = SPEED_MAX_RPM * COUNTS_S_PER_RPM
_KNOWN = (
    MoveBy, MoveAlong, ReadPosition, ReadSettings, MendSetting, SwitchOn, DropCurrent, HomeDevice,
    ClearFault,
)  # fmt: skip


DRIVER = Driver(MksSettings, MksController, Unpacker)
