"""The board's end of the GRBL dialect: real-time commands and lines in, answers out, no clock.

The only state is the number of fetched and unanswered lines. The owner simulates the receive buffer
and the planner: it picks real-time commands out with `pieces` and feeds the buffer's output
to this machine. No input from the host raises.
"""

from __future__ import annotations

from collections import deque
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.fields import message
from firmware_protocol.grbl.answers import Answer, Banner, Error, Ok, encode_answer
from firmware_protocol.grbl.commands import (
    Home,
    Realtime,
    SetSetting,
    SystemCommand,
    pieces,
)
from firmware_protocol.grbl.dialect import GRBL, Dialect, take_number
from firmware_protocol.grbl.gcode import Block, GcodeError, parse_block

# Splits bytes into lines as GRBL's main loop does: without spaces and comments, in upper case.
#
# A slash is dropped too, but in the `$` lines of FluidNC, whose settings have names with slashes.
# FluidNC also drops a closing bracket that ends no comment (GCode.cpp, collapseGCode: observed).
# Source: gnea/grbl grbl/protocol.c. CR and LF each end a line, and an empty line is a line.


MAX_WAITING = 256
"""Most queued lines."""

_CR, _LF, _SPACE = 0x0D, 0x0A, 0x20


@message()
class Unusable:
    """A line that cannot be executed, with the reason. Its error is `Dialect.overlong`."""

    start: str
    reason: str


class LineReader:
    """Splits bytes without real-time commands into lines, in any chunks.

    It keeps at most `max_line` characters of a line, and at most `MAX_WAITING` lines. If more
    arrive, the last line is `Unusable`, and the others are lost until lines are fetched.
    """

    def __init__(self, dialect: Dialect = GRBL) -> None:
        self._max_line = dialect.max_line
        self._named_settings = dialect.named_settings
        self._drops_brackets = dialect.drops_brackets
        self._each_end_counts = dialect.crlf_answers_twice
        self._waiting: deque[str | Unusable] = deque()
        self.discard()

    @property
    def partial(self) -> str:
        """The incomplete line at the end of the input."""
        return self._kept.decode("latin-1")

    @property
    def buffered(self) -> int:
        """Number of buffered characters."""
        held = sum(len(e.start if isinstance(e, Unusable) else e) for e in self._waiting)
        return held + len(self._kept)

    def feed(self, data: bytes) -> None:
        """Take bytes in any chunks."""
        for byte in data:
            if byte in (_CR, _LF):
                self._end(byte)
            else:
                self._after_cr = False
                self._keep(byte)

    def next_line(self) -> str | Unusable | None:
        """Return the next line as GRBL stores it, or None."""
        return self._waiting.popleft() if self._waiting else None

    def discard(self) -> None:
        """Discard everything, as a reset does; the next byte begins a new line."""
        self._waiting.clear()
        self._after_cr = False
        self._begin()

    @property
    def _in_path(self) -> bool:
        """Return whether a slash is part of a setting's name, as in `$/stepping/idle_ms`."""
        return self._named_settings and self._kept.startswith(b"$")

    def _begin(self) -> None:
        self._kept = bytearray()
        self._comment = b""
        self._too_long = False

    def _keep(self, byte: int) -> None:
        sign = bytes((byte,))
        if self._too_long:
            return
        if self._comment:
            if self._comment == b"(" and sign == b")":
                self._comment = b""
        elif sign in (b"(", b";"):
            self._comment = sign
        elif sign == b")" and self._drops_brackets:
            return
        elif byte > _SPACE and (sign != b"/" or self._in_path):
            self._too_long = len(self._kept) >= self._max_line
            self._kept += b"" if self._too_long else sign.upper()

    def _end(self, byte: int) -> None:
        second_half = byte == _LF and self._after_cr and not self._each_end_counts
        self._after_cr = byte == _CR
        if second_half:
            return
        text = self.partial
        reason = f"a line of more than {self._max_line} characters"
        self._put(Unusable(text, reason) if self._too_long else text)
        self._begin()

    def _put(self, entry: str | Unusable) -> None:
        room = MAX_WAITING - len(self._waiting)
        if room > 1:
            self._waiting.append(entry)
        elif room == 1:
            start = entry.start if isinstance(entry, Unusable) else entry
            reason = f"{MAX_WAITING} lines were waiting: from here on they are lost"
            self._waiting.append(Unusable(start, reason))


def clean_line(text: str) -> str:
    """Return one line of ASCII as GRBL stores it."""
    reader = LineReader(Dialect(max_line=max(1, min(len(text), 1024))))
    reader.feed(text.encode("ascii"))
    return reader.partial


# Parses a received line: empty, a `$` command, a block, or a refusal.

_JOG = "$J="


