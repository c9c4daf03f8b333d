"""One MKS drive: its orders, what it has answered, and where it is by both. Counts, seconds.

A drive tells its position only when it is asked, and a reply names no question. Replies come in the
order of the questions, so a position was sampled at some moment since its question was sent.
"""

from __future__ import annotations

import math
from collections import deque

from armdrive.dialects.mks.settings import MksSettings
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    COUNTS_S_PER_RPM,
    Answer,
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

# A silent drive is asked again after this time, or twice its usual reply time: so that one that
# restarts, which takes 0.15 s, leaves at least `OWED_LIMIT` questions unanswered.
RETRY_S = 0.01
# A drive that leaves this many questions in a row unanswered may have lost its power. On a bus that
# loses one frame in ten, a sound drive does so once in 750 questions.
OWED_LIMIT = 4
# How often a drive is asked that owes replies.
OWING_S = 0.1
# Late replies are waited for this long: drives get no targets meanwhile, and stand after 0.3 s. The
# slowest reply that was observed, on an overloaded computer, took 0.18 s.
LATE_REPLY_S = 1.0
# A drive that accepts an order says "started" within this time of the "failed" it sends for the
# order that was replaced, before or after it.
START_WINDOW_S = 0.01
# How many counts a loaded shaft may give way while its position loop still holds it.
GIVE = COUNTS_PER_TURN // 32
# How much faster than ordered a sound drive may turn. Real MKS drives ordered to 2400 to 3000 rpm
# turned 0.8 % faster (riccardi-samuele/mks-servo-cpp, setup guide).
SPEED_ERROR = 1.05
# How far a drive that has just restarted may have turned.
JUST_BEGUN = 1000
# How much of the slowest reply's time counts at the next reply.
FADING = 0.8
# A drive that counts more than this has not restarted.
NEAR_ZERO = 2 * COUNTS_PER_TURN
# Step of the dead reckoning.
STEP_S = 0.005
# How far the reckoned place moves towards a reading, as a share of their distance.
CORRECTION_GAIN = 0.3
# Only a reply that is as prompt as this tells where the drive is now.
PROMPT_REPLY_S = 0.03


class OpenQuestions:
    """The questions about a drive's position that it has not answered.

    Deadlines are in listened time (`ListenedTime`): a program that was suspended misses nothing.
    """

    def __init__(self) -> None:
        self.asked_s = -math.inf
        """When the last question was sent."""
        self.usual_s = 0.0
        """How long its latest reply took."""
        self.slow_s = 0.0
        """How long the slowest of its latest replies took: its orders may be as late."""
        self._open: deque[tuple[float, float]] = deque(maxlen=256)
        self._owes_since_s = math.inf

    def ask(self, now_s: float, listened_s: float) -> None:
        """Record a question."""
        self._open.append((now_s, listened_s))
        self.asked_s = now_s
        if len(self._open) >= OWED_LIMIT:
            self._owes_since_s = min(self._owes_since_s, listened_s)

    def answer(self, now_s: float, listened_s: float) -> float:
        """Record a reply; return the earliest moment at which it can be sampled."""
        if not self._open:
            return now_s - LATE_REPLY_S
        asked_s, asked_listened_s = self._open.popleft()
        waited_s = listened_s - asked_listened_s
        self.slow_s = max(waited_s, FADING * self.slow_s)
        if len(self._open) < OWED_LIMIT:  # the others were lost, or their replies are late
            self.usual_s = waited_s
            self.clear()
        return asked_s

    def clear(self) -> None:
        """Wait for no reply any more."""
        self._open.clear()
        self._owes_since_s = math.inf

    def next_s(self, period_s: float) -> float:
        """Return when to ask again: after a period, sooner if a reply is missing.

        Not if it owes many: on a link that has become slow, its replies are all under way.
        """
        if self.owes:
            return self.asked_s + max(period_s, OWING_S)
        return self.asked_s + (max(RETRY_S, 2.0 * self.usual_s) if self._open else period_s)

    @property
    def owes(self) -> bool:
        """Whether so many replies are missing that the drive may have lost its power."""
        return math.isfinite(self._owes_since_s)

    def lost(self, listened_s: float, patience_s: float = LATE_REPLY_S) -> bool:
        """Return whether the missing replies will not come any more."""
        return listened_s > self._owes_since_s + patience_s


