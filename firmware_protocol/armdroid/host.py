"""The host's end of the Armdroid dialect: one command out, its answer in, no clock, no I/O.

An answer is one line; the answer to a motion comes after the motion's end. The board processes
characters in order and queues those that arrive during a motion, so an answer shows that every
earlier command is done. Other lines become `Stray` (readable, but not the expected answer) or
`Unreadable`. No input from the board raises.
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
from firmware_protocol.armdroid.messages import END, decode_answer, encode_command
from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.lines import AnswerLines, Dropped

LINE_BYTES = 80  # the sketch's own line buffer; its longest answer has 51 characters

_CLEARING = (Clear, DriveOne, DriveAll, DropArguments, ZeroOffsets)


@dataclass(frozen=True, slots=True)
class Completed:
    """A command and its answer."""

    command: Command
    answer: Answer

    @property
    def as_asked(self) -> bool:
        """Whether the number in the answer is the number in the command.

        If not, the board's accumulator held a left-over number: send `Clear`, then the command.
        """
        match self.command, self.answer:
            case SetSpeed(asked), SpeedReported(told):
                return asked == told
            case Torque(asked), TorqueReported(told):
                return asked == told
        return True


@dataclass(frozen=True, slots=True)
class Stray:
    """A readable but unexpected answer, for example a late answer after `give_up`."""

    answer: Answer


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A line that is not an answer, or that began before the command was sent."""

    data: bytes
    reason: str


Event: TypeAlias = Completed | Stray | Unreadable | Welcome


class Host:
    """The host's protocol machine. Raises `LocalProtocolError` if misused.

    There is no clock: the caller decides when to give up on an answer. The host holds at most 256
    lines of 80 bytes and `MAX_EARLY` events.
    """

    def __init__(self) -> None:
        self._lines = AnswerLines[Event](END, self._interpret, max_length=LINE_BYTES)
        self._command: Command | None = None
        self._clean = False

    @property
    def outstanding(self) -> Command | None:
        """The command that has not been answered yet."""
        return self._command

    @property
    def clean(self) -> bool:
        """Whether the board holds no half-received command, as far as the host knows.

        False at first and after `give_up`: then send `Clear` next.
        """
        return self._clean

    @property
    def buffered(self) -> int:
        """Number of buffered bytes."""
        return self._lines.buffered

    def send(self, command: Command) -> bytes:
        """Return a command's bytes.

        Raises `LocalProtocolError` while another command is unanswered, and for `DropArguments`
        while the board may hold half-received input. Lines that began before this call are never
        taken for this command's answer.
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
        """Take bytes from the board in any chunks."""
        self._lines.feed(data)

    def next_event(self) -> Event | None:
        """Return the next event from the bytes received so far, or None."""
        return self._lines.next_event()

    def give_up(self) -> Command | None:
        """Stop waiting for the unanswered command, after a timeout, and return it.

        Its motion may still be under way, and its answer may come later. Send `Version` next: the
        late answer is then a `Stray`, and the answer to `Version` shows that the board has finished
        every earlier command.
        """
        command, self._command = self._command, None
        self._clean = False
        return command

    def discard(self) -> None:
        """Discard all received bytes and unread events; the next byte begins a line.

        Call this only while the line is quiet. The unanswered command stays unanswered.
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
