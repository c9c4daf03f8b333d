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
    END,
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
    decode_answer,
    encode_command,
)
from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.events import Stray, Unreadable
from firmware_protocol.lines import LineHost

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


Event: TypeAlias = Completed | Stray | Unreadable | Welcome


class Host(LineHost[Event]):
    """The host's protocol machine. Raises `LocalProtocolError` if misused.

    There is no clock: the caller decides when to give up on an answer.
    """

    def __init__(self) -> None:
        super().__init__(END, max_length=LINE_BYTES)
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
        self._keep_early()
        self._mark_early()
        self._command = command
        return encode_command(command)

    def give_up(self) -> Command | None:
        """Stop waiting for the unanswered command, after a timeout, and return it.

        Its motion may still be under way, and its answer may come later. Send `Version` next: the
        late answer is then a `Stray`, and the answer to `Version` shows that the board has finished
        every earlier command.
        """
        command, self._command = self._command, None
        self._clean = False
        return command

    def _interpret(self, line: bytes) -> Event:
        answer = decode_answer(line)
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
