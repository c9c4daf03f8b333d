"""The driver's end of CiA 402 drives on a CANopen bus: neutral requests to frames and back.

Position is what the drives' encoders tell. Sources: CiA 301 (CANopen) and CiA 402-2
(IEC 61800-7-201, the drive profile).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from armdrive.abilities import Abilities, segment_s
from armdrive.config.arm import ArmConfig
from armdrive.dialects.bus.motors import bus_motors
from armdrive.dialects.cia402 import contact as setup
from armdrive.dialects.cia402.compare import Cia402Comparing
from armdrive.dialects.cia402.cycle import Script
from armdrive.dialects.cia402.profile import BESIDE, TOP_HZ
from armdrive.dialects.cia402.settings import CYCLIC, Cia402Settings
from armdrive.dialects.controller import StopPart, Stopping
from armdrive.dialects.dialect import Driver
from armdrive.errors import Refused
from armdrive.tasks import (
    Alert,
    AlertKind,
    ClearFault,
    DropCurrent,
    HomeDevice,
    MendSetting,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadSettings,
    Request,
    SwitchOn,
)
from firmware_protocol.canopen import OperationMode
from firmware_protocol.frames import Unpacker
from kinematics.spaces import Motors

HOST_S = 0.03
"""What an operating system, an adapter and a bus with other traffic may add to a frame's way."""
LEAST_HZ = 1.0
AHEAD = 3
"""So many segments are known ahead: the drives hold the last target alone."""
SEEN_TURNS = 8
"""So many turns pass at most until it is seen that a drive stands, and it is taken back."""


class Cia402Controller(Cia402Comparing):
    """The drives of one arm, seen from the driver."""

    _began_s = -math.inf
    """When the present request was taken up."""

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: Cia402Settings = config.device
        motors = bus_motors(config, "cia402", settings.ids)
        methods = settings.homing_methods[: motors.count]
        settings = replace(settings, ids=settings.ids[: motors.count], homing_methods=methods)
        cycle_ms = setup.period_ms(settings, motors.count, config.connection.baud)
        order_s = (settings.heartbeat_ms - settings.beat_ms) / 1000.0
        abilities = replace(abilities, motors=motors.count, order_s=order_s)
        super().__init__(abilities, settings, motors.names, cycle_ms / 1000.0)
        self.fastest_hz, self.ranges = motors.fastest_hz, motors.ranges
        self.ramp_hz_s = self.fastest_hz / self.settings.ramp_s
        self.quick_slope = self.fastest_hz / self.settings.quick_stop_s
        self.choose(frozenset((OperationMode.CYCLIC_POSITION,)))

    def choose(self, modes: frozenset[OperationMode]) -> None:
        """Give targets cyclically where every drive and the arm file let us, else send bursts."""
        wanted = OperationMode.CYCLIC_POSITION
        cyclic = self.settings.strategy == CYCLIC and wanted in modes
        self.resting_mode = wanted if cyclic else OperationMode.PROFILE_POSITION
        self.abilities = replace(self.abilities, queued_segments=AHEAD if cyclic else 0)

    def script(self, request: Request) -> Script:
        """Carry out a request; the first one makes contact with the drives before it."""
        if not isinstance(request, _KNOWN):
            raise Refused(f"CiA 402 drives know no {type(request).__name__}")
        return self._reported(request)

    def _reported(self, request: Request) -> Script:
        """Carry it out, and tell what was found to be wrong meanwhile."""
        reply = yield from self._script_of(request)
        for drive in self.drives:
            self.report(drive)
        return reply

    def _script_of(self, request: Request) -> Script:
        if not self.contacted and (hindrance := (yield from self.contact())) is not None:
            return hindrance
        match request:
            case MoveBy(steps, rate_hz, let_go):
                return (yield from self.burst(steps, rate_hz, let_go))
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
        """Read every position; a drive that holds, and is not where it should be, is told of."""
        began_s = self.now_s
        if missing := (yield from self.look()):
            return self.absence(missing, began_s)
        for drive in self.drives:
            if self.on and not drive.near(self.settings.rest_window):
                self.tell(Alert(AlertKind.ASTRAY, self.beside(drive).text))
                drive.rest()
        return self.registers()

    # -- what the engine calls ----------------------------------------------------------------

    def begin(self, request: Request, now_s: float) -> None:
        """Take up a request; nothing that was asked before is waited for any more."""
        if not self.busy:
            self.give_up()
        self._began_s = now_s
        super().begin(request, now_s)

    def stop(self, *, hard: bool) -> None:
        """Have the script know of a stop; a target that was not said yet never is.

        To a drive that has stopped by itself meanwhile it is an order to go on.
        """
        if self.busy and not self.stop_asked and self.now_s > self._began_s:
            self._out.clear()
        super().stop(hard=hard)

    # -- numbers ------------------------------------------------------------------------------

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return any rate that can be written; the drives are as fast as their motors."""
        return max(min(rate_hz, TOP_HZ), LEAST_HZ)

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long so many steps take from rest to rest."""
        return self.lasts_s(steps, self.usable_rate_hz(rate_hz))

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Return a quick stop and what passes before it; without a host, the missing heartbeat."""
        rate_hz = max((part.rate_hz for part in parts), default=self.fastest_hz)
        share = min(rate_hz / self.fastest_hz, 1.0)
        ramp_s, begun_s = self.settings.quick_stop_s * share, HOST_S + 2.0 * self.cycle_s
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
            begun_s + ramp_s + SEEN_TURNS * self.cycle_s,
        )

    def strays_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:  # noqa: ARG002
        """Bound how far a drive is beside the straight way: of a burst, by whole numbers."""
        if self.abilities.queued_segments:
            return (0.0,) * len(steps)
        return tuple(BESIDE if count else 0.0 for count in steps)

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Take a drive that was found to tremble about where it was left for being there still.

        A closed loop holds within some increments. Positions of 32 bits do not wrap on an arm.
        """
        return Motors(
            drive.found_near(there) if count == drive.place else count
            for drive, count, there in zip(self.drives, registers, near, strict=True)
        )


_KNOWN = (
    MoveBy, MoveAlong, ReadPosition, ReadSettings, MendSetting, SwitchOn, DropCurrent, HomeDevice,
    ClearFault,
)  # fmt: skip


DRIVER = Driver(Cia402Settings, Cia402Controller, Unpacker)
