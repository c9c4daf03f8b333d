"""Both ends of the Armdroid dialect: the host's and the board's. No clock, no I/O.

The host sends one command at a time. An answer is one line; the answer to a motion comes after the
motion's end. The board processes characters in order and queues those that arrive during a motion,
so an answer shows that every earlier command is done. Other lines become `Stray` (readable, but not
the expected answer) or `Unreadable`.

The device handles one command at a time: after a command's event the owner must send the answer,
and further characters are queued, as in the real board during a motion. No input from the other
end raises.
"""

from __future__ import annotations

from typing import TypeAlias

from firmware_protocol.armdroid.messages import (
    ANSWER_TO,
    END,
    KEPT,
    MOTORS,
    Answer,
    Clear,
    Command,
    DriveAll,
    DriveOne,
    DropArguments,
    HomeToOffsets,
    ReportArguments,
    ReportOffsets,
    Request,
    SetSpeed,
    SpeedReported,
    Torque,
    TorqueReported,
    Version,
    Welcome,
    ZeroOffsets,
    decode_answer,
    encode_answer,
    encode_command,
)
from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.events import Stray, Unreadable
from firmware_protocol.fields import message, wrapped16
from firmware_protocol.lines import LineHost

# The host's end.

LINE_BYTES = 80  # the sketch's own line buffer; its longest answer has 51 characters

_CLEARING = (Clear, DriveOne, DriveAll, DropArguments, ZeroOffsets)


@message()
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

    def give_up(self) -> None:
        """Stop waiting for the unanswered command, after a timeout.

        Its motion may still be under way, and its answer may come later. Send `Version` next: the
        late answer is then a `Stray`, and the answer to `Version` shows that the board has finished
        every earlier command.
        """
        self._command = None
        self._clean = False

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
        self._clean = self._command is None
        return Welcome()


# The board's end. Numbers are 16-bit `int` and wrap, as on the AVR boards that the sketch was
# written for.

_DIGITS = b"0123456789"

_PLAIN: dict[int, Request] = {
    ord(request.letter): request
    for request in (
        HomeToOffsets(),
        ReportOffsets(),
        ZeroOffsets(),
        Version(),
        ReportArguments(),
    )
}
_WITH_NUMBERS = frozenset(b"dDst")


class Device:
    """The protocol machine of a simulated board. Raises `LocalProtocolError` if misused.

    The host's `Clear` and `DropArguments` arrive as the board interprets them: as a `DriveOne` of 0
    steps. Text of other dialects is interpreted in the same way: the `D` in
    `@READ` is a `DriveAll` by the kept arguments.
    """

    def __init__(self) -> None:
        self._arguments = [0] * KEPT
        self._index = 0
        self._accumulator = 0
        self._waiting = bytearray()
        self._request: Request | None = None

    @property
    def unanswered(self) -> Request | None:
        """The command that still needs an answer."""
        return self._request

    @property
    def arguments(self) -> tuple[int, ...]:
        """The five kept arguments, for the answer to `ReportArguments`."""
        return tuple(self._arguments)

    @property
    def accumulator(self) -> int:
        """The number that is being received, for the answer to `ReportArguments`."""
        return self._accumulator

    def receive_data(self, data: bytes) -> None:
        """Take characters from the host in any chunks."""
        self._waiting += data

    def next_event(self) -> Request | None:
        """Return the next command; None if there is none or an answer is outstanding."""
        while self._request is None and self._waiting:
            self._request = self._take(self._waiting.pop(0))
            if self._request is not None:
                return self._request
        return None

    def send(self, answer: Answer | Welcome) -> bytes:
        """Return the bytes of an answer.

        Raises `LocalProtocolError` if the outstanding command needs another answer. `Welcome`
        answers no command: it begins a session and discards all half-received input.
        """
        if isinstance(answer, Welcome):
            self._welcome()
            return encode_answer(answer)
        form = None if self._request is None else ANSWER_TO[self._request.letter]
        if form is None or not isinstance(answer, form):
            owed = f"a {form.__name__} is owed" if form else "nothing is owed"
            raise LocalProtocolError(f"{owed}, so a {type(answer).__name__} cannot be sent")
        self._request = None
        return encode_answer(answer)

    def forget(self) -> None:
        """Reset, as after a loss of power."""
        self._request = None
        self._reset()
        self._waiting.clear()

    def _welcome(self) -> None:
        if self._request is not None:
            raise LocalProtocolError("an answer is owed: a board says Welcome between commands")
        self._reset()

    # -- the sketch's character machine: an accumulator, an argument index and kept arguments ------

    def _take(self, byte: int) -> Request | None:
        """Take one character; return the command that it completes, or None.

        The sketch ignores all others, such as CR and LF.
        """
        if byte in _DIGITS:
            self._accumulator = wrapped16(self._accumulator * 10 + byte - _DIGITS[0])
        elif byte == ord("-"):
            self._accumulator = wrapped16(-self._accumulator)
        elif byte == ord(","):
            self._shift()
        elif byte in _WITH_NUMBERS:
            return self._execute(chr(byte))
        elif byte in _PLAIN:
            if byte == ord("r"):
                self._reset()
            return _PLAIN[byte]
        return None

    def _reset(self) -> None:
        self._arguments = [0] * KEPT
        self._index = self._accumulator = 0

    def _shift(self) -> None:
        # the sketch writes the sixth past the end of its array, which is where the compiler has put
        # the index: observed on an Uno, it has no effect
        if self._index < KEPT:
            self._arguments[self._index] = self._accumulator
        self._index = (self._index + 1) % MOTORS
        self._accumulator = 0

    def _execute(self, letter: str) -> Request:
        value, self._accumulator = self._accumulator, 0
        if letter == "t":
            return Torque(value != 0)
        if letter == "s":
            return SetSpeed(value)
        self._index = 0
        if letter == "D":
            return DriveAll((*self._arguments, value))
        motor = self._arguments[0] & 0xFF  # a uint8_t in the library's call
        return DriveOne(motor, value)
