"""The board's end of the GRBL dialect: real-time commands and lines in, answers out, no clock.

What it keeps is one number, how many lines have been fetched and not been answered. Ring and
planner belong to whoever owns it: a simulated ring feeds this machine what comes out of it, with
the real-time commands taken out before by `split_realtime`. Nothing that the host sends raises.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.grbl.answers import Banner, Error, Ok
from firmware_protocol.grbl.dialect import GRBL, Dialect
from firmware_protocol.grbl.linereader import MAX_WAITING, LineReader, Unusable
from firmware_protocol.grbl.parsing import OVERLONG, Content, Rejected, parse_line
from firmware_protocol.grbl.realtime import Realtime, is_picked_out, realtime_of
from firmware_protocol.grbl.reports import Answer, encode_answer

MAX_REALTIME = 512
"""No real-time command is taken while so many events wait."""


@dataclass(frozen=True, slots=True)
class RealtimeReceived:
    """A real-time command. It gets no ok."""

    command: Realtime


@dataclass(frozen=True, slots=True)
class LineReceived:
    """A line as GRBL stores it, and what it asks for. Answer it with `Ok` or `Error`."""

    text: str
    content: Content


Request: TypeAlias = RealtimeReceived | LineReceived


class Device:
    """The machine that a simulated board speaks with. Raises `LocalProtocolError` for its owner.

    Real-time commands come out of the middle of a line at once, before that line, and behind the
    lines that had ended before them. In a flood that nobody fetches, lines are lost once 512 wait,
    with a report, and real-time commands without one: they are flags on a real board too.
    """

    def __init__(self, dialect: Dialect = GRBL) -> None:
        self._dialect = dialect
        self._lines = LineReader(dialect)
        self._waiting: deque[Realtime | str | Unusable] = deque()
        self._unanswered = 0

    @property
    def dialect(self) -> Dialect:
        """What this board admits."""
        return self._dialect

    @property
    def unanswered(self) -> int:
        """How many lines have been fetched and not been answered."""
        return self._unanswered

    @property
    def buffered(self) -> int:
        """How many characters and real-time commands are held."""
        held = sum(1 if isinstance(e, Realtime) else len(_text(e)) for e in self._waiting)
        return held + self._lines.buffered

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the host, in any portions."""
        grblhal = self._dialect.grblhal_realtime
        start = 0
        for at, byte in enumerate(data):
            if is_picked_out(byte, grblhal=grblhal):
                self._lines.feed(data[start:at])
                self._fetch_lines()
                start = at + 1
                self._put(realtime_of(byte, grblhal=grblhal))
        self._lines.feed(data[start:])
        self._fetch_lines()

    def next_event(self) -> Request | None:
        """Return the next real-time command or line, or None when there is none."""
        if not self._waiting:
            return None
        entry = self._waiting.popleft()
        self._fetch_lines()
        if isinstance(entry, Realtime):
            return RealtimeReceived(entry)
        self._unanswered += 1
        if isinstance(entry, Unusable):
            return LineReceived(entry.start, Rejected(OVERLONG, entry.reason))
        return LineReceived(entry, parse_line(entry, self._dialect))

    def send(self, answer: Answer) -> bytes:
        """Return the bytes of an answer, or of anything that is pushed.

        `Ok` and `Error` each answer the oldest line; without one `LocalProtocolError` is raised.
        A banner means that what was unanswered never will be.
        """
        if isinstance(answer, Ok | Error):
            if self._unanswered == 0:
                raise LocalProtocolError(f"no line is unanswered, so '{answer.line}' is no answer")
            self._unanswered -= 1
        elif isinstance(answer, Banner):
            self._unanswered = 0
        return encode_answer(answer)

    def discard(self) -> None:
        """Forget the bytes received and the lines unanswered, as a soft reset does."""
        self._lines.discard()
        self._waiting.clear()
        self._unanswered = 0

    def _fetch_lines(self) -> None:
        while len(self._waiting) < MAX_WAITING and (line := self._lines.next_line()) is not None:
            self._waiting.append(line)

    def _put(self, command: Realtime | None) -> None:
        if command is not None and len(self._waiting) < MAX_REALTIME:
            self._waiting.append(command)


def _text(entry: str | Unusable) -> str:
    return entry.start if isinstance(entry, Unusable) else entry
