"""Asking a GRBL board: a report, one line and its answer, a reset and its banner."""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeAlias

from armdrive.dialects.grbl.receive import GrblReceiving
from armdrive.tasks import Reply, RequestRejected
from firmware_protocol.grbl import (
    Acknowledged,
    AlarmRaised,
    Command,
    Line,
    Realtime,
    Refused,
    Restarted,
    State,
    StatusReported,
)
from firmware_protocol.grbl.events import Event as HostEvent

Asking: TypeAlias = Generator[float, HostEvent | None, bool]
Answering: TypeAlias = Generator[float, HostEvent | None, Reply]
Answer: TypeAlias = Acknowledged | Refused | Restarted | AlarmRaised

LATE_REPORT_S = 0.25
"""A report that has not come by then was lost."""
RESET_S = 1.5
"""A board says its banner within this after a reset; one that kills its motors waits 0.26 s."""
RESETS = 3
RESET_POLL_S = 0.02
"""How often a board in motion is asked whether its reset was lost: one that begins anew is mute."""
REPORTS_TO_OFFSET = 40
"""The work offset comes with one report in thirty at least."""
SPOILER = "))GG"
"""Ends what stands in the board's line, a half line or a stray character, so that no board carries
it out. The first bracket ends a comment. The second is no letter, which GRBL and grblHAL refuse;
FluidNC drops it, and all refuse a letter without a number (gnea/grbl grbl/protocol.c and gcode.c).
"""
SPOILERS = 3


class GrblTalk(GrblReceiving):
    """The questions."""

    @property
    def mute_at_s(self) -> float:
        """When the board is called mute, unless it gives a report: `mute_s` after its last one.

        That came a poll before the first one that is unanswered. While nothing is asked, because
        this program stands still, say, a board is not mute.
        """
        return self.polls.since_s + self.settings.mute_s - self.settings.poll_s

    @property
    def mute(self) -> bool:
        """Tell whether the board has given no report for `mute_s`."""
        return self.now_s >= self.mute_at_s

    def look(self, patience_s: float) -> Asking:
        """Ask for a report until one comes; False where none did. Moves nothing."""
        end_s = self.now_s + patience_s
        while self.now_s < end_s:
            self.press(Realtime.STATUS)
            again_s = min(self.now_s + LATE_REPORT_S, end_s)
            while self.now_s < again_s:
                heard = yield from self.listen(again_s)
                if isinstance(heard, StatusReported):
                    return True
        return False

    def look_position(self, patience_s: float) -> Asking:
        """Look until the machine position is known, which may need the work offset's report."""
        for _ in range(REPORTS_TO_OFFSET):
            if not (yield from self.look(patience_s)):
                return False
            if self.reported is not None and self.reported.machine_position is not None:
                return True
        return False

    def ask(
        self, command: Command, patience_s: float
    ) -> Generator[float, HostEvent | None, Answer | None]:
        """Say one line and wait for its answer, or for what ends the waiting; None is silence."""
        if not (yield from self.clean_line()):
            return None  # a board that answers no line at all answers none of ours
        answer = yield from self._ask(command, patience_s)
        self.polls.stray |= answer is None  # half of it may be in the board's line
        return answer

    def clean_line(self) -> Generator[float, HostEvent | None, bool]:
        """Rid the board's line of what a changed `?` or a half line of ours may have left there.

        False where the board answers no line at all.
        """
        return not self.polls.stray or (yield from self.spoil())

    def spoil(self) -> Generator[float, HostEvent | None, bool]:
        """End whatever stands in the board's line, until the board has refused it.

        An ok is that of a comment, or one that comes late: nothing may be late when we go on. False
        where nothing was answered.
        """
        heard = False
        for _ in range(SPOILERS):
            answer = yield from self._ask(Line(SPOILER), self.settings.answer_s)
            heard |= answer is not None
            if isinstance(answer, Acknowledged):
                yield from self.pause(self.now_s + LATE_REPORT_S)
            elif answer is not None:
                self.polls.stray = False
                return True
        return heard

    def _ask(
        self, command: Command, patience_s: float
    ) -> Generator[float, HostEvent | None, Answer | None]:
        self._host.forget_outstanding()
        self.speak(command)
        end_s = self.wire_free_s + patience_s
        while True:
            heard = yield from self.listen(end_s)
            if isinstance(heard, Acknowledged | Refused | Restarted | AlarmRaised):
                return heard
            if heard is None and self.now_s >= end_s:  # all that has come is read by now
                break
        self._host.forget_outstanding()
        return None

    def soft_reset(self, *, patient: bool = True, moving: bool = False) -> Asking:
        """Reset the board and wait for its banner; `aborted` tells whether that killed a motion.

        Only who is `patient` tries again where nothing at all is heard. What is `moving`, or may
        be, shall stand soon.
        """
        self.aborted = False
        for _ in range(RESETS):
            if (yield from self._reset(moving or self.in_motion)):
                return True
            self._host.forget_outstanding()  # the banner may have been garbled
            self.greeting.give_up()
            self.modes_set = False
            heard_of = yield from self.look(2.0 * LATE_REPORT_S)
            # one that is in a state without alarm has killed no motion; else its words may be lost
            free = isinstance(self.state, State) and self.state is not State.ALARM
            self.aborted = self.aborted or not (heard_of and free)
            if heard_of and self.state in (State.IDLE, State.ALARM):
                return True  # else it was the reset that was lost
            if not heard_of and not patient:
                break
        return False

    def _reset(self, moving: bool) -> Asking:
        """Press the reset and wait for the banner; False where none comes.

        What a board that begins anew is asked, it does not answer. So any report but one that was
        under way says that the reset was lost, and it is pressed again. A second one in the same
        reset has no effect (gnea/grbl grbl/motion_control.c). A board that stands is not asked: in
        its loader, after its button, that could make it greet as soon as after our own reset.
        """
        stale = self._press_reset(moving)
        end_s = self.now_s + RESET_S
        asked_s = self.now_s
        while self.now_s < end_s:
            asking = moving and self.state is not State.ALARM
            if asking and self.now_s >= asked_s + RESET_POLL_S:
                self.press(Realtime.STATUS)
                asked_s = self.now_s
            heard = yield from self.listen(min(end_s, asked_s + RESET_POLL_S) if asking else end_s)
            if isinstance(heard, Restarted):
                return True
            if isinstance(heard, StatusReported):
                if asking and not stale:
                    self._press_reset(moving)
                stale = False
        return False

    def _press_reset(self, moving: bool) -> bool:
        """Press the reset; tell whether a report may be under way that was asked for before it."""
        asked_s = self.polls.since_s
        if moving:
            self.greeting.await_late()
        else:
            self.greeting.await_soon(max(self.now_s, self.wire_free_s), asked_s)
        self.press(Realtime.SOFT_RESET)
        return asked_s <= self.now_s


def refusal(heard: HostEvent | None, what: str, *, moved: bool = False) -> RequestRejected:
    """Return the reply that says why a line was not carried out."""
    match heard:
        case Refused(_, code, meaning, remedy):
            number = "" if code is None else f"error {code}, "
            return RequestRejected(f"{what}: {number}{meaning}; {remedy}", moved)
        case AlarmRaised(_, meaning, remedy):
            return RequestRejected(
                f"{what}: the board went into alarm ({meaning}); {remedy}", moved
            )
        case Restarted():
            return RequestRejected(f"{what}: the board was reset or lost its power", moved)
    return RequestRejected(f"{what}: the board did not answer", moved)
