"""The board's end of the GRBL dialect: text in, parsed lines out, answers back; no clock.

The owner simulates the receive interrupt and its buffer: it picks real-time commands out of the
stream with `pieces`, and passes the rest on when the board reads it. `LineReader` splits text into
lines, `parse_line` finds out what a line says, and `Device` counts the lines that have no answer
yet. No input from the host raises.
"""

from __future__ import annotations

from collections import deque
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.fields import message
from firmware_protocol.grbl.answers import Answer, Banner, Error, Ok, encode_answer
from firmware_protocol.grbl.commands import Home, SetSetting, SystemCommand
from firmware_protocol.grbl.dialect import GRBL, Dialect, take_number
from firmware_protocol.grbl.gcode import Block, GcodeError, parse_block

# Splits bytes into lines as GRBL's main loop does: without spaces and comments, in upper case.
#
# A slash is dropped too, but in the `$` lines of FluidNC, whose settings have names with slashes.
# FluidNC also drops a closing bracket that ends no comment (GCode.cpp, collapseGCode: observed).
# Source: gnea/grbl grbl/protocol.c. CR and LF each end a line, and an empty line is a line.

_LINE_ENDS, _SPACE = b"\r\n", 0x20


class LineReader:
    """Splits bytes without real-time commands into lines, in any chunks.

    It keeps at most `max_line` characters of a line, and one more of a line that is too long.
    """

    def __init__(self, dialect: Dialect = GRBL) -> None:
        self._dialect = dialect
        self.discard()

    def feed(self, data: bytes) -> list[str]:
        """Take bytes in any chunks; return the lines that they end, as GRBL stores them."""
        lines = []
        for byte in data:
            if byte in _LINE_ENDS:
                lines.append(self._kept.decode("latin-1"))
                self.discard()
            elif len(self._kept) <= self._dialect.max_line:
                self._keep(bytes((byte,)))
        return lines

    def discard(self) -> None:
        """Discard everything, as a reset does; the next byte begins a new line."""
        self._kept = bytearray()
        self._comment = b""

    def _keep(self, sign: bytes) -> None:
        in_path = self._dialect.named_settings and self._kept.startswith(b"$")
        if self._comment:
            if self._comment == b"(" and sign == b")":
                self._comment = b""
        elif sign in (b"(", b";"):
            self._comment = sign
        elif sign == b")" and self._dialect.drops_brackets:
            return
        elif sign[0] > _SPACE and (sign != b"/" or in_path):
            self._kept += sign.upper()


# Parses a received line: empty, a `$` command, a block, or a refusal.

_JOG = "$J="


@message()
class Empty:
    """An empty line or a comment; its answer is an ok."""


@message()
class Rejected:
    """A line that is refused in any state, with the error code."""

    code: int


Content: TypeAlias = Empty | SystemCommand | Home | SetSetting | Block | Rejected


def parse_line(text: str, dialect: Dialect) -> Content:
    """Parse a cleaned line by its words alone.

    The machine's state (errors 8 and 9) and the active modes (`Modal.after`) are not considered.
    """
    if not text:
        return Empty()
    if len(text) > dialect.max_line:
        return Rejected(11)
    try:
        if text.startswith(_JOG):
            return parse_block(text[len(_JOG) :], dialect, jog=True)
        return _system(text, dialect) if text.startswith("$") else parse_block(text, dialect)
    except GcodeError as error:
        return Rejected(error.code)
    except LocalProtocolError:  # a value that none of our messages can hold
        return Rejected(3)


_PLAIN = {command.text: command for command in SystemCommand}


def _system(text: str, dialect: Dialect) -> SystemCommand | Home | SetSetting:
    if text in _PLAIN:
        return _PLAIN[text]
    if text.startswith("$H"):
        return _home(text[2:], dialect)
    return _setting(text)


def _home(letters: str, dialect: Dialect) -> Home:
    allowed = 1 if dialect.single_axis_homing else 0
    if len(letters) > allowed or not set(letters) <= set(dialect.axes):
        raise GcodeError(3)
    return Home(letters)


def _setting(text: str) -> SetSetting:
    key, at = take_number(text, 1) or (-1, 1)
    if key < 0 or text[at : at + 1] != "=":
        raise GcodeError(3)
    taken = take_number(text, at + 1)
    if taken is None:
        raise GcodeError(2)
    value, end = taken
    if end != len(text):
        raise GcodeError(3)
    return SetSetting(int(key), value)


@message()
class LineReceived:
    """A line as GRBL stores it, and its content. Answer it with `Ok` or `Error`."""

    text: str
    content: Content


class Device:
    """The board's end. Raises `LocalProtocolError` for mistakes of its owner."""

    def __init__(self, dialect: Dialect = GRBL) -> None:
        self._dialect = dialect
        self._lines = LineReader(dialect)
        self._waiting: deque[str] = deque()
        self._unanswered = 0

    @property
    def unanswered(self) -> int:
        """Number of fetched and unanswered lines."""
        return self._unanswered

    def receive_data(self, data: bytes) -> None:
        """Take text from the host in any chunks, without its real-time commands."""
        self._waiting += self._lines.feed(data)

    def next_event(self) -> LineReceived | None:
        """Return the next line, or None."""
        if not self._waiting:
            return None
        text = self._waiting.popleft()
        self._unanswered += 1
        return LineReceived(text, parse_line(text, self._dialect))

    def send(self, answer: Answer) -> bytes:
        """Return the bytes of an answer or message.

        `Ok` and `Error` answer the oldest line; without one, this raises `LocalProtocolError`. A
        banner ends the wait of all earlier lines.
        """
        if isinstance(answer, Ok | Error):
            if self._unanswered == 0:
                raise LocalProtocolError(f"no line is unanswered, so '{answer.line}' is no answer")
            self._unanswered -= 1
        elif isinstance(answer, Banner):
            self._unanswered = 0
        return encode_answer(answer)

    def discard(self) -> None:
        """Discard received bytes and unanswered lines, as a soft reset does."""
        self._lines.discard()
        self._waiting.clear()
        self._unanswered = 0
