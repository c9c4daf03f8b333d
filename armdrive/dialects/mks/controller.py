"""The controller of MKS SERVO42D/57D drives on a CAN bus: requests to frames, replies to events.

Positions come from the drives' encoders. Sources: makerbase-motor/MKS-SERVO42D-57D, the CAN
manuals 1.0.6 and 1.0.9.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from armdrive.abilities import SEGMENTS_AHEAD, Abilities
from armdrive.config.arm import ArmConfig
from armdrive.dialects import Driver
from armdrive.dialects.bus.drives import BUS_REQUESTS, bus_motors
from armdrive.dialects.controller import (
    HOST_DELAY_S,
    ScriptRunner,
    Search,
    StopPart,
    Stopping,
)
from armdrive.dialects.mks.compare import compare, fix
from armdrive.dialects.mks.contact import (
    connect,
    disable,
    enable,
    read,
    reset,
)
from armdrive.dialects.mks.exchange import MksExchange, Script
from armdrive.dialects.mks.homing import HOMING_SLOPE, home, read_speeds
from armdrive.dialects.mks.motion import (
    along,
    burst,
    catch_up_rpm,
    catch_up_travel,
    deviations_of,
)
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.stops import STOP_POLL_S
from armdrive.errors import Refused
from armdrive.tasks import (
    DropCurrent,
    FixSetting,
    HomeDevice,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadSettings,
    Request,
    SwitchOn,
)
from firmware_protocol.frames import Unpacker
from firmware_protocol.mks import COUNTS_S_PER_RPM, SPEED_MAX_RPM, Ability, Event, slope_of
from kinematics.paths.profiles import trapezoid
from kinematics.spaces import Motors


class MksController(ScriptRunner[Event]):
    """Drives the drives of one arm: starts the script of each request."""

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: MksSettings = config.device
        motors = bus_motors(config, "mks", settings.ids)
        settings = replace(settings, ids=settings.ids[: motors.count])
        self.settings = settings
        self._slope = slope_of(settings.acceleration)
        self._fastest_hz = min(motors.fastest_hz, _TOP_HZ)
        ramp_s = self._fastest_hz / self._slope
        self._exchange = io = MksExchange(settings, motors.names, ramp_s, motors.ranges)
        super().__init__(replace(abilities, motors=motors.count), io.host, io)
        self._choose()

    def _choose(self) -> None:
        """Steer if the firmware and the arm file allow it, else send bursts."""
        steered = bool(self.settings.segment_s) and self._exchange.can(Ability.RETARGET)
        self.abilities = replace(
            self.abilities, coordinated=steered, queued_segments=SEGMENTS_AHEAD if steered else 0
        )

    @property
    def watched(self) -> bool:
        """Whether every drive is known to stop on a silent bus."""
        return self._exchange.watched

    @property
    def underruns(self) -> int:
        """How often drives stood still although more of their motion was to come."""
        return self._exchange.underruns

    # -- requests -----------------------------------------------------------------------------

    def script(self, request: Request) -> Script:
        """Carry out a request; the first one makes contact with the drives before it.

        Earlier questions are given up.
        """
        if not isinstance(request, BUS_REQUESTS):
            raise Refused(f"MKS drives do not support {type(request).__name__}")
        self.give_up()
        io = self._exchange
        if not io.connected:
            yield from connect(io)
            self._choose()
            yield from read_speeds(io, io.drives)
        match request:
            case MoveBy(steps, rate_hz, released) if not self.abilities.queued_segments:
                script = burst(io, steps, rate_hz, released)
            case MoveBy(released=released):
                ahead_s = request.duration_s + 1.0
                script = along(io, MoveAlong(iter((request,)), ahead_s, released=released))
            case MoveAlong():
                script = along(io, request)
            case HomeDevice(groups):
                script = home(io, groups)
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

    def give_up(self) -> None:
        """Give up all open questions."""
        self._exchange.give_up()

    # -- numbers ------------------------------------------------------------------------------

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the usable rate: any in steered motion, one in whole rpm in bursts."""
        if self.abilities.queued_segments:
            return max(min(rate_hz, _TOP_HZ), COUNTS_S_PER_RPM / 100.0)
        rpm = SPEED_MAX_RPM if math.isinf(rate_hz) else math.floor(rate_hz / COUNTS_S_PER_RPM)
        return min(max(rpm, 1), SPEED_MAX_RPM) * COUNTS_S_PER_RPM

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long a number of steps takes from rest to rest."""
        return trapezoid(steps, self.usable_rate_hz(rate_hz), self._slope).duration_s

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound a stop by the ramp and the delay before it; without a host, by the targets as well.

        A drive that lags turns faster than planned and so brakes for longer, but it makes up for no
        more than it may lag.
        """
        begun_s = HOST_DELAY_S + 2.0 * STOP_POLL_S  # one stop may be lost, and is repeated
        silent_s = max(burst_s, 1.5 * self.settings.segment_s)
        if self.watched:
            silent_s = min(silent_s, self.settings.watchdog_s)
        rate_hz = max((part.rate_hz for part in parts), default=self._fastest_hz)
        fastest_hz = catch_up_rpm(rate_hz / COUNTS_S_PER_RPM) * COUNTS_S_PER_RPM
        brakes_s = fastest_hz / self._slope
        corridor = self.settings.following_error_counts
        asked = catch_up_travel(begun_s + brakes_s / 2.0, rate_hz, corridor)
        silent = catch_up_travel(silent_s + brakes_s / 2.0, rate_hz, corridor)
        return Stopping(
            begun_s + brakes_s,
            asked[0],
            silent_s + brakes_s + HOST_DELAY_S,
            silent[0],
            asked[1],
            silent[1],
        )

    def search(self, request: HomeDevice) -> Search:
        """Bound the drives' own homing: by their watchdogs if all have them, else by their ways.

        A drive that does not report its speed may go on for all the time that the arm file allows.
        """
        found = self._exchange.homing.estimate(request.groups)
        rate_hz, is_known = found.rate_hz, math.isfinite(found.rate_hz)
        brakes_s = rate_hz / HOMING_SLOPE if is_known else 0.0
        if not (is_known and self.watched):
            return Search(found.longest.s + brakes_s, lasts=found.lasts)
        silent_s = self.settings.watchdog_s + HOST_DELAY_S
        return Search(silent_s + brakes_s, (silent_s + brakes_s / 2.0) * rate_hz, found.lasts)

    def deviation_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:
        """Bound each drive's deviation from the straight path; steered drives stay on it."""
        if self.abilities.queued_segments:
            return (0.0,) * len(steps)
        return deviations_of(self.settings.acceleration, steps, rate_hz)

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Return the registers; a drive near where it was left is taken to be there.

        A position loop holds within some counts. Nothing wraps: an arm does not turn that far.
        """
        return Motors(
            drive.found_near(there) if count == drive.target else count
            for drive, count, there in zip(self._exchange.drives, registers, near, strict=True)
        )


_TOP_HZ = SPEED_MAX_RPM * COUNTS_S_PER_RPM
DRIVER = Driver(MksSettings, MksController, Unpacker, lambda settings: settings.ids)
