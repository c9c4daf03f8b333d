"""Conclude from its orders, questions and replies where a drive is, and whether it is sound.

A finding says whether its last reading lies in the interval in which a healthy shaft can be: the
table is in `dialects.bus`. Reach and following are in `intervals`. Here are two more:

    from zero   as far as any order in force lets it turn since it may have restarted
    rest        after a stop: between where its orders had it, its target and, if it was silent,
                where it was read last, plus a corridor

After an outage the orders that a drive has received, and when, are not known. So its course begins
again at its reading, at the speed that two prompt readings show, and it is judged from there on.

Whether it had no power for a moment is in `ledger`. MKS drives are also judged together
(`mks.observer`, `mks.contour`).

Pure: no clock, no wire. Counts, seconds.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable

from armdrive.dialects.bus.intervals import (
    PROGRESS_SHARE,
    Bounds,
    DriveFinding,
    Following,
    Look,
    Reach,
    Reading,
    covered,
)
from armdrive.dialects.bus.ledger import EPSILON_S, Ledger
from armdrive.dialects.bus.paths import Courses, Interval
from kinematics.spaces import Motors

PROMPT_REPLY_S = 0.03
"""A reply takes at most this long, unless the computer is busy."""
SPEED_SPAN_S = 0.03
"""Two readings no farther apart than this tell a drive's speed. It changes little in that time;
and if one reply was so late that its moment is uncertain, they seem farther apart."""
APART_S = 0.01
"""Two readings at least this far apart show that a drive stands, if it has not turned."""
READINGS = 16
"""Readings kept to find one that is surely older than the last, however late replies come."""
WEAK_LOOKS = 5
"""A drive is weak only if it is too slow at this many looks in a row."""
WEAK_MIN_CORRIDOR = 0.1
"""It must have been ordered to turn this share of the corridor from look to look, ..."""
WEAK_SPACING_S = 0.08
"""... and looks closer together than this count as one: orders and replies that are late by some
hundredths of a second affect all drives, and pass."""


class LatestReadings:
    """The latest readings of one drive. One that stands counts up to `tremble` more or less."""

    def __init__(self, tremble: int) -> None:
        self._tremble = tremble
        self._each: deque[Reading] = deque(maxlen=READINGS)
        self._still: Reading | None = None
        """The first of the latest ones that all found it in one place."""

    def add(self, reading: Reading) -> None:
        """Add the next reading."""
        self._each.append(reading)
        if self._still is None or abs(reading.count - self._still.count) > self._tremble:
            self._still = reading

    @property
    def last(self) -> Reading | None:
        """The last one."""
        return self._each[-1] if self._each else None

    @property
    def still_s(self) -> float:
        """Since when they find the drive in one place; infinity before the first one."""
        return math.inf if self._still is None else self._still.read_s

    @property
    def two_apart(self) -> tuple[Reading, Reading] | None:
        """The last one, after the latest that is surely older: that one had arrived before."""
        if not self._each:
            return None
        last = self._each[-1]
        older = (each for each in reversed(self._each) if each.read_s + APART_S <= last.asked_s)
        before = next(older, None)
        return None if before is None else (before, last)


class TurnedShares:
    """How far one drive turned from look to look, as a share of what it was ordered to turn.

    It tells nothing while a drive was ordered to turn less than `least` from look to look.
    """

    def __init__(self, least: float) -> None:
        self._least = least
        self._looks: deque[tuple[float, float]] = deque(maxlen=WEAK_LOOKS)
        """How far it turned, and how far it was ordered to."""
        self._began_s = -math.inf
        """When the last of these looks began."""

    def clear(self) -> None:
        """Forget all looks."""
        self._looks.clear()

    def add(self, turned: float, ran: float, now_s: float) -> None:
        """Add how far the drive turned since the last look, and how far it was ordered to."""
        turned, ran = turned if ran > 0.0 else -turned, abs(ran)
        if self._looks and now_s < self._began_s + WEAK_SPACING_S:
            before = self._looks.pop()
            turned, ran = turned + before[0], ran + before[1]
        else:
            self._began_s = now_s
        self._looks.append((turned, ran))

    @property
    def each(self) -> list[float]:
        """The share at each look; empty if they tell nothing."""
        if len(self._looks) < WEAK_LOOKS or any(ran < self._least for _, ran in self._looks):
            return []
        return [turned / ran for turned, ran in self._looks]


class ObservedDrive:
    """One drive: its readings, its course by its orders, and the verdict on both."""

    def __init__(self, node: int, name: str, bounds: Bounds) -> None:
        self.node, self.name, self.bounds = node, name, bounds
        self._courses = Courses()
        self.course = self._courses.likely
        """Where it probably is."""
        self.ledger = Ledger()
        self.absence = self.ledger.absence
        self.confirmed_s = -math.inf
        """When it confirmed last that it has taken an order; never, if such drives do not."""
        self.count = 0
        """Its last count."""
        self.read_s = -math.inf
        """When that was read; minus infinity before the first reading."""
        self.asked_s = -math.inf
        """The earliest moment at which the last reading can have been sampled."""
        self.prompt_s = -math.inf
        """When the last reading came that was surely sampled within the allowed delay."""
        self.frame_s = -math.inf
        """When the last frame from it arrived, requested or not."""
        self.moving = False
        """Whether it has received a target and was not seen to stand since."""
        self.fresh = False
        """Whether it has received no target since it was found standing."""
        self.lag = 0.0
        """How far its orders were ahead of it at the last reading."""
        self.finding = DriveFinding.FITS
        """What its last reading shows."""
        self.sent = Interval(0.0, 0.0)
        """The range of its targets since it stood last."""
        self.shares = TurnedShares(WEAK_MIN_CORRIDOR * bounds.corridor)
        self._readings = LatestReadings(bounds.tremble)
        self._reach, self._following = Reach(bounds), Following(bounds)
        self._met: Look | None = None
        """The look that the course was last compared with."""
        self.place = 0.0
        """Where its course had it at the last reading."""
        self._rest = Interval(-math.inf, math.inf)
        """Where it may come to rest after a stop."""

    def __str__(self) -> str:
        return f"drive {self.node} ({self.name})"

    # -- orders -------------------------------------------------------------------------------

    @property
    def goal(self) -> int:
        """Its last target, or where it stands."""
        return round(self.course.goal)

    def order(self, goal: int, speed: float, slope: float, now_s: float) -> None:
        """Record an order with its speed and ramp."""
        self._courses.order(goal, speed, slope, now_s)
        self.moving, self.fresh = True, False
        if goal not in self.sent:
            self.sent = Interval(min(self.sent.low, goal), max(self.sent.high, goal))

    def stop(self, now_s: float) -> None:
        """Record a stop: the drive comes to rest between its present place and its target.

        One that has been silent may have missed its orders, and be where it was read last.
        """
        self.course.advance(now_s)
        ends = [self.course.place, self.course.goal]  # the stop may be lost: then it goes on
        if now_s > self.read_s + self.bounds.late_s:
            ends.append(float(self.count))
        margin = self.bounds.corridor + self._late(now_s)
        self._rest = Interval(min(ends), max(ends)).widened(margin)

    def rest_at(self, count: int, now_s: float) -> None:
        """Record that the drive stands at a count."""
        self._courses.rest_at(count, now_s)
        self.moving = self.fresh = False
        self.sent, self._rest = Interval(count, count), Interval(-math.inf, math.inf)
        self.ledger.forget()
        self._restart_comparison(now_s)

    def stand(self, now_s: float) -> None:
        """Record that the drive stands: at its target if it is near it, otherwise at its count.

        Its course may have left both: it followed the readings of a drive that homed by itself.
        """
        if self.moving or not self.is_near:
            self.rest_at(self.count, now_s)
            return
        self._courses.rest_at(self.goal, now_s)
        self._restart_comparison(now_s)

    def resume_from_reading(self, now_s: float) -> None:
        """Let its course continue from the last reading, at its time; the target stays.

        The drive is judged from there on: its orders during the outage may have come late.
        """
        self.finding = DriveFinding.FITS
        at, speed = float(self.count), self.measured_speed or 0.0
        self._courses.put(at, speed, self.asked_s, now_s)
        self._restart_comparison(now_s)

    def watch(self) -> None:
        """Begin a motion: judge the drive from its last reading on."""
        self._reach.begin(self._readings.last)
        self.finding = DriveFinding.FITS
        self.ledger.forget()  # it was read after anything it missed while standing

    def _restart_comparison(self, now_s: float) -> None:
        self.lag = 0.0
        self._following.begin()
        self.shares.clear()
        self._met = Look(self.course.place, self.course.place, now_s)

    # -- readings -----------------------------------------------------------------------------

    def read(self, count: int, now_s: float) -> None:
        """Record its count and conclude what that means."""
        self._courses.advance(now_s)
        self.asked_s = self.ledger.located(now_s)
        self.count, self.read_s = count, now_s
        if now_s <= self.asked_s + self.bounds.late_s + EPSILON_S:
            self.prompt_s = now_s
        reading = Reading(count, self.asked_s, now_s)
        self._readings.add(reading)
        self.absence.conclude(now_s)
        off = self._courses.off(count, self._ordered_from_s)
        self._reach.add(reading, self._courses, off)
        if self._reach.is_within:
            self.lag = self.course.place - count
        self.finding, self.place = self._judge(reading, off), self.course.place
        if self.moving and self.finding in (DriveFinding.FITS, DriveFinding.BEHIND):
            self._correct_courses(reading)

    def _judge(self, reading: Reading, off: float) -> DriveFinding:
        """Return what the last reading shows.

        `off` is how far the shaft is from where its orders had it within the allowed delay.
        """
        now_s = reading.read_s
        if self._reach.is_left:
            restarted = self.counts_from_zero(self._reach.since_s, now_s)
            return DriveFinding.RESTARTED if restarted else DriveFinding.ELSEWHERE
        if math.isfinite(self.absence.since_s):
            if self.counts_from_zero(self.absence.since_s, now_s):
                return DriveFinding.RESTARTED
            self.absence.acquit()  # its count proves that it kept its power
        if not self._reach.is_within:
            return DriveFinding.DOUBTED
        place = self.course.place
        return self._following.judge(reading, place, off, self.still_s, self.confirmed_s)

    def _correct_courses(self, reading: Reading) -> None:
        """Move its courses towards the reading.

        A shaft that does not turn moves nothing: otherwise its course would wait for it, and a
        blocked shaft would never be found. Only prompt replies count, since a late one belongs to
        another moment.
        """
        count, place, now_s = reading.count, self.course.place, reading.read_s
        met = self._met or Look(count, place, now_s)
        turned, ran = count - met.count, place - met.place
        self.shares.add(turned, ran, now_s)
        prompt = now_s <= self.ledger.asked_s + PROMPT_REPLY_S
        if prompt and turned * ran >= PROGRESS_SHARE * ran * ran:
            self._courses.correct(count, self.ledger.asked_s, self._ordered_from_s)
        self._met = Look(count, self.course.place, now_s)

    # -- intervals ----------------------------------------------------------------------------

    @property
    def _ordered_from_s(self) -> float:
        """Since when its orders may have had it where the last reading found it."""
        return self.asked_s - self.bounds.late_s

    def _late(self, now_s: float) -> float:
        """Return how far it turns during the allowed delay."""
        return covered(self.course.in_force(now_s).fastest, self.bounds.late_s)

    def margin(self, now_s: float) -> float:
        """Return how far it may be from the common path of all drives."""
        return self.bounds.corridor + self._late(now_s - self.bounds.late_s)

    def counts_from_zero(self, since_s: float, now_s: float) -> bool:
        """Return whether its count can have started at zero since then, or lost whole turns.

        Some encoders know their angle within a turn and start counting there.
        """
        count, rest = self.count, self.bounds.rest
        if abs(count) <= rest + covered(self.course.in_force(since_s).fastest, now_s - since_s):
            return True
        if self.moving or not self.bounds.turn:
            return False
        turns = round((self.goal - count) / self.bounds.turn)
        near = abs(self.goal - count - turns * self.bounds.turn) <= rest
        return bool(turns) and near and -rest <= count < self.bounds.turn + rest

    @property
    def is_elsewhere(self) -> bool:
        """Whether it was out of reach twice: no shaft can have turned there."""
        return self.finding in (DriveFinding.RESTARTED, DriveFinding.ELSEWHERE)

    def may_have_restarted(self, now_s: float) -> bool:
        """Whether its next order might turn it from a new zero.

        It is silent, or out of reach, or still owes replies: then it was not read since, or may
        count from zero.
        """
        if self.finding is DriveFinding.DOUBTED or self.ledger.silent:
            return True
        away_s = self.absence.suspected_s
        return self.absence.suspected and (
            self.read_s < away_s or self.counts_from_zero(away_s, now_s)
        )

    @property
    def is_within_reach(self) -> bool:
        """Whether a shaft can have turned to its last count."""
        return self._reach.is_within

    @property
    def rests_off_path(self) -> bool:
        """Whether it came to rest outside the interval of its stop."""
        return bool(self.course.max_speed) and self.count not in self._rest

    @property
    def still_s(self) -> float:
        """Since when its readings find it in one place; infinity before the first one."""
        return self._readings.still_s

    @property
    def measured_speed(self) -> float | None:
        """Its speed at the last reading, measured from an earlier one; None if they do not tell.

        After an outage nothing else tells it: which orders the drive has received, and when, is not
        known, so it may stand, brake or have turned back. It still gains speed towards its target,
        but no more than lets it brake there. Where replies are so late that they do not tell the
        speed of a drive that turns, they tell that it stands once it has come to its target.
        """
        found, course = self._readings.two_apart, self.course
        if found is None:
            return None
        before, last = found
        turned = last.count - before.count
        shortest_s, longest_s = last.asked_s - before.read_s, last.read_s - before.asked_s
        if abs(turned) <= self.bounds.tremble or not self.moving:
            return 0.0
        if longest_s > SPEED_SPAN_S:
            return None  # its speed may have changed since
        mean = 2.0 * turned / (shortest_s + longest_s)
        left = course.goal - last.count
        brakable = math.sqrt(2.0 * course.slope * abs(left)) if left else 0.0
        most = min(max(course.max_speed, abs(mean)), brakable)
        sign = math.copysign(1.0, left)
        return sign * min(sign * mean + course.slope * longest_s / 2.0, most)

    @property
    def is_located(self) -> bool:
        """Whether its position has been read."""
        return math.isfinite(self.read_s)

    @property
    def is_near(self) -> bool:
        """Whether its last count is at its target."""
        return self.is_located and abs(self.count - self.goal) <= self.bounds.rest

    @property
    def is_on_path(self) -> bool:
        """Whether its last count is between targets that it received."""
        return self.count in self.sent.widened(self.bounds.corridor)

    # -- register -----------------------------------------------------------------------------

    @property
    def register(self) -> int:
        """Its count; that of its target if it stands there, since a position loop trembles."""
        if not self.is_located or (not self.moving and self.is_near):
            return self.goal
        return self.count

    def found_near(self, there: int, now_s: float) -> int:
        """Return where it stands: where it was left, if it was found near there."""
        if self.fresh and abs(self.goal - there) <= self.bounds.rest:
            self.rest_at(there, now_s)
            self.fresh = True
        return self.goal


def unwrapped(
    drives: Iterable[ObservedDrive], registers: Motors, near: Motors, now_s: float
) -> Motors:
    """Return the registers, with drives that are near where they were left taken to be there.

    A position loop holds within some counts. Nothing wraps: an arm does not turn that far.
    """
    return Motors(
        drive.found_near(there, now_s) if count == drive.goal else count
        for drive, count, there in zip(drives, registers, near, strict=True)
    )
