"""The Tutor dialect: lines of text, and the two ends that speak them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

from firmware_protocol.errors import RemoteProtocolError, chosen_by_sender
from firmware_protocol.events import Unreadable
from firmware_protocol.fields import message, row_of, whole_from
from firmware_protocol.lines import LineSplitter

MOTORS = 6
RATE_MAX_HZ = 2000
_COUNT_MAX = (1 << 31) - 1
STEPS = row_of(whole_from(-_COUNT_MAX, _COUNT_MAX), MOTORS, f"{MOTORS} whole numbers")


@message(rate_hz=whole_from(1, RATE_MAX_HZ), steps=STEPS)
class Move:
    """Turn all motors by `steps`, the busiest one at `rate_hz` steps a second."""

    rate_hz: int
    steps: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Where:
    """Ask for the positions."""


@dataclass(frozen=True, slots=True)
class Ok:
    """The motion has ended."""


@dataclass(frozen=True, slots=True)
class Failed:
    """The device did not understand the line."""


@message(steps=STEPS)
class Positions:
    """The positions of all motors, counted from power-on."""

    steps: tuple[int, ...]


Command: TypeAlias = Move | Where
Answer: TypeAlias = Ok | Failed | Positions


def encode(message: Command | Answer) -> bytes:
    """Return the line of a message."""
    match message:
        case Move(rate_hz, steps):
            words = ["M", rate_hz, *steps]
        case Positions(steps):
            words = ["p", *steps]
        case Where():
            words = ["P"]
        case Ok():
            words = ["ok"]
        case Failed():
            words = ["err"]
    return f"{' '.join(map(str, words))}\n".encode("ascii")


@chosen_by_sender()
def decode_command(line: bytes) -> Command:
    """Read what a host says. Raises `RemoteProtocolError`."""
    word, numbers = _read(line)
    if word == "M" and numbers:
        return Move(numbers[0], tuple(numbers[1:]))
    if word == "P" and not numbers:
        return Where()
    raise RemoteProtocolError(f"{line!r} is no command")


@chosen_by_sender()
def decode_answer(line: bytes) -> Answer:
    """Read what a device says. Raises `RemoteProtocolError`."""
    word, numbers = _read(line)
    if word == "p":
        return Positions(tuple(numbers))
    if word in ("ok", "err") and not numbers:
        return Ok() if word == "ok" else Failed()
    raise RemoteProtocolError(f"{line!r} is no answer")


def _read(line: bytes) -> tuple[str, list[int]]:
    try:
        word, *rest = line.decode("ascii").split()
        return word, [int(each) for each in rest]
    except ValueError:
        raise RemoteProtocolError(f"{line!r} is no line of this dialect") from None


M = TypeVar("M", Command, Answer)


class _End(Generic[M]):
    """One end of the wire: cuts lines, and reads each of them."""

    def __init__(self, decode: Callable[[bytes], M]) -> None:
        self._lines = LineSplitter(b"\r\n")
        self._decode: Callable[[bytes], M] = decode

    def receive_data(self, data: bytes) -> None:
        """Take bytes, in any portions."""
        self._lines.feed(data)

    def next_event(self) -> M | Unreadable | None:
        """Return the next message, or None."""
        line = self._lines.next_line()
        if line is None or isinstance(line, Unreadable):
            return line
        try:
            return self._decode(line)
        except RemoteProtocolError as error:
            return Unreadable(line, str(error))

    def discard(self) -> None:
        """Forget half a line."""
        self._lines.discard()


class Host(_End[Answer]):
    """The driver's end."""

    def __init__(self) -> None:
        super().__init__(decode_answer)

    def send(self, command: Command) -> bytes:
        """Return the bytes that give a command."""
        return encode(command)


class Device(_End[Command]):
    """The controller's end."""

    def __init__(self) -> None:
        super().__init__(decode_command)

    def send(self, answer: Answer) -> bytes:
        """Return the bytes that give an answer."""
        return encode(answer)
