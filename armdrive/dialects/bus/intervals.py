"""Where a healthy shaft can be, and what a reading shows that lies elsewhere. Counts, seconds.

    Bounds     how far from its orders a healthy drive may be
    Reach      whether a shaft can have turned to its readings at all
    Following  whether it comes along with its orders: it fits, is behind them, or is blocked

A reading is a count and the time span in which it was sampled, since a reply does not name its
question. An order may be obeyed late, or never. The intervals, for a reading that arrived at r and
was asked for at q or later:

    reach       from the place in reach that was nearest to the reading before: as far as any
                order in force lets the drive turn since then; also wherever its orders had it
                lately (a blocked shaft springs there when it comes free), plus the give of a
                loaded shaft
    following   where its orders had it between q - late_s and r, plus a corridor. It has two
                courses: one if all its orders are equally late, one that its readings move

The orders in force are those that a drive may still obey (`paths.Course.in_force`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from armdrive.dialects.bus.paths import Courses, Interval

# A drive may still follow orders up to this old. Unless the computer is overloaded, orders and
# polls are at most this late.
MAX_DELAY_S = 0.1
# A drive that is behind makes progress if it turns at least this share of what it was ordered.
PROGRESS_SHARE = 0.5
# A drive that has not turned for this long, though it confirmed an order to turn, is blocked. At
# the end of a motion it gets about as long: three times three looks, 0.02 s apart.
STANDING_S = 0.15
# How much faster than ordered a sound drive may turn, for its reach. Real MKS drives ordered to
# 2400 to 3000 rpm turned 0.8 % faster (riccardi-samuele/mks-servo-cpp, setup guide).
SPEED_ERROR = 1.05
# The second of two readings is asked for at least this long after the first one arrived.
LOOK_S = 0.05
# A finding must hold at this many looks in a row before a drive is blamed.
CONFIRMING_LOOKS = 2


class DriveFinding(Enum):
    """The kinds of verdicts: see the table of `dialects.bus`."""

    FITS = "fits"
    DOUBTED = "doubted"
    BEHIND = "behind"
    BLOCKED = "blocked"
    RESTARTED = "restarted"
    ELSEWHERE = "elsewhere"
    OFF_PATH = "off path"
    MUTE = "mute"
    SILENT = "silent"
    LATE = "late"

    @property
    def ends(self) -> bool:
        """Whether it ends the motion."""
        return self not in (DriveFinding.FITS, DriveFinding.DOUBTED, DriveFinding.BEHIND)


@dataclass(frozen=True, slots=True)
class Bounds:
    """How far from its orders a healthy drive may be.

    At rest it is within `rest` of its target. In motion it may be a `corridor` away from any point
    that its orders had it at during the last `late_s`. A loaded shaft may give way by `give` while
    its position loop still holds it. `turn` is one turn of an encoder that keeps its angle over a
    restart, 0 for others.
    """

    rest: int
    corridor: float
    give: float
    turn: int = 0
    late_s: float = MAX_DELAY_S

    @property
    def tremble(self) -> int:
        """How far the count of a drive that stands may vary."""
        return self.rest // 4 + 1


@dataclass(frozen=True, slots=True)
class Reading:
    """A count, sampled at some time between the question and the reply."""

    count: int
    asked_s: float
    read_s: float


@dataclass(slots=True)
class Look:
    """A drive's count, and where its orders had it at that moment."""

    count: float
    place: float
    read_s: float


