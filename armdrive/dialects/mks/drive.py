"""One MKS drive: its orders, which may come late or get lost, and what its replies show.

A drive tells its position when it is asked. In addition to what any reading shows (`bus.observer`):

    absence whether it had no power for a moment, by the replies that it owes (`ledger`)
    rest    where it can come to rest after a stop: between where its orders had it, its target and,
            if it was silent, where it was read last, plus a corridor
    speed   what two prompt readings show. After an outage the orders that it has received, and
            when, are not known. So its course begins again at its reading, at that speed, and it is
            judged from there on
    shares  how far it turns in comparison with its orders, which shows a weak drive (`contour`)
"""

from __future__ import annotations

import math
from collections import deque
from typing import TypeAlias

from armdrive.dialects.bus.intervals import Bounds, DriveFinding, covered
from armdrive.dialects.bus.intervals import Reading as CountReading
from armdrive.dialects.bus.observer import ObservedDrive
from armdrive.dialects.bus.paths import Interval
from armdrive.dialects.bus.questions import EPSILON_S
from armdrive.dialects.mks.ledger import Ledger
from armdrive.dialects.mks.settings import MksSettings
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    COUNTS_S_PER_RPM,
    Answered,
    Code,
    Done,
    EnabledRead,
    EncoderRead,
    Event,
    Failed,
    Home,
    HomingRead,
    HomingState,
    LimitStop,
    MotorState,
    MoveAbsoluteAxis,
    Outcome,
    Reading,
    SetMode,
    Setting,
    SettingRead,
    StallRead,
    Started,
    StateRead,
    Status,
    Stray,
    Superseded,
    as_setting,
    slope_of,
)

Answer: TypeAlias = Reading | SettingRead
"""A drive's answer to a question."""

GIVE = COUNTS_PER_TURN // 32
"""How many counts a loaded shaft may give way while its position loop still holds it."""
STILL_S = 0.2
"""A drive stands if its count has not changed for this long since its last order, although it
reports braking.

Firmware 1.0.6 was seen to report braking for ever after a motion (riccardi-samuele/mks-servo,
FAQ). At the lowest speed, 1 rpm, a count changes by 54 in this time.
"""

RUNNING = (MotorState.ACCELERATING, MotorState.FULL_SPEED, MotorState.HOMING)
"""A drive that reports one of these after a stop has not received it."""
TURNING = (*RUNNING, MotorState.DECELERATING)

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

START_WINDOW_S = 0.01
"""A drive that accepts an order says "started" within this time of the "failed" it sends for the
order that was replaced, before or after it."""
REJECTION_LIMIT = 2
"""A drive is examined after this many rejections in a row. After a single one, its "started" may
have been lost."""


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


class Rejections:
    """The orders that one drive has rejected since it accepted one. Seconds.

    A moving drive reports "failed" for an order that a newer one replaces, and also for an order
    that it rejects; no bit tells the two apart. But next to the first it reports that the newer
    order has started.
    """

    def __init__(self) -> None:
        self.due_s = math.inf
        """When the last "failed" counts as a rejection; infinity if the drive accepts orders."""
        self._count = 0

    def clear(self) -> None:
        """Forget all: an order has started, or earlier orders do not matter any more."""
        self.due_s, self._count = math.inf, 0

    def refused(self, now_s: float, started_s: float) -> None:
        """Record a "failed", for this order or the one that it replaced.

        The drive reported last at `started_s` that an order has started.
        """
        if now_s > started_s + START_WINDOW_S:
            self.due_s = min(self.due_s, now_s + START_WINDOW_S)

    @property
    def pending(self) -> bool:
        """Whether it has reported a "failed" for which no "started" came."""
        return math.isfinite(self.due_s)

    def confirm(self) -> bool:
        """Count the due "failed" as a rejection; return whether the drive is to be examined."""
        self.due_s, self._count = math.inf, self._count + 1
        if self._count < REJECTION_LIMIT:
            return False
        self._count = 0
        return True


