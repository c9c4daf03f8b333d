"""Motion of CiA 402 drives by cyclic synchronous position: a target for each with every SYNC."""

from __future__ import annotations

from armdrive.controllers.cia402_bus import TARGET_MAX
from armdrive.controllers.cia402_cycle import ENABLE, Script
from armdrive.controllers.cia402_drive import Drive
from armdrive.controllers.cia402_ending import Cia402Ending
from armdrive.controllers.cia402_states import Hindrance
from armdrive.controllers.cia402_track import SmoothTrack, Trip
from armdrive.controllers.requests import Denied, Done, Halted, MoveAlong
from firmware_protocol.canopen import OperationMode
from kinematics.spaces import Motors

MODE = OperationMode.CYCLIC_POSITION
HASTE = 0.75
"""Behind a turn that was late the next one comes no sooner than this share of a period."""
HELD_TURNS = 3
"""While a drive has told nothing for so many turns, all are slowed down, to a stand at last."""
PROGRESS_S = 0.05
BEHIND_TURNS = 5
"""How many turns' way a drive may be behind, beyond its window."""


class Cia402Cyclic(Cia402Ending):
    """Drives segments by giving targets."""

    fastest_hz = 1.0
    """How fast the fastest motor of the arm turns at most."""
    _hz = 0.0
    """How fast the busiest turns now."""
    _shown_s = 0.0

    def drive_along(self, request: MoveAlong) -> Script:
        """Give the drives targets along segments, until all is driven or something ends it."""
        hindrance = yield from self.prepare(MODE)
        if hindrance is not None:
            return hindrance
        start = Motors(drive.place for drive in self.drives)
        track = SmoothTrack(start, self.settings.smoothing_ms / 1000.0)
        trip = Trip(request, track, self._ease_s)
        try:
            return (yield from self._drive(trip))
        finally:
            self.underruns += trip.underruns

    def _drive(self, trip: Trip) -> Script:
        self._hz, self._shown_s = 0.0, self.now_s
        due_s = self.now_s
        while not trip.over:
            if self.stop_asked:
                return (yield from self.halted())
            refused = yield from self._give_targets(trip)
            if refused is not None:
                return refused
            self.underruns += self.now_s > due_s + self.cycle_s
            due_s = max(due_s + self.cycle_s, self.now_s + HASTE * self.cycle_s)
            yield from self.wait(due_s, lambda: self.stop_asked)
            ended = None if self.stop_asked else (yield from self._watched())
            if ended is not None:
                return ended
        reply = yield from self.arrive(MODE)
        return Halted() if isinstance(reply, Done) and not trip.complete else reply

    def _give_targets(self, trip: Trip) -> Hindrance:
        """Give every drive its next target; slow down while one of them is not heard."""
        waits = max(drive.missed for drive in self.drives) >= HELD_TURNS
        self.underruns += waits
        targets = trip.go_on(self.cycle_s, wait=waits)
        if (far := self._beyond(targets)) is not None:
            yield from self.halt()
            return far
        ways = zip(targets, self.drives, strict=True)
        self._hz = max(abs(target - drive.place) for target, drive in ways) / self.cycle_s
        for drive, target in zip(self.drives, targets, strict=True):
            drive.place, drive.fresh = target, False
        for drive in self.drives:  # one whose target stays, too: it might run on without
            self.command(drive, ENABLE, MODE, drive.place)
        self.last_said = f"607A to {' '.join(str(drive.place) for drive in self.drives)}"
        self.sync()
        return None

    def _watched(self) -> Hindrance:
        """Look at what the drives have said of the turn."""
        if self.now_s >= self._shown_s + PROGRESS_S:
            self._shown_s = self.now_s
            self.progress()
        ended = yield from self.weighed(MODE)
        if ended is not None:
            return ended
        for drive in self.drives:
            if drive.missed <= 1 and self._is_astray(drive):
                return (yield from self.broken_off(self.beside(drive)))
        return None

    def _is_astray(self, drive: Drive) -> bool:
        """Tell whether a drive is farther from its target than it would fault for."""
        way = BEHIND_TURNS * self._hz * self.cycle_s
        return abs(drive.seen - drive.place) > 2 * self.settings.following_window + way

    def _ease_s(self) -> float:
        """Return how long it takes to slow down from the present speed."""
        return self.settings.ramp_s * min(self._hz / self.fastest_hz, 1.0)

    def _beyond(self, targets: tuple[int, ...]) -> Denied | None:
        """Refuse a target that a drive cannot be given."""
        for drive, target in zip(self.drives, targets, strict=True):
            if abs(target) > TARGET_MAX:
                alert = f"{drive} would turn to {target} increments, beyond what can be commanded"
                return Denied(f"{alert}: home it near its zero")
        return None
