"""Carry out an arm's requests to CiA 402 drives: which collaborator carries out each.

An obstacle is raised as `Obstructed`, with the reply.
"""

from __future__ import annotations

from armdrive.config.arm import ArmConfig
from armdrive.dialects.cia402.compare import compare, fix
from armdrive.dialects.cia402.contact import Cia402Contact
from armdrive.dialects.cia402.drives import FAULTS
from armdrive.dialects.cia402.exchange import Cia402Exchange, Script
from armdrive.dialects.cia402.homing import Cia402Homing
from armdrive.dialects.cia402.measuring import UnitMeasurement
from armdrive.dialects.cia402.motion import CyclicMotion, ProfileMotion
from armdrive.dialects.exchange import Obstructed
from armdrive.errors.printable import command_line
from armdrive.tasks import (
    Alert,
    AlertKind,
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


class Cia402Requests:
    """Carries out the requests of one arm."""

    def __init__(self, io: Cia402Exchange, config: ArmConfig) -> None:
        self._io, self._group = io, io.group
        self._arm, self._homes = config.name, config.homing is not None
        self.contact = Cia402Contact(io)
        self.cyclic = CyclicMotion(io)
        self._profile = ProfileMotion(io)
        self.homing = Cia402Homing(io)
        self._measurement = UnitMeasurement(io)

    def carry_out(self, request: Request) -> Script[Reply]:
        """Carry out a request; the first one makes contact with the drives before it.

        New faults are reported at the end.
        """
        for _ in range(2):
            try:
                reply = yield from self._attempt(request)
                break
            except Obstructed as obstructed:
                reply = obstructed.reply
            if not self._group.dropped_out:
                break  # else they missed a heartbeat at rest, and then the question: ask again
        for drive in self._io.drives:
            if drive.state in FAULTS and not drive.reported:
                yield from self._io.transfers.explain(drive)
            self._group.report(drive)
        return reply

    def _attempt(self, request: Request) -> Script[Reply]:
        """Make contact if necessary, and carry out a request. Raises `Obstructed`."""
        self._require_unbroken(request)
        contact, io = self.contact, self._io
        if not self._group.contacted:
            yield from contact.connect()
            if self._homes:
                yield from self.homing.read_speeds(io.drives)
        match request:
            case MoveBy() | MoveAlong() | HomeDevice():
                return (yield from self._move(request))
            case MeasureUnits(motor, steps):
                return (yield from self._measurement.measure(io.drives[motor], steps))
            case ReadPosition():
                return (yield from contact.read())
            case ReadSettings():
                return (yield from compare(io))
            case FixSetting(line):
                return (yield from fix(io, line))
            case SwitchOn():
                return (yield from contact.switch_on())
            case DropCurrent():
                return (yield from contact.switch_off())
            case _:
                return (yield from contact.clear())

    def _move(self, request: MoveBy | MoveAlong | HomeDevice) -> Script[Reply]:
        self._require_units()
        match request:
            case MoveBy(steps, rate_hz, released):
                return self._profile.burst(steps, rate_hz, released)
            case MoveAlong():
                return self.cyclic.drive(request)
            case HomeDevice(groups):
                return self.homing.home(groups)

    def _require_unbroken(self, request: Request) -> None:
        """Raise `Obstructed` if a motion goes on with this request although a drive left it.

        Drives that missed a heartbeat may have stopped between two bursts of a motion, or between
        two groups that home. So only a request that moves nothing takes them back: at rest, the
        next reading of the positions, but none midway through a motion.
        """
        moves = isinstance(request, MoveBy | MoveAlong | HomeDevice)
        goes_on = moves or (isinstance(request, ReadPosition) and request.midway)
        if goes_on and self._group.on and self._group.dropped_out:
            drive = self._group.dropped_out[0]
            words = f"{drive} has stopped by itself, and holds{drive.why}"
            self._group.alarm(drive, Alert(AlertKind.ALARM, words))
            raise Obstructed(words)

    def _require_units(self) -> None:
        """Raise `Obstructed` for a drive whose unit of speed is unknown: it might turn too fast."""
        for drive in self._io.drives:
            if not drive.speed_unit_hz:
                measure = command_line("can", "setup", self._arm)
                raise Obstructed(
                    f"{drive} does not report its unit of speed (object 60A9): `{measure}` "
                    "measures it, or write cia402.speed_units as its manual says"
                )