class Reach:
    """How far the shaft of one drive can have turned since its last reading within reach."""

    def __init__(self, bounds: Bounds) -> None:
        self._bounds = bounds
        self._place = 0.0
        """The place within reach that was nearest to that reading."""
        self.since_s = math.inf
        """The earliest moment at which the shaft was there; infinity before the first reading."""
        self._outside = 0
        """How many readings in a row were out of reach."""

    def begin(self, last: Reading | None) -> None:
        """Take the last reading, if there is one, to be within reach."""
        self._outside, self.since_s = 0, math.inf
        if last is not None:
            self._place, self.since_s = float(last.count), last.asked_s

    def add(self, reading: Reading, courses: Courses, off: float) -> None:
        """Add a reading, which is `off` the nearer one of its courses."""
        count, give = reading.count, self._bounds.give
        # both courses lie within reach, so a drive that is on one of them is within it
        reach = self._interval(reading, courses) if off else Interval(count, count)
        if off <= give or reach.beyond(count) <= give:
            # the give is granted once, not from look to look: else a slow runaway would always fit
            self._place, self.since_s = reach.nearest(count), reading.asked_s
            self._outside = 0
        else:
            self._outside += 1

    @property
    def is_left(self) -> bool:
        """Whether the shaft was out of reach twice."""
        return self._outside >= CONFIRMING_LOOKS

    @property
    def is_within(self) -> bool:
        """Whether a shaft can have turned to the last reading."""
        return not self._outside

    def _interval(self, reading: Reading, courses: Courses) -> Interval:
        """Return where the shaft can have turned."""
        first = math.isinf(self.since_s)
        place = float(reading.count) if first else self._place
        since_s = reading.read_s if first else self.since_s
        orders, brakes = courses.likely.in_force(since_s), courses.likely.braking
        up, down, goals = SPEED_ERROR * orders.up, SPEED_ERROR * orders.down, orders.goals
        # no farther than its targets, plus the distance that it needs to brake and turn back
        for_s = reading.read_s - since_s
        high = place + min(covered(up, for_s), max(goals.high - place + brakes(up), 0.0))
        low = place - min(covered(down, for_s), max(place - goals.low + brakes(down), 0.0))
        lately = courses.hull(reading.asked_s - self._bounds.late_s)
        return Interval(min(low, lately.low), max(high, lately.high))


class Following:
    """Whether one drive comes along with its orders, by readings that are within its reach."""

    def __init__(self, bounds: Bounds) -> None:
        self._bounds = bounds
        self._behind: Look | None = None
        """The look behind its course that the next one is compared with; None while it follows."""
        self._off_course_s = math.inf
        """Since when its readings find it off its course; infinity while they do not."""

    def begin(self) -> None:
        """Forget earlier readings: its course begins again."""
        self._behind, self._off_course_s = None, math.inf

    def judge(
        self, reading: Reading, place: float, off: float, still_s: float, confirmed_s: float
    ) -> DriveFinding:
        """Return what a reading shows, when its course had the drive at a place.

        `off` is how far it is off the nearer one of its courses within the allowed delay. It has
        not turned since `still_s`, and confirmed an order last at `confirmed_s`.
        """
        if self._stands_despite_orders(reading, off, still_s, confirmed_s):
            return DriveFinding.BLOCKED
        if off <= self._bounds.corridor:
            self._behind = None
            return DriveFinding.FITS
        before, look = self._behind, Look(reading.count, place, reading.read_s)
        if before is not None and reading.asked_s < before.read_s + LOOK_S:
            return DriveFinding.BEHIND  # both readings may be of the same moment
        if before is not None and not self._progresses(before, look):
            return DriveFinding.BLOCKED
        self._behind = look
        return DriveFinding.BEHIND

    def _stands_despite_orders(
        self, reading: Reading, off: float, still_s: float, confirmed_s: float
    ) -> bool:
        """Return whether it has stood off its orders for long, although it confirmed one meanwhile.

        A slow drive that is blocked stays within its corridor: it is steered from where it was
        read, so its targets stay near it. It would spring to them as soon as it comes free.
        """
        if off <= self._bounds.rest:
            self._off_course_s = math.inf
            return False
        self._off_course_s = min(self._off_course_s, reading.read_s)
        since_s = max(still_s, self._off_course_s)
        confirmed = confirmed_s > since_s  # else its orders may have been lost
        return confirmed and reading.asked_s >= since_s + STANDING_S

    def _progresses(self, before: Look, now: Look) -> bool:
        """Return whether it turned and came nearer to its course, or at least half as far as that.

        One that is ahead, since the order to slow down came late, goes on until its course comes.
        """
        turned, ran = now.count - before.count, now.place - before.place
        was_off, is_off = abs(before.place - before.count), abs(now.place - now.count)
        nearer = is_off < was_off - self._bounds.rest
        follows = turned * ran >= PROGRESS_SHARE * ran * ran > 0.0
        return abs(turned) > self._bounds.rest and (nearer or follows)


def covered(speed: float, for_s: float) -> float:
    """Return the distance covered in a time; an infinite speed covers any distance at once."""
    return speed * for_s if math.isfinite(speed) else math.inf
