"""Exchanges with a GRBL board: a query and its report, a line and its answer, a reset.

Every message passes through `listen` (or `take`, if no script waits), which updates `BoardState`.

A query is a single byte that a board picks out of its input. If it is damaged on the wire, the
board keeps it as a character, which would spoil the next line or even change its meaning. So `ask`
sends an empty line before each line. Reports have no checksum either: a surprising one counts only
if the next one agrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import UnionType
from typing import TypeAlias

from armdrive.dialects.exchange import TRIES, Script, ScriptIO
from armdrive.dialects.grbl.board import HELD, OWN_RESET_S, BoardState
from armdrive.dialects.grbl.settings import GrblSettings
from armdrive.tasks import Done, Reply, RequestRejected
from firmware_protocol.fields import in_words
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
    StatusReport,
)
from firmware_protocol.grbl.host import Event as HostEvent

Answer: TypeAlias = Acknowledged | Refused | Restarted | AlarmRaised

# A report that takes longer counts as lost: boards that do not home or start answer within
# milliseconds.
REPORT_TIMEOUT_S = 0.25
# Interval of queries in motion.
POLL_S = 0.05
# Timeout for the banner after a reset; a board that stops its motors waits 0.26 s first.
BANNER_TIMEOUT_S = 1.5
# A reset in motion that is not answered within this time is sent once more.
RESET_AGAIN_S = 0.02
# Completes whatever is in the board's input line, a half line or a stray character, so that every
# board refuses it. The first bracket ends a comment. GRBL refuses the second one, which is not a
# letter; grblHAL and FluidNC drop it. All refuse a letter without a number (gnea/grbl
# grbl/protocol.c and gcode.c).
FLUSH_LINE = Line("))GG")
# Ends the echo of a FluidNC board that has heard a control character, from a terminal program or
# by a damaged byte (FluidNC lineedit.cpp). The others ignore it.
ECHO_OFF = b"\f"


@dataclass(slots=True, eq=False)
class GrblExchange:
    """Sends lines and real-time commands to one board, and waits for the answers.

    `wire_free_s` is the time when the wire will have carried everything sent so far; a byte takes
    `byte_s`. `asked_s` is when the latest status query was sent, and `unanswered_s` the oldest one
    without a report; infinity if there is none.
    """

    io: ScriptIO[HostEvent]
    host: Host
    board: BoardState
    settings: GrblSettings
    byte_s: float
    wire_free_s: float = -math.inf
    asked_s: float = -math.inf
    unanswered_s: float = math.inf

    # -- sending ------------------------------------------------------------------------------

    def send(self, command: Command) -> None:
        """Send a line."""
        self._write(self.host.send(command), command.text)

    def send_realtime(self, command: Realtime) -> None:
        """Send a real-time command."""
        shown = in_words(command)
        if command is Realtime.STATUS:
            shown, self.asked_s = "", self.io.now_s
            self.unanswered_s = min(self.unanswered_s, self.io.now_s)
        self._write(self.host.send_realtime(command), shown)

    def _write(self, data: bytes, text: str) -> None:
        self.io.write(data, text)
        self.wire_free_s = max(self.wire_free_s, self.io.now_s) + len(data) * self.byte_s

    def end_echo(self) -> None:
        """End an echo that someone at a terminal has switched on."""
        self.io.write(ECHO_OFF, "")

    def give_up(self) -> None:
        """Forget unanswered lines, a half-received message and an awaited greeting."""
        self.host.forget_outstanding()
        self.host.discard()
        self.board.reset_sent(-math.inf, moving=False)

    # -- receiving ----------------------------------------------------------------------------

    def take(self, message: HostEvent) -> None:
        """Update the board's state from a message, and report any event to the engine."""
        if isinstance(message, StatusReport | Restarted):
            self.unanswered_s = math.inf
        event = self.board.learn(message, self.io.now_s)
        if event is not None:
            self.io.notify(event)

    def listen(self, until_s: float) -> Script[HostEvent, HostEvent | None]:
        """Wait for the next message; return None at the deadline or when a stop is requested."""
        message = yield until_s
        if message is not None:
            self.take(message)
        return message

    @property
    def mute_at_s(self) -> float:
        """When a board without a report counts as mute: `report_timeout_s` after its last one.

        That report came one poll interval before the oldest unanswered query. While there is no
        unanswered query, for example because this program was suspended, no board is mute.
        """
        return self.unanswered_s + self.settings.report_timeout_s - POLL_S

    @property
    def mute(self) -> bool:
        """Whether the board has sent no report for `report_timeout_s`."""
        return self.io.now_s >= self.mute_at_s

    @property
    def poll_due_s(self) -> float:
        """When to query next, to hear of the board every `POLL_S`; a lost query is repeated."""
        lost = self.unanswered_s < math.inf
        return self.asked_s + (REPORT_TIMEOUT_S if lost else POLL_S)

    def poll(self) -> None:
        """Query if it is time."""
        if self.io.now_s >= self.poll_due_s:
            self.send_realtime(Realtime.STATUS)

    # -- asking -------------------------------------------------------------------------------

    # A `patience_s` that is not given is the arm file's `answer_s`.

    def look(self, patience_s: float | None = None) -> Script[HostEvent, bool]:
        """Query until a report arrives; return False at the timeout. Moves nothing."""
        patience_s = self.settings.answer_s if patience_s is None else patience_s
        return self.sign_of_life(patience_s, REPORT_TIMEOUT_S, StatusReport)

    def sign_of_life(
        self, patience_s: float, every_s: float, wanted: type[HostEvent] | UnionType
    ) -> Script[HostEvent, bool]:
        """Query every `every_s` until a wanted message arrives; return False at the timeout."""
        end_s = self.io.now_s + patience_s
        while self.io.now_s < end_s:
            self.send_realtime(Realtime.STATUS)
            again_s = min(self.io.now_s + every_s, end_s)
            while self.io.now_s < again_s:
                message = yield from self.listen(again_s)
                if isinstance(message, wanted):
                    return True
        self.io.last_command = "?"
        return False

    def confirm_position(self) -> Script[HostEvent, bool]:
        """Query until a report repeats what was known before it.

        A report has no checksum, so a surprising one counts only when it is repeated. Return False
        if the position remains unknown.
        """
        board = self.board
        for _ in range(TRIES):
            known = board.state, board.position, board.free_blocks
            if not (yield from self.look()):
                return False
            if known == (board.state, board.position, board.free_blocks):
                break
        return board.position is not None

    def read_position(self) -> Script[HostEvent, Reply]:
        """Read the motor positions. Moves nothing."""
        began_s = self.io.now_s
        # the driver asks three times, and together the attempts must not take long
        share = 2.0 if math.isinf(self.unanswered_s) else 4.0  # a mute board already gets less
        if (yield from self.look(self.settings.report_timeout_s / share)):
            if self.board.position is None:
                return RequestRejected("its reports lack the machine position: send `$10=3`", False)
            return self.board.registers()
        if self.board.alarm is not None:
            return RequestRejected(self.board.alarm_words(), moved=False)
        return self.io.silence(began_s)

    def carry_out(
        self, command: Command, patience_s: float | None = None
    ) -> Script[HostEvent, Reply]:
        """Send one line; return `Done`, or the reason why the board did not carry it out."""
        message = yield from self.ask(command, patience_s)
        if isinstance(message, Acknowledged):
            return Done()
        return refusal(message, f"`{command.text}` was not carried out")

    def ask(
        self, command: Command, patience_s: float | None = None
    ) -> Script[HostEvent, Answer | None]:
        """Send one line and return its answer, an alarm or a restart; None at the timeout.

        If only its end was lost, the next line's empty one completes it. So no motion is sent here.
        """
        if not (yield from self.clear_line()):
            return None  # the board answers no line at all
        return (yield from self._one_line(command, patience_s))

    def clear_line(self) -> Script[HostEvent, bool]:
        """Clear the input line of stray characters; return False if nothing is answered.

        It goes ahead of every line that is no motion, and so of every motion's first one. For
        grblHAL refuses all g-code after a refused line, until an empty one (protocol.c).
        """
        answer = yield from self._one_line(Line())
        if isinstance(answer, Refused):
            answer = yield from self._one_line(Line())
        return answer is not None

    def flush_line(self) -> Script[HostEvent, bool]:
        """Clear the input line by one that is refused; return False if nothing was answered.

        An ok means that the line ended in a comment, or belongs to an earlier line and is late. No
        answer may be outstanding afterwards, so wait a while and try again.
        """
        answered = False
        for _ in range(TRIES):
            answer = yield from self._one_line(FLUSH_LINE)
            answered |= answer is not None
            if isinstance(answer, Acknowledged):
                yield from self.io.pause(self.io.now_s + self.settings.answer_s)
            elif answer is not None:
                break
        return answered

    def _one_line(
        self, command: Command, patience_s: float | None = None
    ) -> Script[HostEvent, Answer | None]:
        # the line is the only one on its way: GRBL loses bytes while it writes its EEPROM, and an
        # answer to an earlier line must not count for this one
        self.host.forget_outstanding()
        self.send(command)
        patience_s = self.settings.answer_s if patience_s is None else patience_s
        end_s = self.wire_free_s + patience_s
        while True:
            message = yield from self.listen(end_s)
            if isinstance(message, Answer):
                return message
            if message is None and self.io.now_s >= end_s:  # everything received has been read
                self.host.forget_outstanding()
                return None

    # -- resetting ----------------------------------------------------------------------------

    def soft_reset(self, *, patient: bool = True, moving: bool = False) -> Script[HostEvent, bool]:
        """Reset the board and wait for its banner.

        `board.aborted` records whether that ended a motion. If the board does not answer at all,
        only a `patient` caller tries again. `moving` means that the board may be in motion and must
        stop soon, even if one reset is lost.
        """
        board = self.board
        board.aborted = False
        if board.behaviour.keeps_line and board.state in HELD and not moving:
            # A reset out of a hold releases the line that the board has read, and it would move the
            # arm. After a feed hold that follows at once, the line is planned at most, and the next
            # reset drops it. Both orders were seen on FluidNC 4.0.5.
            yield from self._reset(moving=False, then=Realtime.FEED_HOLD)
            if board.aborted:  # the board had restarted already
                return True
        for _ in range(TRIES):
            if (yield from self._reset(moving=moving or board.in_motion)):
                return True
            self.give_up()  # the banner may have been garbled
            reported = yield from self.look(2.0 * REPORT_TIMEOUT_S)
            if reported and board.state in (State.IDLE, State.ALARM):
                # only the banner was lost, and perhaps the alarm that says that a motion has ended;
                # in any other state, the reset was
                board.aborted |= board.state is State.ALARM
                return True
            if not (reported or patient):
                break
        return False

    def _reset(self, *, moving: bool, then: Realtime | None = None) -> Script[HostEvent, bool]:
        """Send the reset and wait for the banner; return False if none arrives.

        A board in motion must stop soon, and the reset may be lost. So it is sent once more unless
        the board answers with its alarm or its banner. If the first one arrived, the second has no
        effect (gnea/grbl grbl/motion_control.c), or the board restarts again (`board.AGAIN_S`).
        A board at rest gets no second one: if its button was pressed, a byte could end its boot
        loader early, and its greeting would come as soon as after our own reset.
        """
        self._send_reset(moving)
        if then is not None:
            self.send_realtime(then)
        again_s, end_s = self.io.now_s + RESET_AGAIN_S, self.io.now_s + BANNER_TIMEOUT_S
        again = moving
        while self.io.now_s < end_s:
            message = yield from self.listen(again_s if again else end_s)
            if isinstance(message, Restarted):
                return True
            again = again and not isinstance(message, AlarmRaised)
            if again and self.io.now_s >= again_s:
                self._send_reset(moving)
                again = False
        return False

    def _send_reset(self, moving: bool) -> None:
        """Send a reset; a board that has been mute may have restarted by itself already."""
        sent_s = max(self.io.now_s, self.wire_free_s)
        recent = self.unanswered_s > sent_s - OWN_RESET_S
        self.board.reset_sent(sent_s + OWN_RESET_S if recent else -math.inf, moving=moving)
        self.send_realtime(Realtime.SOFT_RESET)


def refusal(message: HostEvent | None, what: str, *, moved: bool = False) -> RequestRejected:
    """Return the rejection that says why a line was not carried out."""
    match message:
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