class MksDrive(ObservedDrive):
    """One drive of an arm, by its orders and its replies."""

    def __init__(self, node: int, name: str, settings: MksSettings) -> None:
        corridor = settings.following_error_counts
        bounds = Bounds(settings.in_position_counts, corridor, GIVE, COUNTS_PER_TURN)
        super().__init__(node, name, bounds)
        self.questions = self.ledger = Ledger()
        self.absence = self.ledger.absence
        self.prompt_s = -math.inf
        """When the last reading came that was surely sampled within the allowed delay."""
        self.frame_s = -math.inf
        """When the last frame from it arrived, requested or not."""
        self.lag = 0.0
        """How far its orders were ahead of it at the last reading."""
        self.sent = Interval(0.0, 0.0)
        """The range of its targets since it stood last."""
        self.shares = TurnedShares(WEAK_MIN_CORRIDOR * bounds.corridor)
        self._readings: deque[CountReading] = deque(maxlen=READINGS)
        self._rest = Interval(-math.inf, math.inf)
        """Where it may come to rest after a stop."""
        self.state: MotorState | None = None
        """Its last motor state since this was cleared."""
        self.homing: HomingState | None = None
        """Its last homing state since this was cleared."""
        self.last_order: MoveAbsoluteAxis | None = None
        """Its last order, unless a stop came after it."""
        self.at_limit = False
        """Whether a limit switch has stopped it since the motion began."""
        self.unfit = False
        """Whether it has reported a stall, no current, or a mode in which the bus moves nothing,
        since the motion began."""
        self.rejections = Rejections()
        self.two_zeros = ""
        """That its targets count from another place than its readings, in words."""

    # -- orders -------------------------------------------------------------------------------

    def watch(self) -> None:
        """Begin a motion: judge the drive from its last reading on."""
        super().watch()
        self.rejections.clear()
        self.at_limit = self.unfit = False

    def follow(self, order: MoveAbsoluteAxis, now_s: float) -> None:
        """Record that it has been sent an order."""
        self.last_order = order
        speed = order.speed_rpm * COUNTS_S_PER_RPM
        self.order(order.counts, speed, slope_of(order.acc), now_s)

    def order(self, goal: int, speed: float, slope: float, now_s: float) -> None:
        """Record an order with its speed and ramp."""
        super().order(goal, speed, slope, now_s)
        if goal not in self.sent:
            self.sent = Interval(min(self.sent.low, goal), max(self.sent.high, goal))

    def stop(self, now_s: float) -> None:
        """Record a stop: the drive comes to rest between its present place and its target.

        One that has been silent may have missed its orders, and be where it was read last. Its last
        order must not be sent again.
        """
        self.last_order = None
        self.course.advance(now_s)
        ends = [self.course.place, self.course.goal]  # the stop may be lost: then it goes on
        if now_s > self.read_s + self.bounds.late_s:
            ends.append(float(self.count))
        margin = self.bounds.corridor + self._late(now_s)
        self._rest = Interval(min(ends), max(ends)).widened(margin)

    def rest_at(self, count: int, now_s: float) -> None:
        """Record that the drive stands at a count."""
        super().rest_at(count, now_s)
        self.sent, self._rest = Interval(count, count), Interval(-math.inf, math.inf)

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

    def _restart_comparison(self, now_s: float) -> None:
        super()._restart_comparison(now_s)
        self.lag = 0.0
        self.shares.clear()

    # -- readings -----------------------------------------------------------------------------

    def read(self, count: int, now_s: float) -> None:
        """Record its count and conclude what that means."""
        self.absence.conclude(now_s)
        super().read(count, now_s)
        self._readings.append(CountReading(count, self.asked_s, now_s))
        if now_s <= self.asked_s + self.bounds.late_s + EPSILON_S:
            self.prompt_s = now_s
        if self.is_within_reach:
            self.lag = self.place - count

    def _judge(self, reading: CountReading, off: float) -> DriveFinding:
        away_s = self.absence.since_s
        if math.isfinite(away_s) and not self._reach.is_left:
            if self.counts_from_zero(away_s, reading.read_s):
                return DriveFinding.RESTARTED
            self.absence.acquit()  # its count proves that it kept its power
        return super()._judge(reading, off)

    def _correct_courses(self, reading: CountReading) -> None:
        turned, ran = self._progress(reading)
        self.shares.add(turned, ran, reading.read_s)
        super()._correct_courses(reading)

    # -- conclusions --------------------------------------------------------------------------

    def _late(self, now_s: float) -> float:
        """Return how far it turns during the allowed delay."""
        return covered(self.course.in_force(now_s).fastest, self.bounds.late_s)

    def margin(self, now_s: float) -> float:
        """Return how far it may be from the common path of all drives."""
        return self.bounds.corridor + self._late(now_s - self.bounds.late_s)

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
    def _two_apart(self) -> tuple[CountReading, CountReading] | None:
        """The last reading, after the latest that is surely older: that one had arrived before."""
        if not self._readings:
            return None
        last = self._readings[-1]
        older = (each for each in reversed(self._readings) if each.read_s + APART_S <= last.asked_s)
        before = next(older, None)
        return None if before is None else (before, last)

    @property
    def measured_speed(self) -> float | None:
        """Its speed at the last reading, measured from an earlier one; None if they do not tell.

        After an outage nothing else tells it: which orders the drive has received, and when, is not
        known, so it may stand, brake or have turned back. It still gains speed towards its target,
        but no more than lets it brake there. Where replies are so late that they do not tell the
        speed of a drive that turns, they tell that it stands once it has come to its target.
        """
        found, course = self._two_apart, self.course
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
    def is_on_path(self) -> bool:
        """Whether its last count is between targets that it received."""
        return self.count in self.sent.widened(self.bounds.corridor)

    # -- messages -----------------------------------------------------------------------------

    def note(self, event: Event, now_s: float) -> None:
        """Record what a message from it shows."""
        match event:
            case Started() | Stray(_, Status(Code.ABSOLUTE_AXIS, Outcome.STARTED)):
                self.confirmed_s = now_s
                self.rejections.clear()
            case Failed(_, MoveAbsoluteAxis()) | Superseded():
                self.rejections.refused(now_s, self.confirmed_s)
            case LimitStop():
                self.at_limit = True
            case Answered(_, _, EncoderRead(counts)):
                self.read(counts, now_s)
            case Stray(_, EncoderRead()):
                self.ledger.located(now_s)
            case Answered(_, _, StateRead(state)):
                self.state = self._believed(state)
            case Answered(_, _, StallRead(on=True) | EnabledRead(on=False)):
                self.unfit = True
            case Answered(_, _, SettingRead(Code.MODE) as mode) if not obeys_bus(setting_of(mode)):
                self.unfit = True
            case Answered(_, _, HomingRead(by_command=homing)) if homing is not None:
                self.homing = homing
            case Done(_, Home()):
                self.homing, self.state = HomingState.DONE, MotorState.STOPPED

    def _believed(self, state: MotorState) -> MotorState:
        """Return the state that it reports, corrected if it reports braking but its count stays."""
        since_s = max(self.still_s, self.course.ordered_s)
        stands = state is MotorState.DECELERATING and self.asked_s >= since_s + STILL_S
        return MotorState.STOPPED if stands else state


def setting_of(answer: Answer | None) -> Setting | None:
    """Return the setting in an answer; None if the drive reported none, or an unknown one."""
    try:
        return as_setting(answer) if isinstance(answer, SettingRead) else None
    except RemoteProtocolError:
        return None


def obeys_bus(setting: Setting | None) -> bool:
    """Return whether the bus can move a drive in this mode; True if the mode is not known."""
    return not isinstance(setting, SetMode) or setting.mode.on_bus