@message()
class Empty:
    """An empty line or a comment; its answer is an ok."""


@message()
class Rejected:
    """A line that is refused in any state, with the error code and the reason."""

    code: int
    reason: str


Content: TypeAlias = Empty | SystemCommand | Home | SetSetting | Block | Rejected


def parse_line(text: str, dialect: Dialect) -> Content:
    """Parse a cleaned line by its words alone.

    The machine's state (errors 8 and 9) and the active modes (`Modal.after`) are not considered.
    """
    if len(text) > dialect.max_line:
        return Rejected(dialect.overlong, f"a line of more than {dialect.max_line} characters")
    if not text:
        return Empty()
    try:
        if text.startswith(_JOG):
            return parse_block(text[len(_JOG) :], dialect, jog=True)
        return _system(text, dialect) if text.startswith("$") else parse_block(text, dialect)
    except GcodeError as error:
        return Rejected(error.code, str(error))
    except LocalProtocolError as error:  # a value that none of our messages can hold
        return Rejected(3, str(error))


_PLAIN = {command.text: command for command in SystemCommand}
_KNOWN_LETTERS = "$GCXJ#HSIRN"
"""Characters after the `$` of a command; any other begins a setting's number."""


def _system(text: str, dialect: Dialect) -> SystemCommand | Home | SetSetting:
    if text in _PLAIN:
        return _PLAIN[text]
    if text.startswith("$H"):
        return _home(text[2:], dialect)
    if text[1] in _KNOWN_LETTERS:
        raise GcodeError(3, text)
    return _setting(text, dialect)


def _home(letters: str, dialect: Dialect) -> Home:
    allowed = 1 if dialect.single_axis_homing else 0
    if len(letters) > allowed or not set(letters) <= set(dialect.axes):
        raise GcodeError(3, f"$H{letters}")
    return Home(letters)


def _setting(text: str, dialect: Dialect) -> SetSetting:
    taken = take_number(text, 1)
    if taken is None:
        raise GcodeError(dialect.no_setting, text)
    key, at = taken
    if text[at : at + 1] != "=" or key < 0:
        raise GcodeError(3, text)
    taken = take_number(text, at + 1)
    if taken is None:
        raise GcodeError(2, text)
    value, end = taken
    if end != len(text):
        raise GcodeError(3, text)
    return SetSetting(int(key), value)


MAX_REALTIME = 512
"""Most queued events; beyond that, real-time commands are dropped."""


@message()
class RealtimeReceived:
    """A real-time command. It gets no ok."""

    command: Realtime


@message()
class LineReceived:
    """A line as GRBL stores it, and its content. Answer it with `Ok` or `Error`."""

    text: str
    content: Content


Request: TypeAlias = RealtimeReceived | LineReceived


class Device:
    """The board's end. Raises `LocalProtocolError` for mistakes of its owner.

    A real-time command comes before the line that it interrupts, and after the lines that ended
    before it. If nobody fetches events, further lines are lost with a report, and real-time
    commands without one: on a real board they are flags.
    """

    def __init__(self, dialect: Dialect = GRBL) -> None:
        self._dialect = dialect
        self._lines = LineReader(dialect)
        self._waiting: deque[Realtime | str | Unusable] = deque()
        self._unanswered = 0

    @property
    def dialect(self) -> Dialect:
        """The board's dialect."""
        return self._dialect

    @property
    def unanswered(self) -> int:
        """Number of fetched and unanswered lines."""
        return self._unanswered

    @property
    def buffered(self) -> int:
        """Number of buffered characters and real-time commands."""
        held = sum(1 if isinstance(e, Realtime) else len(_text(e)) for e in self._waiting)
        return held + self._lines.buffered

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the host in any chunks."""
        for piece in pieces(data, self._dialect.variant):
            if isinstance(piece, Realtime):
                if len(self._waiting) < MAX_REALTIME:
                    self._waiting.append(piece)
            else:
                self._lines.feed(piece)
                self._fetch_lines()

    def next_event(self) -> Request | None:
        """Return the next real-time command or line, or None."""
        if not self._waiting:
            return None
        entry = self._waiting.popleft()
        self._fetch_lines()
        if isinstance(entry, Realtime):
            return RealtimeReceived(entry)
        self._unanswered += 1
        if isinstance(entry, Unusable):
            return LineReceived(entry.start, Rejected(self._dialect.overlong, entry.reason))
        return LineReceived(entry, parse_line(entry, self._dialect))

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

    def _fetch_lines(self) -> None:
        while len(self._waiting) < MAX_WAITING and (line := self._lines.next_line()) is not None:
            self._waiting.append(line)


def _text(entry: str | Unusable) -> str:
    return entry.start if isinstance(entry, Unusable) else entry
