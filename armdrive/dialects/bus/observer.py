"""Conclude from its orders, questions and replies where a drive is, and whether it is sound.

A finding says whether its last reading lies in the interval in which a healthy shaft can be: the
table is in `dialects.bus`. Reach and following are in `intervals`. Here is one more:

    from zero   as far as any order in force lets it turn since it may have restarted

MKS drives are also judged by the replies that they owe, after a stop and after an outage
(`mks.drive`), and together (`mks.observer`, `mks.steering`).

Pure: no clock, no wire. Counts, seconds.
"""

from __future__ import annotations

import math
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
from armdrive.dialects.bus.paths import Courses
from armdrive.dialects.bus.questions import Questions
from kinematics.spaces import Motors

# A reply takes at most this long, unless the computer is busy.
PROMPT_REPLY_S = 0.03


class ObservedDrive:
    """One drive: its readings, its course by its orders, and the verdict on both."""

    def __init__(self, node: int, name: str, bounds: Bounds) -> None:
        self.node, self.name, self.bounds = node, name, bounds
        self._courses = Courses()
        self.course = self._courses.likely
        """Where it probably is."""
        self.questions = Questions()
        self.confirmed_s = -math.inf
        """When it confirmed last that it has taken an order; never, if such drives do not."""
        self.count = 0
        """Its last count."""
        self.read_s = -math.inf
        """When that was read; minus infinity before the first reading."""
        self.asked_s = -math.inf
        """The earliest moment at which the last reading can have been sampled."""
        self.moving = False
        """Whether it has received a target and was not seen to stand since."""
        self.fresh = False
        """Whether it has received no target since it was found standing."""
        self.finding = DriveFinding.FITS
        """What its last reading shows."""
        self._last: Reading | None = None
        """Its last reading."""
        self._still: Reading | None = None
        """The first of its latest readings that all found it in one place, but for a tremble."""
        self._reach, self._following = Reach(bounds), Following(bounds)
        self._met: Look | None = None
        """The look that the course was last compared with."""
        self.place = 0.0
        """Where its course had it at the last reading."""

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

    def rest_at(self, count: int, now_s: float) -> None:
        """Record that the drive stands at a count."""
        self._courses.rest_at(count, now_s)
        self.moving = self.fresh = False
        self._restart_comparison(now_s)

    def watch(self) -> None:
        """Begin a motion: judge the drive from its last reading on."""
        self._reach.begin(self._last)
        self.finding = DriveFinding.FITS
        self.questions.forget()  # it was read after anything it missed while standing

    def _restart_comparison(self, now_s: float) -> None:
        self._following.begin()
        self._met = Look(self.course.place, self.course.place, now_s)

    # -- readings -----------------------------------------------------------------------------

    def read(self, count: int, now_s: float) -> None:
        """Record its count and conclude what that means."""
        self._courses.advance(now_s)
        self.asked_s = self.questions.located(now_s)
        self.count, self.read_s = count, now_s
        self._last = reading = Reading(count, self.asked_s, now_s)
        if self._still is None or abs(count - self._still.count) > self.bounds.tremble:
            self._still = reading
        off = self._courses.off(count, self._ordered_from_s)
        self._reach.add(reading, self._courses, off)
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
        turned, ran = self._progress(reading)
        count, now_s = reading.count, reading.read_s
        prompt = now_s <= self.questions.asked_s + PROMPT_REPLY_S
        if prompt and turned * ran >= PROGRESS_SHARE * ran * ran:
            self._courses.correct(count, self.questions.asked_s, self._ordered_from_s)
        self._met = Look(count, self.course.place, now_s)

    def _progress(self, reading: Reading) -> tuple[float, float]:
        """Return how far it turned since its course was compared last, and how far that ran."""
        if self._met is None:
            return 0.0, 0.0
        return reading.count - self._met.count, self.course.place - self._met.place

    # -- intervals ----------------------------------------------------------------------------

    @property
    def _ordered_from_s(self) -> float:
        """Since when its orders may have had it where the last reading found it."""
        return self.asked_s - self.bounds.late_s

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
    def still_s(self) -> float:
        """Since when its readings find it in one place; infinity before the first one."""
        return math.inf if self._still is None else self._still.read_s

    @property
    def is_located(self) -> bool:
        """Whether its position has been read."""
        return math.isfinite(self.read_s)

    @property
    def is_near(self) -> bool:
        """Whether its last count is at its target."""
        return self.is_located and abs(self.count - self.goal) <= self.bounds.rest

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
