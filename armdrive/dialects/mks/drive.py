"""One MKS drive: its orders, which may come late or get lost, and what its replies show.

A drive tells its position when it is asked. In addition to what any reading shows (`bus.observer`):

    absence whether it had no power for a moment, by the replies that it owes (`ledger`)
    rest    where it can come to rest after a stop: between where its orders had it, its target and,
            if it was silent, where it was read last, plus a corridor
"""

from __future__ import annotations

import math

from armdrive.dialects.bus.intervals import Bounds, DriveFinding, Reading, covered
from armdrive.dialects.bus.observer import ObservedDrive
from armdrive.dialects.bus.paths import Interval
from armdrive.dialects.bus.questions import EPSILON_S
from armdrive.dialects.mks.ledger import POLL_SPACING_S, Ledger
from armdrive.dialects.mks.settings import MksSettings
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    COUNTS_S_PER_RPM,
    Answer,
    Answered,
    Code,
    EnabledRead,
    EncoderRead,
    HomingRead,
    HomingState,
    MotorState,
    MoveAbsoluteAxis,
    Outcome,
    SetMode,
    Setting,
    SettingRead,
    StallRead,
    StateRead,
    Status,
    as_setting,
    slope_of,
)

# How many counts a loaded shaft may give way while its position loop still holds it.
GIVE = COUNTS_PER_TURN // 32
# A drive stands if its count has not changed for this long since its last order, although it
# reports braking.
#
# Firmware 1.0.6 was seen to report braking for ever after a motion (riccardi-samuele/mks-servo,
# FAQ). At the lowest speed, 1 rpm, a count changes by 54 in this time.
STILL_S = 0.2

# A drive that reports one of these after a stop has not received it.
RUNNING = (MotorState.ACCELERATING, MotorState.FULL_SPEED, MotorState.HOMING)
TURNING = (*RUNNING, MotorState.DECELERATING)

# Two readings at least this far apart show that a drive stands, if it has not turned.
APART_S = 0.01
# A drive that accepts an order says "started" within this time of the "failed" it sends for the
# order that was replaced, before or after it.
START_WINDOW_S = 0.01


class MksDrive(ObservedDrive):
    """One drive of an arm, by its orders and its replies."""

    def __init__(self, node: int, name: str, settings: MksSettings) -> None:
        corridor = settings.following_error_counts
        bounds = Bounds(settings.in_position_counts, corridor, GIVE, COUNTS_PER_TURN)
        super().__init__(node, name, bounds)
        self.questions = self.ledger = Ledger()
        self.absence = self.ledger.absence
        self.late_readings = 0
        """How many readings came since the last one that was surely sampled within the allowed
        delay. Those that were asked for closer together than `POLL_SPACING_S` count as one."""
        self._late_s = -math.inf
        self.frame_s = -math.inf
        """When the last frame from it arrived, requested or not."""
        self.lag = 0.0
        """How far its orders were ahead of it at the last reading."""
        self.sent = Interval(0.0, 0.0)
        """The range of its targets since it stood last."""
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
        self.rejected_s = math.inf
        """When its last "failed" counts as a rejection; infinity if it accepts its orders.

        A moving drive reports "failed" for an order that a newer one replaces, and also for an
        order that it rejects; no bit tells the two apart. But next to the first it reports that the
        newer order has started.
        """
        self.two_zeros = ""
        """That its targets count from another place than its readings, in words."""

    # -- orders -------------------------------------------------------------------------------

    def watch(self) -> None:
        """Begin a motion: judge the drive from its last reading on."""
        super().watch()
        self.late_readings = 0
        self.rejected_s = math.inf
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
        self.absence.forget()
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

    def _restart_comparison(self, now_s: float) -> None:
        super()._restart_comparison(now_s)
        self.lag = 0.0

    # -- readings -----------------------------------------------------------------------------

    def read(self, count: int, now_s: float) -> None:
        """Record its count and conclude what that means."""
        self.absence.conclude(now_s)
        super().read(count, now_s)
        if now_s <= self.asked_s + self.bounds.late_s + EPSILON_S:
            self.late_readings = 0
        elif self.asked_s >= self._late_s + POLL_SPACING_S - EPSILON_S:
            self.late_readings, self._late_s = self.late_readings + 1, self.asked_s
        if self.is_within_reach:
            self.lag = self.place - count

    def _judge(self, reading: Reading, off: float) -> DriveFinding:
        away_s = self.absence.since_s
        if math.isfinite(away_s) and not self._reach.is_left:
            if self.counts_from_zero(away_s, reading.read_s):
                return DriveFinding.RESTARTED
            self.absence.acquit()  # its count proves that it kept its power
        return super()._judge(reading, off)

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
    def is_on_path(self) -> bool:
        """Whether its last count is between targets that it received."""
        return self.count in self.sent.widened(self.bounds.corridor)

    # -- messages -----------------------------------------------------------------------------

    def note(self, event: Answered, now_s: float) -> None:
        """Record what a message from it shows."""
        answer = event.answer
        if isinstance(answer, Status):
            self._note_status(answer, now_s)
            return
        if event.request is None:  # a late reading, which may be older than the last one
            if isinstance(answer, EncoderRead):
                self.ledger.located(now_s)
            return
        match answer:
            case EncoderRead(counts):
                self.read(counts, now_s)
            case StateRead(state):
                self.state = self._believed(state)
            case StallRead(on=True) | EnabledRead(on=False):
                self.unfit = True
            case SettingRead(Code.MODE) if not obeys_bus(setting_of(answer)):
                self.unfit = True
            case HomingRead(by_command=homing) if homing is not None:
                self.homing = homing

    def _note_status(self, status: Status, now_s: float) -> None:
        match status.code, status.outcome:
            case _, Outcome.STARTED:
                self.confirmed_s = now_s
                self.rejected_s = math.inf
            case Code.ABSOLUTE_AXIS, Outcome.FAILED:
                if now_s > self.confirmed_s + START_WINDOW_S:
                    self.rejected_s = min(self.rejected_s, now_s + START_WINDOW_S)
            case _, Outcome.LIMIT_STOP:
                self.at_limit = True
            case Code.HOME, Outcome.DONE:
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
