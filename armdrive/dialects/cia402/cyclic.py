"""Motion of CiA 402 drives by cyclic synchronous position: a target for each with every SYNC."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator

from armdrive.dialects.bus.segments import BusSegment
from armdrive.dialects.cia402.arrival import Cia402Ending
from armdrive.dialects.cia402.cycle import ENABLE, Script
from armdrive.dialects.cia402.drive import Cia402Drive
from armdrive.dialects.cia402.master import TARGET_MAX
from armdrive.dialects.cia402.power import Hindrance
from armdrive.tasks import Done, Halted, MoveAlong, MoveBy, RequestRejected
from firmware_protocol.canopen import OperationMode
from kinematics.spaces import Motors

# The way of a cyclic motion: straight segments that join, smoothed by a moving average.
#
# Each target is the mean of where the motors would have been over the last while, all of them over
# the same: so what is straight stays straight, and where speeds jump there are ramps. Increments,
# seconds since the motion began.

LEAST_RATE = 0.1
"""Slower than this share of its speed no way is driven to its end."""


class SmoothTrack:
    """The segments that were drawn and not passed."""

    def __init__(self, start: Motors, window_s: float) -> None:
        self.end = start
        self.end_s = 0.0
        self.window_s = window_s
        """Over how long a target is averaged: it trails by half of that."""
        self._pieces: deque[BusSegment] = deque()

    def draw(self, segment: MoveBy, time_s: float) -> None:
        """Take in the next segment; where all was driven, it begins at this time."""
        start_s = max(self.end_s, time_s)
        end, end_s = self.end + segment.steps, start_s + max(segment.duration_s, 1e-6)
        self._pieces.append(BusSegment(start_s, end_s, self.end, end))
        self.end, self.end_s = end, end_s

    def places(self, time_s: float) -> tuple[int, ...]:
        """Return the target of each motor at a time, and forget what lies behind it."""
        while self._pieces and self._pieces[0].end_s <= time_s - self.window_s:
            self._pieces.popleft()
        if not self._pieces:
            return tuple(self.end)
        return tuple(round(self._mean(motor, time_s)) for motor in range(len(self.end)))

    def _mean(self, motor: int, time_s: float) -> float:
        if not self.window_s:
            return self._at(motor, time_s)
        total, at_s = 0.0, time_s - self.window_s
        for piece in self._pieces:
            if piece.start_s >= time_s:
                break
            if piece.start_s > at_s:  # it stood before
                total += (piece.start_s - at_s) * piece.start[motor]
                at_s = piece.start_s
            until_s = min(piece.end_s, time_s)
            total += (until_s - at_s) * (piece.at(motor, at_s) + piece.at(motor, until_s)) / 2.0
            at_s = until_s
        if at_s < time_s:
            total += (time_s - at_s) * self._at(motor, time_s)
        return total / self.window_s

    def _at(self, motor: int, time_s: float) -> float:
        for piece in self._pieces:
            if time_s < piece.end_s:
                return piece.at(motor, time_s)
        return float(self.end[motor])


class CyclicTrip:
    """One motion under way: where its segments come from, and how far it is.

    It goes on by one period a turn at most, however late the turn is. Who lets go of it has it
    slow down on its way, in what `ease_s` says; who holds it back, towards the end of what was
    drawn, which is as little as can be. Where it is slowed down already by then, or has to wait
    before that end, it slows down to a stand on its way, and stays until it is held back no more:
    the end would come later than was announced.
    """

    def __init__(self, request: MoveAlong, track: SmoothTrack, ease_s: Callable[[], float]) -> None:
        self.track = track
        self.time_s = 0.0
        self.underruns = 0
        """How often there was nothing left to be driven although more was to come."""
        self.eased = False
        """Whether somebody has let go of it."""
        self._request = request
        self._segments: Iterator[MoveBy] = request.segments
        self._ease_s = ease_s
        self._rate, self._full_s = 1.0, 0.0
        self._exhausted = self._held = self._stays = False

    @property
    def over(self) -> bool:
        """Whether nothing is left to be sent."""
        if self.eased and self._rate <= 0.0:
            return True
        ended = self._exhausted or self._held or self.eased
        return ended and self.time_s >= self.track.end_s + self.track.window_s

    @property
    def complete(self) -> bool:
        """Whether all of it has been sent, as far as it was not held back."""
        driven = self.time_s >= self.track.end_s + self.track.window_s
        return driven and (self._exhausted or (self._held and not self.eased))

    def go_on(self, period_s: float, *, wait: bool = False) -> tuple[int, ...]:
        """Let a period of it pass; return where the motors shall be then.

        Who has to `wait` for a drive is slowed down on the way, and goes on from there.
        """
        if self._rate >= 1.0:
            self._full_s = max(self._ease_s(), period_s)
        self.eased = self.eased or self._request.let_go()
        held, self._held = self._held, self._request.held_back()
        slowed = not held and self._rate < 1.0
        self._stays = self._held and (self._stays or wait or slowed)
        if not self.eased:
            self._draw(period_s)
        self._rate = self._next_rate(period_s, wait)
        self.time_s += self._rate * period_s
        return self.track.places(self.time_s)

    def _next_rate(self, period_s: float, wait: bool) -> float:
        """Return how fast time passes on the way: slower before its end where it is held back."""
        change, left_s = period_s / self._full_s, self.track.end_s - self.time_s
        if self.eased or wait or self._stays:
            return max(self._rate - change, 0.0)
        if self._held and left_s > period_s:
            return max(min(self._rate, math.sqrt(2.0 * left_s / self._full_s)), LEAST_RATE)
        return min(self._rate + change, 1.0)

    def _draw(self, period_s: float) -> None:
        dry = self.time_s > self.track.end_s > 0.0
        while not (self._exhausted or self._held) and self._has_room(period_s):
            segment = next(self._segments, None)
            if segment is None:
                self._exhausted = True
                return
            self.track.draw(segment, self.time_s)
            self.underruns, dry = self.underruns + dry, False

    def _has_room(self, period_s: float) -> bool:
        return self.track.end_s - self.time_s <= period_s


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
        trip = CyclicTrip(request, track, self._ease_s)
        try:
            return (yield from self._drive(trip))
        finally:
            self.underruns += trip.underruns

    def _drive(self, trip: CyclicTrip) -> Script:
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

    def _give_targets(self, trip: CyclicTrip) -> Hindrance:
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

    def _is_astray(self, drive: Cia402Drive) -> bool:
        """Tell whether a drive is farther from its target than it would fault for."""
        way = BEHIND_TURNS * self._hz * self.cycle_s
        return abs(drive.seen - drive.place) > 2 * self.settings.following_window + way

    def _ease_s(self) -> float:
        """Return how long it takes to slow down from the present speed."""
        return self.settings.ramp_s * min(self._hz / self.fastest_hz, 1.0)

    def _beyond(self, targets: tuple[int, ...]) -> RequestRejected | None:
        """Refuse a target that a drive cannot be given."""
        for drive, target in zip(self.drives, targets, strict=True):
            if abs(target) > TARGET_MAX:
                alert = f"{drive} would turn to {target} increments, beyond what can be commanded"
                return RequestRejected(f"{alert}: home it near its zero")
        return None
