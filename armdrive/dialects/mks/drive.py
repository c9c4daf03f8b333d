"""One MKS drive: its last order, and what its messages show apart from its position."""

from __future__ import annotations

import math
from typing import TypeAlias

from armdrive.dialects.bus.intervals import Bounds
from armdrive.dialects.mks.polled import PolledDrive
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


START_WINDOW_S = 0.01
"""A drive that accepts an order says "started" within this time of the "failed" it sends for the
order that was replaced, before or after it."""
REJECTION_LIMIT = 2
"""A drive is examined after this many rejections in a row. After a single one, its "started" may
have been lost."""


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


class MksDrive(PolledDrive):
    """One drive of an arm."""

    def __init__(self, node: int, name: str, settings: MksSettings) -> None:
        corridor = settings.following_error_counts
        bounds = Bounds(settings.in_position_counts, corridor, GIVE, COUNTS_PER_TURN)
        super().__init__(node, name, bounds)
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

    def stop(self, now_s: float) -> None:
        """Record a stop: its last order must not be sent again."""
        self.last_order = None
        super().stop(now_s)

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
