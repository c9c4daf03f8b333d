"""Steppers that follow queued straight lines with lookahead, as GRBL's planner has them do.

Known at every moment without ticking: the path's length is quadratic in time, piece by piece, and
each motor stands at the step that is nearest to the path. Lines may be queued while others run,
the motion can be held and resumed, and its speed overridden. Each of these plans anew, but for the
segments that are computed already: they are driven as they are (gnea/grbl grbl/stepper.c,
st_prep_buffer).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from armdrive.sim.path_line import Line, PathLimits, line
from armdrive.sim.path_plan import Stretch, braked, planned
from kinematics.spaces import Motors

SEGMENT_S = 0.01
STEPS_A_SEGMENT = 1.25
"""A segment lasts as many times 10 ms as its busiest motor takes for so many steps, or to the end
of its line."""


@dataclass(frozen=True, slots=True)
class Stepping:
    """How a processor steps: `segments` are computed ahead of the motors, each in `compute_s`.

    The motor that makes most steps of a line makes no fewer than `slowest_hz` a second.
    """

    segments: int = 0
    compute_s: float = 0.0
    slowest_hz: float = 0.0


class PathRack:
    """The lines under way. A device that bounds their number looks at `waiting`."""

    def __init__(
        self, counts: Sequence[int], limits: PathLimits, stepping: Stepping | None = None
    ) -> None:
        self.limits = limits
        self._stepping = stepping or Stepping()
        self._base = Motors(counts)
        self._lines: deque[Line] = deque()
        self._stretches: list[Stretch] = []
        self._next_line_s = math.inf
        self._computed = math.nan, math.nan
        self._began_s = -math.inf
        self._along = 0.0
        self._held = False
        self._scale = (1.0, 1.0)

    @property
    def moving(self) -> bool:
        """Whether a motion is under way, or has ended and nobody has called `settle` since."""
        return bool(self._stretches)

    @property
    def held(self) -> bool:
        """Whether the motion is held, or slows down to be."""
        return self._held

    @property
    def waiting(self) -> int:
        """How many lines are not finished, the one under way included."""
        return len(self._lines)

    @property
    def goal(self) -> Motors:
        """Where the last line ends."""
        return sum((Motors(each.deltas) for each in self._lines), self._base)

    @property
    def done_s(self) -> float:
        """When the motion comes to a stand-still by itself; infinity while there is none."""
        return self._stretches[-1].piece.end_s if self._stretches else math.inf

    @property
    def next_line_s(self) -> float:
        """When the line under way ends, or the motion stands; infinity while there is none."""
        return self._next_line_s

    def ending_by(self, time_s: float) -> int:
        """Return how many of the lines will have ended by a time, as it is planned now."""
        return sum(1 for each in self._stretches if each.last and each.piece.end_s <= time_s)

    def queue(
        self,
        deltas: Sequence[int],
        rate: float,
        now_s: float,
        *,
        rapid: bool = False,
        tag: Any = None,
    ) -> bool:
        """Append a line by its steps, at a rate in units a second; False where it is no way at all.

        A `rapid` one goes as fast as the axes allow.
        """
        added = line(deltas, self.limits, rate, self._stepping.slowest_hz, rapid=rapid, tag=tag)
        if added is None:
            return False
        computed_s = self.computed_s(now_s)
        self._lines.append(added)
        self._replan(now_s, computed_s)
        return True

    def hold(self, now_s: float, *, dead: bool = False) -> None:
        """Slow down to a stand-still along the path; the lines stay.

        `dead` gives up the segments that are computed already.
        """
        self._held = True
        self._replan(now_s, now_s if dead else self.computed_s(now_s))

    def resume(self, now_s: float) -> None:
        """Go on along the path."""
        self._held = False
        self._replan(now_s, self.computed_s(now_s))

    def override(self, feed: float, rapid: float, now_s: float) -> None:
        """Scale the speeds of feeds and of rapids from now on; 1 is as asked."""
        self._scale = (feed, rapid)
        self._replan(now_s, self.computed_s(now_s))

    def computed_s(self, now_s: float) -> float:
        """Return up to when the motion is computed; the moment itself while there is none."""
        if self._computed[0] != now_s:
            until_s, index = now_s, self._index(now_s)
            for _ in range(self._count(now_s)):
                until_s, index = self._segment_end(until_s, index)
            self._computed = now_s, until_s
        return self._computed[1]

    def _count(self, now_s: float) -> int:
        """Return how many segments there has been time to compute since the motors stood."""
        stepping = self._stepping
        if not stepping.compute_s:
            return stepping.segments
        return int(min((now_s - self._began_s) / stepping.compute_s, stepping.segments))

    def _segment_end(self, start_s: float, index: int) -> tuple[float, int]:
        """Return when a segment ends that begins in a stretch, and the stretch behind it."""
        if index >= len(self._stretches):
            return start_s, index
        under_way = self._stretches[index]
        enough = STEPS_A_SEGMENT * self._lines[under_way.number].step
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
        """Return how fast the path is followed, in units a second."""
        found = self._at(now_s)
        return 0.0 if found is None else found.piece.speed_at(now_s)

    def tag(self, now_s: float) -> Any:
        """Return the tag of the line under way, or held; None while there is none."""
        found = self._at(now_s)
        if found is not None:
            return self._lines[found.number].tag
        return self._lines[0].tag if self._lines and not self._stretches else None

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at a moment."""
        if not self._stretches:
            return tuple(
                self._base + Motors(self._lines[0].made(self._along)) if self._lines else self._base
            )
        found = self._at(now_s) or self._stretches[-1]
        counts = self._base
        for number in range(found.number):
            counts = counts + Motors(self._lines[number].deltas)
        return tuple(counts + Motors(self._made(found, now_s)))

    def bends(self, start_s: float, end_s: float) -> Iterator[float]:
        """Yield when lines end: in between the motors are in proportion."""
        ends = (each.piece.end_s for each in self._stretches if each.last)
        return (at for at in ends if start_s < at < end_s)

    def settle(self, now_s: float) -> None:
        """Forget the lines that have ended by now; held or at the end, stand."""
        while self._stretches and self._stretches[0].piece.end_s <= now_s:
            ended = self._stretches.pop(0)
            self._along = ended.piece.at(ended.piece.end_s)
            if ended.last:
                self._base = self._base + Motors(self._lines.popleft().deltas)
                self._along = 0.0
                self._follow_on(
                    [Stretch(each.number - 1, each.piece, each.last) for each in self._stretches]
                )
        if not self._stretches:
            self._follow_on([])

    def stop(self, now_s: float) -> None:
        """Stop dead where the path is now, and drop every line."""
        self._base = Motors(self.positions(now_s))
        self._clear()

    def count(self, deltas: Sequence[int]) -> None:
        """Count steps that were made apart from any motion, while standing."""
        self._base = self._base + Motors(deltas)

    def zero(self) -> None:
        """Begin to count anew; nothing turns."""
        self._base = Motors((0,) * len(self._base))
        self._clear()

    def _clear(self) -> None:
        self._lines.clear()
        self._follow_on([])
        self._along, self._held = 0.0, False

    def _index(self, now_s: float) -> int:
        return bisect_right(self._stretches, now_s, key=lambda each: each.piece.end_s)

    def _at(self, now_s: float) -> Stretch | None:
        """Return the stretch under way; None while standing."""
        index = self._index(now_s)
        return self._stretches[index] if index < len(self._stretches) else None

    def _made(self, found: Stretch, now_s: float) -> tuple[int, ...]:
        one = self._lines[found.number]
        if found.last and now_s >= found.piece.end_s:
            return one.deltas
        return one.made(found.piece.at(now_s))

    def _replan(self, now_s: float, from_s: float) -> None:
        """Plan anew from a moment on; what is under way until then stays."""
        self.settle(now_s)
        kept: list[Stretch] = []
        number, along, speed = 0, self._along, 0.0
        for each in self._stretches:
            piece = each.piece
            if piece.end_s > from_s:
                before = replace(piece, duration_s=max(from_s - piece.start_s, 0.0))
                kept.append(Stretch(each.number, before, last=False))
                number, along, speed = each.number, piece.at(from_s), piece.speed_at(from_s)
                break
            kept.append(each)
            number, along = (
                (each.number + 1, 0.0) if each.last else (each.number, piece.at(math.inf))
            )
        from_s = max(from_s, kept[-1].piece.end_s) if kept else now_s
        lines = list(self._lines)[number:]
        if not self._held:
            added = planned(lines, along, speed, from_s, self.limits, self._scale)
        else:
            added = braked(lines, along, speed, from_s) if speed > 0.0 else []
        later = [Stretch(each.number + number, each.piece, each.last) for each in added]
        self._follow_on([*kept, *later])
        self.settle(now_s)

    def _follow_on(self, stretches: list[Stretch]) -> None:
        if stretches and not self._stretches:
            self._began_s = stretches[0].piece.start_s
        self._stretches = stretches
        self._computed = math.nan, math.nan
        ends = (each.piece.end_s for each in stretches if each.last)
        self._next_line_s = min(next(ends, math.inf), self.done_s)
