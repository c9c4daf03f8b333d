"""Asking a GRBL board: a report, one line and its answer, a reset and its banner."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from types import UnionType
from typing import TypeAlias

from armdrive.dialects.exchange import ScriptIO
from armdrive.dialects.grbl.board import BoardState
from armdrive.dialects.grbl.settings import GrblSettings
from armdrive.tasks import Done, Reply, RequestRejected
from firmware_protocol.grbl import (
    Acknowledged,
    AlarmRaised,
    Command,
    Host,
    Line,
    Realtime,
    Refused,
    Restarted,
    State,
    StatusReported,
)
from firmware_protocol.grbl.host import Event as HostEvent

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


@dataclass(slots=True, eq=False)
class GrblExchange:
    """Says things to one board, and waits for what it answers.

    `wire_free_s` is when all that was said is through the wire, where a byte takes `byte_s`.
    """

    io: ScriptIO[HostEvent]
    host: Host
    board: BoardState
    settings: GrblSettings
    byte_s: float
    wire_free_s: float = -math.inf

    # -- saying -------------------------------------------------------------------------------

    def speak(self, command: Command) -> None:
        """Say a line."""
        self._say(self.host.send(command), command.text)

    def press(self, command: Realtime) -> None:
        """Say a real-time command."""
        shown = command.name.lower().replace("_", " ")
        if command is Realtime.STATUS:
            shown = ""
            self.board.polls.ask(self.io.now_s)
        self._say(self.host.send_realtime(command), shown)

    def _say(self, data: bytes, text: str) -> None:
        self.io.say(data, text)
        through_s = max(self.wire_free_s, self.io.now_s)
        self.wire_free_s = through_s + len(data) * self.byte_s

    def room_for(self, line: Line) -> bool:
        """Tell whether the board's ring has room for a line."""
        return self.host.room_for(line)

    def forget_lines(self) -> None:
        """Wait no longer for the answers to the lines that were said."""
        self.host.forget_outstanding()

    def give_up(self) -> None:
        """Forget unanswered lines, half a message and an awaited greeting."""
        self.forget_lines()
        self.host.discard()
        self.board.greeting.give_up()

    # -- hearing ------------------------------------------------------------------------------

    def take(self, heard: HostEvent) -> None:
        """Learn from anything that the board says, whoever waits for it."""
        event = self.board.learn(heard, self.io.now_s)
        if event is not None:
            self.io.tell(event)

    def listen(self, until_s: float) -> Generator[float, HostEvent | None, HostEvent | None]:
        """Wait for whatever comes next; None when the time is over or a stop is asked for."""
        heard = yield until_s
        if heard is not None:
            self.take(heard)
        return heard

    @property
    def mute_at_s(self) -> float:
        """When the board is called mute, unless it gives a report: `mute_s` after its last one.

        That came a poll before the first one that is unanswered. While nothing is asked, because
        this program stands still, say, a board is not mute.
        """
        return self.board.polls.since_s + self.settings.mute_s - self.settings.poll_s

    @property
    def mute(self) -> bool:
        """Tell whether the board has given no report for `mute_s`."""
        return self.io.now_s >= self.mute_at_s

    # -- asking -------------------------------------------------------------------------------

    def look(self, patience_s: float) -> Asking:
        """Ask for a report until one comes; False where none did. Moves nothing."""
        return self.sign_of_life(patience_s, LATE_REPORT_S, StatusReported)

    def sign_of_life(
        self, patience_s: float, every_s: float, wanted: type[HostEvent] | UnionType
    ) -> Asking:
        """Ask for a report every so often, until something wanted comes; False where none did."""
        end_s = self.io.now_s + patience_s
        while self.io.now_s < end_s:
            self.press(Realtime.STATUS)
            again_s = min(self.io.now_s + every_s, end_s)
            while self.io.now_s < again_s:
                heard = yield from self.listen(again_s)
                if isinstance(heard, wanted):
                    return True
        return False

    def look_position(self, patience_s: float) -> Asking:
        """Look until the machine position is known, which may need the work offset's report."""
        for _ in range(REPORTS_TO_OFFSET):
            if not (yield from self.look(patience_s)):
                return False
            if self.board.located:
                return True
        return False

    def read_position(self) -> Answering:
        """Return what the registers are, moving nothing."""
        began_s = self.io.now_s
        unanswered = self.board.polls.since_s < began_s
        share = 4.0 if unanswered else 2.0  # the driver asks three times
        if (yield from self.look_position(self.settings.mute_s / share)):
            return self.board.registers()
        if self.board.alarm is not None:
            return RequestRejected(self.board.alarm_words(), moved=False)
        return self.io.silence(began_s)

    def carry_out(self, command: Command, patience_s: float) -> Answering:
        """Say one line, and return whether the board has carried it out."""
        heard = yield from self.ask(command, patience_s)
        if isinstance(heard, Acknowledged):
            return Done()
        return refusal(heard, f"`{command.text}` was not carried out")

    def ask(
        self, command: Command, patience_s: float
    ) -> Generator[float, HostEvent | None, Answer | None]:
        """Say one line and wait for its answer, or for what ends the waiting; None is silence."""
        if not (yield from self.clean_line()):
            return None  # a board that answers no line at all answers none of ours
        answer = yield from self._ask(command, patience_s)
        self.board.polls.stray |= answer is None  # half of it may be in the board's line
        return answer

    def clean_line(self) -> Generator[float, HostEvent | None, bool]:
        """Rid the board's line of what a changed `?` or a half line of ours may have left there.

        False where the board answers no line at all.
        """
        return not self.board.polls.stray or (yield from self.spoil())

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
                yield from self.io.pause(self.io.now_s + LATE_REPORT_S)
            elif answer is not None:
                self.board.polls.stray = False
                return True
        return heard

    def _ask(
        self, command: Command, patience_s: float
    ) -> Generator[float, HostEvent | None, Answer | None]:
        self.forget_lines()
        self.speak(command)
        end_s = self.wire_free_s + patience_s
        while True:
            heard = yield from self.listen(end_s)
            if isinstance(heard, Acknowledged | Refused | Restarted | AlarmRaised):
                return heard
            if heard is None and self.io.now_s >= end_s:  # all that has come is read by now
                break
        self.forget_lines()
        return None

    def soft_reset(self, *, patient: bool = True, moving: bool = False) -> Asking:
        """Reset the board and wait for its banner; `aborted` tells whether that killed a motion.

        Only who is `patient` tries again where nothing at all is heard. What is `moving`, or may
        be, shall stand soon.
        """
        self.board.aborted = False
        for _ in range(RESETS):
            if (yield from self._reset(moving or self.board.in_motion)):
                return True
            self.forget_lines()  # the banner may have been garbled
            self.board.greeting.give_up()
            self.board.modes_set = False
            heard_of = yield from self.look(2.0 * LATE_REPORT_S)
            # one that is in a state without alarm has killed no motion; else its words may be lost
            free = isinstance(self.board.state, State) and self.board.state is not State.ALARM
            self.board.aborted = self.board.aborted or not (heard_of and free)
            if heard_of and self.board.state in (State.IDLE, State.ALARM):
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
        end_s = self.io.now_s + RESET_S
        asked_s = self.io.now_s
        while self.io.now_s < end_s:
            asking = moving and self.board.state is not State.ALARM
            if asking and self.io.now_s >= asked_s + RESET_POLL_S:
                self.press(Realtime.STATUS)
                asked_s = self.io.now_s
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
        asked_s = self.board.polls.since_s
        if moving:
            self.board.greeting.await_late()
        else:
            self.board.greeting.await_soon(max(self.io.now_s, self.wire_free_s), asked_s)
        self.press(Realtime.SOFT_RESET)
        return asked_s <= self.io.now_s


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
