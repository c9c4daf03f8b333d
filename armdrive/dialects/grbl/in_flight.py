"""The lines of one motion that have been sent: which are done, where the arm is.

Nothing but a report says that a line was driven. A block leaves the board's planner as soon as its
last segment is computed, so that the reported position has the last word: a line is behind us when
the position lies on a later one, or when the board is Idle with an empty planner.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from armdrive.dialects.grbl.planner import Limits, MotionBounds, MotorPath, SegmentBuffer, planned_s
from armdrive.tasks import MoveBy
from kinematics.spaces import Motors

REPORT_S = 0.15
"""A report may be this old. A position that is farther behind the planner than the segment buffer
and such a report explain belongs to a way that went wrong: back along itself, say."""


@dataclass(frozen=True, slots=True)
class InFlightLine:
    """One line: from where to where, absolute, and how it is driven."""

    start: Motors
    end: Motors
    way: MotorPath
    sent_s: float

    def share_at(self, position: Motors, tolerance: float) -> float | None:
        """Return how much of it has been driven at a position on it; None for one off it."""
        delta = self.end - self.start
        made = position - self.start
        busiest = max(range(len(delta)), key=lambda motor: abs(delta[motor]))
        share = min(max(made[busiest] / delta[busiest], 0.0), 1.0)
        off = max(abs(count - whole * share) for count, whole in zip(made, delta, strict=True))
        return share if off <= tolerance else None


class InFlightLines:
    """The lines under way. `unanswered` counts the last of them, which have had no ok.

    `ends_s` is when the motors should come to a stand.
    """

    def __init__(
        self, start: Motors, limits: Limits, tolerance: float, segments: SegmentBuffer
    ) -> None:
        self.start = self.end = start
        self.unanswered = 0
        self.oks = 0
        self._limits = limits
        self._tolerance = tolerance
        self._segments = segments
        self.ends_s = -math.inf
        self._lines: deque[InFlightLine] = deque()
        self._share = 0.0

    @property
    def empty(self) -> bool:
        """Tell whether every line that was sent is known to be done."""
        return not self._lines

    @property
    def waiting(self) -> int:
        """How many lines are not known to be done."""
        return len(self._lines)

    @property
    def oldest_sent_s(self) -> float:
        """When the oldest line without an ok was sent."""
        return self._lines[-self.unanswered].sent_s

    def send(self, steps: Motors, way: MotorPath, now_s: float) -> None:
        """Take in a line that is sent now."""
        lasts_s = way.nominal_s if self._lines else planned_s([way], self._limits)
        self.ends_s = max(self.ends_s, now_s) + lasts_s
        self._lines.append(InFlightLine(self.end, self.end + steps, way, now_s))
        self.end = self.end + steps
        self.unanswered += 1

    def answered(self, now_s: float) -> None:
        """Take in an ok: the oldest line without one is planned, and begins if it is alone."""
        if len(self._lines) == 1:
            self.ends_s = max(self.ends_s, now_s + planned_s(self.rest(), self._limits))
        self.unanswered = max(self.unanswered - 1, 0)
        self.oks += 1

    def take_as_answered(self) -> None:
        """Give up waiting for oks that were lost."""
        self.unanswered = 0

    def rest(self, more: MotorPath | None = None) -> list[MotorPath]:
        """Return what is left to drive, and one way more."""
        ways = [line.way for line in self._lines]
        if ways:
            ways[0] = ways[0].rest(self._share)
        return ways if more is None else [*ways, more]

    def fits(self, more: MotorPath, ahead_s: float, ramp_s: float) -> bool:
        """Tell whether one way more leaves the planner no more than so much time to drive.

        What the segment buffer holds comes on top, since the planner does not have it any more,
        and so do ramps: lines are driven from wherever they are to a stand-still.
        """
        ways = self.rest(more)
        if len(ways) == 1:
            return True
        ahead_s += self._segments.holds_s(ways)
        nominal_s = sum(each.nominal_s for each in ways)
        return (
            nominal_s <= ahead_s + 1e-6 and planned_s(ways, self._limits) <= ahead_s + ramp_s + 1e-6
        )

    def has_room(self, guess_s: float, ahead_s: float) -> bool:
        """Tell whether a line of such a duration would fit behind those under way."""
        ways = self.rest()
        if not ways:
            return True
        ahead_s += self._segments.holds_s(ways)
        return sum(each.nominal_s for each in ways) + guess_s <= ahead_s + 1e-6

    def ends_by(self, time_s: float) -> bool:
        """Tell whether the motion that is known to be under way may have ended by a time."""
        return bool(self._lines) and self.ends_s <= time_s

    def expected_s(self) -> float:
        """Return how long the rest should take."""
        return planned_s(self.rest(), self._limits)

    def at_end(self, position: Motors) -> bool:
        """Tell whether a position is where the last line leads."""
        return position == self.end

    def report(
        self, position: Motors, now_s: float, *, idle: bool, planned: int | None = None
    ) -> bool:
        """Take in a report; False where its position is off every line that can be under way.

        `idle` says that the board stands and that its planner is empty: what it has acknowledged
        is done. `planned` is how many lines its planner holds.
        """
        if idle:
            self._drop(len(self._lines) - self.unanswered)
        if not self._lines:
            return (position - self.start).largest <= self._tolerance
        for index, line in enumerate(self._lines):
            share = line.share_at(position, self._tolerance)
            if share is not None:
                late = self._too_late(position, index, share, planned)
                self._drop(index)
                self._share = share
                self.ends_s = now_s + sum(each.nominal_s for each in self.rest())
                return not late
        return False

    def _too_late(self, position: Motors, index: int, share: float, planned: int | None) -> bool:
        """Tell whether a position lies farther behind the planner than its segments explain."""
        computed = 0 if planned is None else len(self._lines) - self.unanswered - planned
        lines = list(self._lines)[index : max(computed, 0)]
        if not lines or (lines[-1].end - position).largest <= self._tolerance:
            return False
        ways = [lines[0].way.rest(share), *(line.way for line in lines[1:])]
        late_s = sum(each.nominal_s for each in ways)
        return late_s > self._segments.holds_s(ways) + REPORT_S

    def _drop(self, count: int) -> None:
        for _ in range(count):
            self.start = self._lines.popleft().end
            self._share = 0.0
        self.unanswered = min(self.unanswered, len(self._lines))  # an ok was lost on the way


@dataclass(slots=True)
class LineTrip:
    """One motion under way: where its lines come from, and what is known of those sent.

    A motion that is slower than the board can is `lead_s` ahead of its time, and no line is sent
    before `not_before_s`. `waits` is true in a pause. The motors began to turn at `began_s`.
    The last report shows what was so at `seen_s`, when it was asked for.
    """

    segments: Iterator[MoveBy]
    lines: InFlightLines
    bounds: MotionBounds
    ahead_s: float
    jog: bool
    drawn: MoveBy | None = None
    exhausted: bool = False
    not_before_s: float = -math.inf
    waits: bool = False
    lead_s: float = 0.0
    began_s: float = -math.inf
    polled_s: float = -math.inf
    awaiting: bool = False
    seen_s: float = -math.inf
    changed_s: float = 0.0
    off: int = 0
    steps: int = 0
    dry: bool = False
    starved: bool = False
    guess_s: float = 0.0

    @property
    def finished(self) -> bool:
        """Tell whether there is nothing more to send, and all that was sent is done."""
        return self.exhausted and self.drawn is None and self.lines.empty

    @property
    def waits_for_ok(self) -> bool:
        """Whether a line has to be answered before the next: in a jog, and the first of all.

        A stray character spoils the first one: it is refused, and nothing has moved.
        """
        return self.lines.unanswered > 0 and (self.jog or not self.lines.oks)
