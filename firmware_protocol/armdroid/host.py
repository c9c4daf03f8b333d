"""The host's end of the Armdroid dialect: one command out, its answer in, no clock, no wire.

An answer is one line; the answer to a motion comes after its end. The board takes characters in
order and keeps those that come during a motion, so an answer tells that everything sent before it
is over. Lines that do not belong complete nothing: they become `Stray` (readable, but not the
answer that is awaited) or `Unreadable`. Nothing that the board sends raises.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.armdroid.messages import (
    ANSWER_TO,
    Answer,
    Clear,
    Command,
    DriveAll,
    DriveOne,
    DropArguments,
    SetSpeed,
    SpeedReported,
    Torque,
    TorqueReported,
    Welcome,
    ZeroOffsets,
)
from firmware_protocol.armdroid.wire import END, decode_answer, encode_command
from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.lines import AnswerLines, Dropped

LINE_BYTES = 80
"""The sketch's own buffer for a line; its longest answer has 51 characters."""

_CLEARING = (Clear, DriveOne, DriveAll, DropArguments, ZeroOffsets)


@dataclass(frozen=True, slots=True)
class Completed:
    """A command and its answer."""

    command: Command
    answer: Answer

    @property
    def as_asked(self) -> bool:
        """Whether the board has understood the number that it repeats.

        It has not where a left-over number was in its accumulator: send `Clear`, then again.
        """
        match self.command, self.answer:
            case SetSpeed(asked), SpeedReported(told):
                return asked == told
            case Torque(asked), TorqueReported(told):
                return asked == told
        return True


@dataclass(frozen=True, slots=True)
class Stray:
    """A readable answer that nobody awaits, for example the late one of a given-up command."""

    answer: Answer


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A line that is no answer, or one that had begun before the command was sent, and why."""

    data: bytes
    reason: str


Event: TypeAlias = Completed | Stray | Unreadable | Welcome


class Host:
    """The machine that speaks to the board. Raises `LocalProtocolError` for its owner's mistakes.

    It has no clock: it is the owner who gives up on an answer. It holds at most 256 lines of 80
    bytes and `MAX_EARLY` events.
    """

    def __init__(self) -> None:
        self._lines = AnswerLines[Event](END, self._interpret, max_length=LINE_BYTES)
        self._command: Command | None = None
        self._clean = False

    @property
    def outstanding(self) -> Command | None:
        """The command whose answer has not come yet."""
        return self._command

    @property
    def clean(self) -> bool:
        """Whether nothing half received can be left in the board, as far as is known.

        False at first and after `give_up`: then make the next command a `Clear`.
        """
        return self._clean

    @property
    def buffered(self) -> int:
        """How many received bytes are held."""
        return self._lines.buffered

    def send(self, command: Command) -> bytes:
        """Return the bytes that give a command to the board.

        Raises `LocalProtocolError` while another is unanswered, and for a `DropArguments` while
        the board may hold something half received. Lines that were received before this call,
        or had begun, are never taken for this command's answer.
        """
        if self._command is not None:
            raise LocalProtocolError(
                f"{type(self._command).__name__} is unanswered: wait for its Completed, or "
                f"give_up, before sending {type(command).__name__}"
            )
        if isinstance(command, DropArguments) and not self._clean:
            raise LocalProtocolError("numbers may be left in the board: send Clear before it")
        self._lines.keep_early()
        self._lines.mark_early()
        self._command = command
        return encode_command(command)

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the board, in any portions."""
        self._lines.feed(data)

    def next_event(self) -> Event | None:
        """Return what the bytes received so far say, one event at a time, then None."""
        return self._lines.next_event()

    def give_up(self) -> Command | None:
        """Forget the unanswered command, after a timeout, and return it.

        Its motion may still be under way, and its answer come later. Send `Version` next: the
        late answer is a `Stray` then, and the version's own answer tells that the board is
        through with all that was sent before.
        """
        command, self._command = self._command, None
        self._clean = False
        return command

    def discard(self) -> None:
        """Forget all bytes received and all events not fetched; the next byte begins a line.

        Meant for after a silence. The unanswered command stays unanswered.
        """
        self._lines.discard()

    def _interpret(self, line: bytes | Dropped, early: bool) -> Event:
        if isinstance(line, Dropped):
            return Unreadable(line.start, line.reason)
        if early:
            return Unreadable(line, "the line began before the command was sent")
        try:
            answer = decode_answer(line)
        except RemoteProtocolError as error:
            return Unreadable(line, str(error))
        return self._welcome() if isinstance(answer, Welcome) else self._accept(answer)

    def _accept(self, answer: Answer) -> Event:
        command = self._command
        if command is None or not isinstance(answer, ANSWER_TO[command.letter]):
            return Stray(answer)
        self._command = None
        self._clean = self._clean or isinstance(command, _CLEARING)
        return Completed(command, answer)

    def _welcome(self) -> Welcome:
        self._clean = self._clean or self._command is None
        return Welcome()
