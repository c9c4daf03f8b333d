"""Queued straight lines in motor space: lines, speeds, and the steppers that follow them.

`PathRack.queue` makes a `PlannedLine`, and plans the rest of the path again: `_entries` goes back
from the stop at the end and limits the speed at each corner; `planned` goes forwards and lays a
trapezoid along each line. That gives a list of `PlannerStretch`, of which `positions` reads the
counts at any time. A hold and a resume plan again in the same way.

Units: motor steps; the controller's own units (mm or degrees); seconds.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from armdrive.sim.mechanics.profiles import Part, ProfilePiece, trapezoid
from kinematics.spaces import Motors

# Lines whose directions' cosine differs from 1 or -1 by less than this are parallel or opposite.
_STRAIGHT = 1e-6


@dataclass(frozen=True, slots=True)
class PathLimits:
    """The limits of each axis, and the junction deviation (GRBL's $11), in units."""

    steps_per_unit: tuple[float, ...]
    most_rate: tuple[float, ...]
    acceleration: tuple[float, ...]
    junction_deviation: float = 0.01

    def along(self, unit: Sequence[float], limits: Sequence[float]) -> float:
        """Return the limit along a direction, so that no axis exceeds its own limit."""
        return min(
            (limit / abs(share) for limit, share in zip(limits, unit, strict=True) if share),
            default=math.inf,
        )


@dataclass(frozen=True, slots=True)
class PlannedLine:
    """A line by its steps; `rate` is its cruising speed.

    `step` is the length of one step of the busiest motor. The line is no slower than `least`, and
    begins no faster than `corner`, the speed at which the corner before it may be passed.
    """

    deltas: Motors
    length: float
    unit: tuple[float, ...]
    acceleration: float
    rate: float
    step: float
    least: float
    corner: float

    def made(self, along: float) -> tuple[int, ...]:
        """Return the steps made at a length along the line."""
        if along >= self.length:
            return self.deltas
        share = along / self.length
        return tuple([int(delta * share + (0.5 if delta > 0 else -0.5)) for delta in self.deltas])


def line(
    deltas: Sequence[int],
    limits: PathLimits,
    rate: float,
    slowest_hz: float = 0.0,
    before: PlannedLine | None = None,
) -> PlannedLine | None:
    """Return a line of some steps at a rate in units per second; None if it has no length.

    It is no faster than its axes allow, and its busiest motor turns no slower than `slowest_hz`
    steps per second. `before` is the line that it follows.
    """
    way = [count / per for count, per in zip(deltas, limits.steps_per_unit, strict=True)]
    length = math.hypot(*way)
    if not length:
        return None
    unit = tuple(part / length for part in way)
    slope = limits.along(unit, limits.acceleration)
    rate = min(rate, limits.along(unit, limits.most_rate))
    step = length / max(map(abs, deltas))
    corner = math.inf if before is None else _corner_speed(before.unit, unit, limits)
    return PlannedLine(Motors(deltas), length, unit, slope, rate, step, slowest_hz * step, corner)


def _corner_speed(one: Sequence[float], other: Sequence[float], limits: PathLimits) -> float:
    """Return how fast the corner between lines in two directions may be passed.

    Source: gnea/grbl grbl/planner.c (plan_buffer_line): the speed on a circle that touches both
    lines and comes within the junction deviation of their corner.
    """
    cosine = -sum(a * b for a, b in zip(one, other, strict=True))
    if cosine > 1.0 - _STRAIGHT:
        return 0.0
    if cosine < _STRAIGHT - 1.0:
        return math.inf
    turn = [b - a for a, b in zip(one, other, strict=True)]
    size = math.hypot(*turn)
    slope = limits.along([part / size for part in turn], limits.acceleration)
    half_sine = math.sqrt((1.0 - cosine) / 2)
    return math.sqrt(slope * limits.junction_deviation * half_sine / (1.0 - half_sine))


# --- The speed along the lines: planned backwards from the stop, then forwards -------------------
# A plan is a list of stretches of constant acceleration, exact in time.


@dataclass(frozen=True, slots=True)
class PlannerStretch:
    """A stretch of constant acceleration along one queued line; `last` if the line ends with it."""

    line: PlannedLine
    piece: ProfilePiece
    last: bool


def planned(
    lines: Sequence[PlannedLine],
    along: float,
    speed: float,
    now_s: float,
) -> list[PlannerStretch]:
    """Plan from a length along the first line, at a speed, to the end of the last line."""
    entries = _entries(lines)
    stretches: list[PlannerStretch] = []
    for number, one in enumerate(lines):
        first = along if number == 0 else 0.0
        far = one.length - first
        room = 2 * one.acceleration * far
        leave = min(entries[number + 1], math.sqrt(speed**2 + room))
        leave = max(leave, math.sqrt(max(speed**2 - room, 0.0)))
        slope = one.acceleration
        shape = trapezoid(speed, one.rate, leave, far, slope, slope)
        now_s = _lay(stretches, one, first, _floored(shape, one.least), now_s)
        speed = leave
    return stretches


def braked(
    lines: Sequence[PlannedLine], along: float, speed: float, now_s: float
) -> list[PlannerStretch]:
    """Brake to a standstill along the path, as hard as the lines' accelerations allow."""
    stretches: list[PlannerStretch] = []
    for number, one in enumerate(lines):
        first = along if number == 0 else 0.0
        slope = one.acceleration
        square = speed**2 - 2 * slope * (one.length - first)
        leave = math.sqrt(max(square, 0.0))
        ramp = (speed, -slope, (speed - leave) / slope)
        shape = _floored([ramp], one.least)
        now_s = _lay(stretches, one, first, shape, now_s, last=square >= 0.0)
        if square <= 0.0:
            break
        speed = leave
    return stretches


def _entries(lines: Sequence[PlannedLine]) -> list[float]:
    """Return the greatest speeds at which each line may begin; the speed after the last is 0."""
    corners = [min(b.corner, a.rate, b.rate) for a, b in itertools.pairwise(lines)]
    entries = [math.inf, *corners, 0.0]
    for number in range(len(lines) - 1, 0, -1):
        one = lines[number]
        room = 2 * one.acceleration * one.length
        entries[number] = min(entries[number], math.sqrt(entries[number + 1] ** 2 + room))
    return entries


def _floored(shape: Iterable[Part], least: float) -> Iterator[Part]:
    """Yield the same stretches with the minimum speed applied, which shortens slow ones."""
    for speed, slope, duration_s in shape:
        end = speed + slope * duration_s
        below_s = duration_s if max(speed, end) <= least else 0.0
        if slope and min(speed, end) < least < max(speed, end):
            below_s = (least - min(speed, end)) / abs(slope)
        if not below_s or not least:
            yield speed, slope, duration_s
            continue
        slower = min(speed, end), min(max(speed, end), least)
        crawl = least, 0.0, below_s * sum(slower) / 2.0 / least
        rest = max(speed, least), slope, duration_s - below_s
        yield from (crawl, rest) if slope > 0.0 else (rest, crawl)


def _lay(
    stretches: list[PlannerStretch],
    line: PlannedLine,
    along: float,
    shape: Iterable[Part],
    now_s: float,
    *,
    last: bool = True,
) -> float:
    """Append the parts of a line that last any time; return when it ends."""
    parts = [*shape]
    pieces = []
    for speed, slope, duration_s in [part for part in parts if part[2] > 0.0] or parts[-1:]:
        pieces.append(ProfilePiece(now_s, along, speed, slope, duration_s))
        now_s, along = now_s + duration_s, along + duration_s * (speed + slope * duration_s / 2)
    *before, final = pieces
    stretches += [PlannerStretch(line, piece, last=False) for piece in before]
    stretches.append(PlannerStretch(line, final, last))
    return now_s


# --- The steppers, as GRBL's planner has them follow the lines -----------------------------------
# Positions are known at any time without ticking: the path length is piecewise quadratic in time,
# and each motor stands at the step nearest to the path. Lines may be queued while others run, the
# motion can be held and resumed. Each of these replans, except for the segments that are already
# computed: those are executed unchanged (gnea/grbl grbl/stepper.c, st_prep_buffer).

SEGMENT_S = 0.01  # GRBL's ACCELERATION_TICKS_PER_SECOND of 100 (gnea/grbl grbl/config.h)
# A segment lasts until its busiest motor has made this many steps per 10 ms, or to the line's end.
STEPS_A_SEGMENT = 1.25


@dataclass(frozen=True, slots=True)
class Stepping:
    """How a processor steps: it computes `segments` ahead of the motors, each in `compute_s`.

    The busiest motor of a line makes no fewer than `slowest_hz` steps per second.
    """

    segments: int = 0
    compute_s: float = 0.0
    slowest_hz: float = 0.0


class PathRack:
    """The lines under way. A device that limits their number checks `waiting`."""

    def __init__(
        self, counts: Sequence[int], limits: PathLimits, stepping: Stepping | None = None
    ) -> None:
        self.limits = limits
        self._stepping = stepping or Stepping()
        self._base = Motors(counts)
        """Where the first of the lines begins."""
        self._lines: deque[PlannedLine] = deque()
        self._stretches: list[PlannerStretch] = []
        """The motion from now to the end of the last line; none of a rack that stands, even if
        lines are left after a hold."""
        self._next_line_s = math.inf
        self._began_s = -math.inf
        """When the motors started: since then, segments have been computed."""
        self._along = 0.0
        """How far along the first line the motors stood at the last `settle`."""
        self._held = False

    @property
    def moving(self) -> bool:
        """Whether a motion is under way, or has ended since the last call of `settle`."""
        return bool(self._stretches)

    @property
    def waiting(self) -> int:
        """How many lines are unfinished, including the one under way."""
        return len(self._lines)

    @property
    def goal(self) -> Motors:
        """Where the last line ends."""
        return sum((each.deltas for each in self._lines), self._base)

    @property
    def done_s(self) -> float:
        """When the motion ends by itself; infinity if there is none."""
        return self._stretches[-1].piece.end_s if self._stretches else math.inf

    @property
    def next_line_s(self) -> float:
        """When the line under way ends, or a held motion stands; infinity if there is none."""
        return self._next_line_s

    def ending_by(self, time_s: float) -> int:
        """Return how many of the lines will have ended by a time, as planned now."""
        return sum(1 for each in self._stretches if each.last and each.piece.end_s <= time_s)

    def queue(self, deltas: Sequence[int], rate: float, now_s: float) -> bool:
        """Append a line by its steps, at a rate in units per second; False if it has no length."""
        before = self._lines[-1] if self._lines else None
        added = line(deltas, self.limits, rate, self._stepping.slowest_hz, before)
        if added is None:
            return False
        computed_s = self.computed_s(now_s)
        self._lines.append(added)
        self._replan(now_s, computed_s)
        return True

    def hold(self, now_s: float, *, keep: int | None = None) -> None:
        """Slow down to a standstill along the path; the lines stay queued.

        All segments that are already computed are driven first, or only the next `keep` of them.
        """
        self._held = True
        self._replan(now_s, self.computed_s(now_s, keep))

    def resume(self, now_s: float) -> None:
        """Resume the path."""
        self._held = False
        self._replan(now_s, self.computed_s(now_s))

    def computed_s(self, now_s: float, segments: int | None = None) -> float:
        """Return up to when the motion is computed; `now_s` if there is none.

        With a number of `segments`, return when the last of as many computed ones ends.
        """
        until_s, index, count = now_s, self._index(now_s), self._count(now_s)
        for _ in range(count if segments is None else min(count, segments)):
            until_s, index = self._segment_end(until_s, index)
        return until_s

    def _count(self, now_s: float) -> int:
        """Return how many segments can have been computed since the motors started."""
        stepping = self._stepping
        if not stepping.compute_s:
            return stepping.segments
        return int(min((now_s - self._began_s) / stepping.compute_s, stepping.segments))

    def _segment_end(self, start_s: float, index: int) -> tuple[float, int]:
        """Return when a segment that begins in a stretch ends, and in which stretch."""
        if index >= len(self._stretches):
            return start_s, index
        under_way = self._stretches[index]
        enough = STEPS_A_SEGMENT * under_way.line.step
        before, end_s = under_way.piece.at(start_s), start_s
        while True:
            end_s += SEGMENT_S
            while end_s >= under_way.piece.end_s:
                index += 1
                if under_way.last or index == len(self._stretches):
                    return under_way.piece.end_s, index
                under_way = self._stretches[index]
            if under_way.piece.at(end_s) - before >= enough:
                return end_s, index

    def speed(self, now_s: float) -> float:
        """Return the planned speed along the path, in units per second.

        A line that is too slow for the steppers is driven faster than planned.
        """
        found = self._at(now_s)
        if found is None:
            return 0.0
        speed = found.piece.speed_at(now_s)
        return min(speed, found.line.rate) if speed <= found.line.least else speed

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at a time."""
        if not self._stretches:
            return self._base + self._lines[0].made(self._along) if self._lines else self._base
        found = self._at(now_s) or self._stretches[-1]
        counts = self._base
        for one in itertools.takewhile(lambda one: one is not found.line, self._lines):
            counts = counts + one.deltas
        if found.last and now_s >= found.piece.end_s:
            return counts + found.line.deltas
        return counts + found.line.made(found.piece.at(now_s))

    def bends(self, start_s: float, end_s: float) -> Iterator[float]:
        """Yield when lines end: between these times the motors are in proportion."""
        for each in self._stretches:
            at_s = each.piece.end_s
            if at_s >= end_s:
                break
            if each.last and at_s > start_s:
                yield at_s

    def settle(self, now_s: float) -> None:
        """Drop the lines that have ended by now, and stand if held or finished."""
        while self._stretches and self._stretches[0].piece.end_s <= now_s:
            ended = self._stretches.pop(0)
            self._along = ended.piece.at(ended.piece.end_s)
            if ended.last:
                self._base = self._base + self._lines.popleft().deltas
                self._along = 0.0
                self._follow_on(self._stretches)
        if not self._stretches:
            self._follow_on([])

    def stop(self, now_s: float) -> None:
        """Stop dead at the current point of the path, and drop all lines."""
        self._base = Motors(self.positions(now_s))
        self._clear()

    def count(self, deltas: Sequence[int]) -> None:
        """Add steps made outside any motion, while standing."""
        self._base = self._base + Motors(deltas)

    def zero(self) -> None:
        """Set the counts to zero. Nothing turns."""
        self._base = Motors((0,) * len(self._base))
        self._clear()

    def _clear(self) -> None:
        self._lines.clear()
        self._follow_on([])
        self._along, self._held = 0.0, False

    def _index(self, now_s: float) -> int:
        return bisect_right(self._stretches, now_s, key=lambda each: each.piece.end_s)

    def _at(self, now_s: float) -> PlannerStretch | None:
        """Return the stretch under way; None while standing."""
        index = self._index(now_s)
        return self._stretches[index] if index < len(self._stretches) else None

    def _replan(self, now_s: float, from_s: float) -> None:
        """Plan again from a time on; what is under way until then stays."""
        self.settle(now_s)
        kept: list[PlannerStretch] = []
        along, speed = self._along, 0.0
        for each in self._stretches:
            piece = each.piece
            if piece.end_s > from_s:
                # The segments computed before `from_s` are in the steppers' hands already.
                before = piece._replace(duration_s=max(from_s - piece.start_s, 0.0))
                kept.append(PlannerStretch(each.line, before, last=False))
                along, speed = piece.at(from_s), piece.speed_at(from_s)
                break
            kept.append(each)
            along = 0.0 if each.last else piece.at(piece.end_s)
        from_s = max(from_s, kept[-1].piece.end_s) if kept else now_s
        lines = list(self._lines)[sum(each.last for each in kept) :]
        if not self._held:
            kept += planned(lines, along, speed, from_s)
        elif speed > 0.0:
            kept += braked(lines, along, speed, from_s)
        self._follow_on(kept)
        self.settle(now_s)

    def _follow_on(self, stretches: list[PlannerStretch]) -> None:
        if stretches and not self._stretches:
            self._began_s = stretches[0].piece.start_s
        self._stretches = stretches
        ends = (each.piece.end_s for each in stretches if each.last)
        self._next_line_s = min(next(ends, math.inf), self.done_s)