class MksDrive:
    """One drive of an arm. `place` and `speed` are reckoned from its orders and its readings."""

    def __init__(self, node: int, name: str, settings: MksSettings) -> None:
        self.node, self.name = node, name
        self.rest = settings.in_position_counts
        """How far from its target a drive that holds may be."""
        self.questions = OpenQuestions()
        self.count = 0
        """Its last reading."""
        self.read_s = -math.inf
        """When its last reading came."""
        self.asked_s = -math.inf
        """The earliest moment at which that can have been sampled."""
        self.still_s = math.inf
        """When the first of its latest readings came that all found it in one place."""
        self._still = 0
        self.target = 0
        """Its last target, or where it stands."""
        self.order: MoveAbsoluteAxis | None = None
        """Its last order; None if it stands."""
        self.homes = False
        self.fresh = False
        """Whether it has had no target since it was found standing."""
        self.place, self.speed, self._reckoned_s = 0.0, 0.0, -math.inf
        self.state: MotorState | None = None
        self.homing: HomingState | None = None
        """Its motor state and homing state as last reported since they were cleared."""
        self.started_s, self.rejected_s = -math.inf, math.inf
        """When it last reported that an order has started, and when its last "failed" counts as a
        rejection: an order that a newer one replaces fails as well, but next to the start of that.
        """
        self.unfit = self.at_limit = False
        """Whether it has reported since the motion began that it cannot move, and that a limit
        switch has stopped it."""
        self.doubts, self._doubted_s = 0, -math.inf
        """How many readings in a row found it where it should not be."""
        self.fit, self._fit_s = 0, -math.inf
        """The last count at which it was where it should be, and when that was asked for."""
        self._top = 0.0  # its greatest speed since the motion began
        self.two_zeros = ""
        """That its targets count from another place than its readings, in words."""

    def __str__(self) -> str:
        return f"drive {self.node} ({self.name})"

    @property
    def moving(self) -> bool:
        """Whether it was sent somewhere and was not seen to stand since."""
        return self.order is not None or self.homes

    # -- orders -------------------------------------------------------------------------------

    def begin(self) -> None:
        """Prepare for a motion: forget what was reported before."""
        self.questions.clear()
        self.doubts, self.rejected_s = 0, math.inf
        self.unfit = self.at_limit = False
        self.fit, self._fit_s, self._top = self.count, self.asked_s, 0.0

    def follow(self, order: MoveAbsoluteAxis, now_s: float) -> None:
        """Record that it was sent an order."""
        self.reckon(now_s)
        self.order, self.target = order, order.counts
        self.fresh = False
        self._top = max(self._top, order.speed_rpm * COUNTS_S_PER_RPM)

    def stand(self, now_s: float, *, stopped: bool = False) -> None:
        """Record that it stands: at its target, if it is near there, since encoders tremble.

        One that was `stopped` stands where it was read.
        """
        at = self.target if self.is_near and not stopped else self.count
        self.target = self.fit = at
        self.place, self.speed, self._reckoned_s = float(at), 0.0, now_s
        self.order, self.homes = None, False

    def reckon(self, now_s: float) -> None:
        """Advance its place to the present: it turns to its target by the order's ramp."""
        while self.order is not None and self._reckoned_s < now_s - 1e-9:
            step_s = min(STEP_S, now_s - self._reckoned_s)
            left = self.target - self.place
            # an immediate ramp takes one step
            slope = min(slope_of(self.order.acc), 1e9)
            top = min(self.order.speed_rpm * COUNTS_S_PER_RPM, math.sqrt(2.0 * slope * abs(left)))
            change, before = slope * step_s, self.speed
            self.speed += min(max(math.copysign(top, left) - before, -change), change)
            self.place += (before + self.speed) / 2.0 * step_s
            self._reckoned_s += step_s
            if abs(self.target - self.place) <= abs(self.speed) * step_s and abs(before) <= change:
                self.place, self.speed = float(self.target), 0.0
            if self.place == self.target and not self.speed:
                break
        self._reckoned_s = now_s

    # -- answers ------------------------------------------------------------------------------

    def note(self, answer: Answer, now_s: float, listened_s: float) -> None:
        """Record an answer, expected or not."""
        match answer:
            case EncoderRead(count):
                self._locate(count, now_s, listened_s)
            case StateRead(state):
                self.state = state
            case HomingRead(_, HomingState() as state):  # before 1.0.7 there is only the first
                self.homing = state
            case StallRead(on=True) | EnabledRead(on=False):
                self.unfit = True
            case SettingRead(code=Code.MODE):
                self.unfit = self.unfit or not obeys_bus(setting_of(answer))
            case Status():
                self._note_status(answer, now_s)

    def _note_status(self, status: Status, now_s: float) -> None:
        match status.code, status.outcome:
            case _, Outcome.STARTED:
                self.started_s, self.rejected_s = now_s, math.inf
            case Code.ABSOLUTE_AXIS, Outcome.FAILED if now_s > self.started_s + START_WINDOW_S:
                self.rejected_s = min(self.rejected_s, now_s + START_WINDOW_S)
            case _, Outcome.LIMIT_STOP:
                self.at_limit = True
            case Code.HOME, Outcome.DONE:
                self.homing, self.state = HomingState.DONE, MotorState.STOPPED

    def _locate(self, count: int, now_s: float, listened_s: float) -> None:
        self.asked_s = self.questions.answer(now_s, listened_s)
        self.count, self.read_s = count, now_s
        if self.is_far:
            self.questions.clear()  # it has not restarted
        if math.isinf(self.still_s) or abs(count - self._still) > self.rest // 4 + 1:
            self._still, self.still_s = count, now_s
        if self.order is not None and now_s <= self.asked_s + PROMPT_REPLY_S:
            self.reckon(now_s)
            here = count + self.speed * (now_s - self.asked_s) / 2.0
            self.place += CORRECTION_GAIN * (here - self.place)

    def judge(self, low: float, high: float) -> bool:
        """Judge the last reading by where the drive can be; return whether it is elsewhere.

        It cannot have turned faster than ordered. Only a second reading, asked for after the first,
        is a proof.
        """
        reach = SPEED_ERROR * self._top * (self.read_s - self._fit_s) + GIVE
        if low <= self.count <= high and abs(self.count - self.fit) <= reach:
            self.doubts, self.fit, self._fit_s = 0, self.count, self.asked_s
        elif not self.doubts or self.asked_s >= self._doubted_s:
            self.doubts, self._doubted_s = self.doubts + 1, self.read_s
        return self.doubts > 1

    def stands(self, since_s: float, for_s: float) -> bool:
        """Return whether its readings since a moment found it in one place for a time."""
        return self.asked_s >= max(self.still_s, since_s) + for_s

    # -- positions ----------------------------------------------------------------------------

    @property
    def is_located(self) -> bool:
        """Whether its position was ever read."""
        return math.isfinite(self.read_s)

    @property
    def is_far(self) -> bool:
        """Whether it counts more than one that has just restarted."""
        return abs(self.count) > NEAR_ZERO

    @property
    def is_near(self) -> bool:
        """Whether its last count is at its target."""
        return abs(self.count - self.target) <= self.rest

    @property
    def restarted(self) -> bool:
        """Whether its last count is that of a drive that has just restarted.

        Some encoders know their angle within a turn and begin to count there.
        """
        low, high = sorted((self.fit, self.target))
        give = self.rest if low == high else JUST_BEGUN
        on_its_way = low - give <= self.count <= high + give
        return not on_its_way and -JUST_BEGUN <= self.count <= COUNTS_PER_TURN + JUST_BEGUN

    @property
    def register(self) -> int:
        """Its count; that of its target if it stands there, since a position loop trembles."""
        return self.target if not self.moving and self.is_near else self.count

    def found_near(self, there: int) -> int:
        """Return where it stands: where it was left, if it was found near there."""
        if self.fresh and abs(self.target - there) <= self.rest:
            self.target, self.place = there, float(there)
        return self.target


def setting_of(answer: Answer | None) -> Setting | None:
    """Return the setting in an answer; None if the drive reported none, or an unknown one."""
    try:
        return as_setting(answer) if isinstance(answer, SettingRead) else None
    except RemoteProtocolError:
        return None


def obeys_bus(setting: Setting | None) -> bool:
    """Return whether the bus can move a drive in this mode; True if the mode is not known."""
    return not isinstance(setting, SetMode) or setting.mode.on_bus
