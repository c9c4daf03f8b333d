"""Motion of CiA 402 drives by profile position: one set-point each, all begun by one SYNC.

Every drive gets a speed and a ramp in proportion to its way, so that all keep in step and arrive
together.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from armdrive.dialects.bus.segments import trapezoid_s
from armdrive.dialects.cia402.cycle import ENABLE, Script, Turning
from armdrive.dialects.cia402.cyclic import Cia402Cyclic
from armdrive.dialects.cia402.drive import Cia402Drive
from armdrive.dialects.cia402.master import TARGET_MAX
from armdrive.dialects.cia402.power import Hindrance
from armdrive.dialects.cia402.sdo_queue import refusal_words
from armdrive.tasks import Alert, AlertKind, Done, Halted, RequestRejected
from firmware_protocol.canopen import (
    PROFILE_ACCELERATION,
    PROFILE_DECELERATION,
    PROFILE_SPEED,
    DataType,
    OperationMode,
    Phase,
    Reached,
    SetPointHost,
    Write,
)
from kinematics.spaces import Motors

MODE = OperationMode.PROFILE_POSITION
TOP_HZ = 10_000_000.0
"""No drive is asked for more increments a second."""
START_TURNS = 20
"""So many turns drives may take to be ready for a set-point."""
PATIENCE_S = 0.6
BESIDE = 2.0
"""How far a drive is beside its share of a way, by speeds and ramps in whole numbers."""


class Cia402Profile(Cia402Cyclic):
    """Drives one burst at a time."""

    ramp_hz_s = 1.0
    """The ramp of the busiest motor, in increments a second squared."""

    def burst(self, steps: Motors, rate_hz: float, let_go: Callable[[], bool]) -> Script:
        """Send a burst and wait for its end."""
        hindrance = yield from self.prepare(MODE)
        if hindrance is not None:
            return hindrance
        goals = {
            drive.node: drive.place + count
            for drive, count in zip(self.drives, steps, strict=True)
            if count
        }
        if not goals:
            return Done()
        for node, goal in goals.items():
            if abs(goal) > TARGET_MAX:
                words = f"{self._by_node[node]} would turn to {goal} increments"
                return RequestRejected(f"{words}, beyond what can be commanded", moved=False)
        hindrance = yield from self._write_ramps(steps, min(rate_hz, TOP_HZ))
        if hindrance is not None:
            return hindrance
        if self.stop_asked or let_go():
            return Halted()
        return (yield from self._follow(goals, self.lasts_s(steps.largest, rate_hz)))

    def _write_ramps(self, steps: Motors, rate_hz: float) -> Hindrance:
        """Give each drive its share of the speed and of the ramp."""
        began_s = self.now_s
        jobs = {
            drive.node: _ramp(abs(count) / steps.largest, rate_hz, self.ramp_hz_s)
            for drive, count in zip(self.drives, steps, strict=True)
            if count
        }
        lanes = yield from self.transfer(jobs)
        if mute := [lane.drive for lane in lanes.values() if lane.mute]:
            if len(mute) == len(lanes):
                return self.silence(began_s)
            return RequestRejected(self.absent_words(mute), moved=False)
        for lane in lanes.values():
            for place in lane.refused:
                return RequestRejected(refusal_words(lane, place), moved=False)
        return None

    def _follow(self, goals: Mapping[int, int], lasts_s: float) -> Script:
        """Hand the set-points over, and follow them to their ends."""
        hosts = {node: SetPointHost() for node in goals}
        for node, host in hosts.items():
            host.begin()
            self._hear(self._by_node[node], host)
        for _ in range(START_TURNS):
            if all(host.phase is Phase.ASKING for host in hosts.values()):
                break
            yield from self.turn()
            for node, host in hosts.items():
                self._hear(self._by_node[node], host)
        else:
            return RequestRejected("drives have no room for a set-point: reset them", moved=False)
        if self.stop_asked:
            return Halted()
        for node, goal in goals.items():
            self._by_node[node].place, self._by_node[node].fresh = goal, False
        given_up_s = self.now_s + 2.0 * lasts_s + PATIENCE_S
        under_way = set(goals)
        while under_way:
            if self.stop_asked:
                return (yield from self.halted())
            self._say(hosts)
            given_up_s += yield from self.timed(self.turn_of_motion())
            if (ended := None if self.stop_asked else (yield from self.weighed(MODE))) is not None:
                return ended
            under_way -= {node for node in under_way if self._has_arrived(node, hosts[node])}
            self.progress()
            if self.now_s > given_up_s and under_way:
                drive = self._by_node[min(under_way)]
                return (yield from self.broken_off(self._overdue(drive)))
        return (yield from self._settled())

    def _settled(self) -> Script:
        """Wait until no drive turns any more."""
        until_s = self.now_s + PATIENCE_S
        reach = self.settings.rest_window
        while left := [drive for drive in self.drives if not drive.near(reach)]:
            if self.now_s > until_s:
                return (yield from self.broken_off(self.beside(left[0])))
            if self.stop_asked:
                return (yield from self.halted())
            until_s += yield from self.timed(self.turn())
            if (ended := (yield from self.weighed(MODE))) is not None:
                return ended
        return Done()

    def turn_of_motion(self) -> Turning:
        """Have the drives act, and wait for the end of the turn, or for a stop."""
        self.sync()
        yield from self.wait(self.now_s + self.cycle_s, lambda: self.stop_asked)

    def _say(self, hosts: Mapping[int, SetPointHost]) -> None:
        for drive in self.drives:
            host = hosts.get(drive.node)
            word = ENABLE if host is None else host.controlword
            self.command(drive, word, MODE, drive.place)
        self.last_said = f"607A to {' '.join(str(drive.place) for drive in self.drives)}"

    def _hear(self, drive: Cia402Drive, host: SetPointHost) -> bool:
        """Feed what a drive said last; tell whether it says that it has arrived."""
        if drive.word is None or drive.missed > 1:
            return False
        return any(isinstance(event, Reached) for event in host.hear(drive.word))

    def _has_arrived(self, node: int, host: SetPointHost) -> bool:
        return self._hear(self._by_node[node], host)

    def _overdue(self, drive: Cia402Drive) -> Alert:
        alert = self.beside(drive)
        return (
            alert
            if not drive.near(self.settings.rest_window)
            else Alert(AlertKind.ASTRAY, f"{drive} does not say that it has reached its target")
        )

    # -- numbers ------------------------------------------------------------------------------

    def lasts_s(self, steps: float, rate_hz: float) -> float:
        """Return how long a burst takes from rest to rest."""
        return trapezoid_s(steps, min(rate_hz, TOP_HZ), self.ramp_hz_s)


def _ramp(share: float, rate_hz: float, ramp_hz_s: float) -> tuple[Write, ...]:
    speed, slope = max(round(share * rate_hz), 1), max(round(share * ramp_hz_s), 1)
    return (
        Write(PROFILE_SPEED, DataType.U32, speed),
        Write(PROFILE_ACCELERATION, DataType.U32, slope),
        Write(PROFILE_DECELERATION, DataType.U32, slope),
    )
