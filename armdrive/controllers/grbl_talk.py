"""Asking a GRBL board: a report, one line and its answer, a reset and its banner."""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeAlias

from armdrive.controllers.grbl_hearing import GrblHearing
from armdrive.controllers.requests import Denied, Reply
from firmware_protocol.grbl import (
    Acknowledged,
    AlarmRaised,
    Command,
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
REPORTS_TO_OFFSET = 40
"""The work offset comes with one report in thirty at least."""


class GrblTalk(GrblHearing):
    """The questions."""

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

    def look_position(self) -> Asking:
        """Look until the machine position is known, which may need the work offset's report."""
        for _ in range(REPORTS_TO_OFFSET):
            if not (yield from self.look(self.settings.answer_s)):
                return False
            if self.reported is not None and self.reported.machine_position is not None:
                return True
        return False

    def ask(
        self, command: Command, patience_s: float
    ) -> Generator[
        float, HostEvent | None, Acknowledged | Refused | Restarted | AlarmRaised | None
    ]:
        """Say one line and wait for its answer, or for what ends the waiting; None is silence."""
        self._host.forget_outstanding()
        self.speak(command)
        end_s = self.wire_free_s + patience_s
        while self.now_s < end_s:
            heard = yield from self.listen(end_s)
            if isinstance(heard, Acknowledged | Refused | Restarted | AlarmRaised):
                return heard
        self._host.forget_outstanding()
        return None

    def soft_reset(self) -> Asking:
        """Reset the board and wait for its banner; `aborted` tells whether that killed a motion."""
        self.aborted = False
        for _ in range(RESETS):
            self._resetting = True
            self.press(Realtime.SOFT_RESET)
            end_s = self.now_s + RESET_S
            while self.now_s < end_s:
                heard = yield from self.listen(end_s)
                if isinstance(heard, Restarted):
                    return True
            self._host.forget_outstanding()  # the banner may have been garbled
            self._resetting = False
            self.modes_set = False
            heard_of = yield from self.look(2.0 * LATE_REPORT_S)
            # one that is in a state without alarm has killed no motion; else its words may be lost
            free = isinstance(self.state, State) and self.state is not State.ALARM
            self.aborted = self.aborted or not (heard_of and free)
            if heard_of and self.state in (State.IDLE, State.ALARM):
                return True  # else it was the reset that was lost
        return False


def refusal(heard: HostEvent | None, what: str, *, moved: bool = False) -> Denied:
    """Return the reply that says why a line was not carried out."""
    match heard:
        case Refused(_, code, meaning, remedy):
            number = "" if code is None else f"error {code}, "
            return Denied(f"{what}: {number}{meaning}; {remedy}", moved)
        case AlarmRaised(_, meaning, remedy):
            return Denied(f"{what}: the board went into alarm ({meaning}); {remedy}", moved)
        case Restarted():
            return Denied(f"{what}: the board was reset or lost its power", moved)
    return Denied(f"{what}: the board did not answer", moved)
