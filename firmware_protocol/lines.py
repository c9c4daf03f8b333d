"""Split a byte stream into lines in bounded memory, for every dialect that uses lines."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

E = TypeVar("E")  # a host's event for a line

SHOWN_BYTES = 32  # how much of a dropped line is kept for messages
MAX_EARLY = 256  # most events from before the latest command that a host keeps: the newest


@dataclass(frozen=True, slots=True)
class Dropped:
    """Discarded bytes: their beginning, and the reason."""

    start: bytes
    reason: str


class LineSplitter:
    """Splits bytes, in any chunks, into lines.

    A line ends at any byte of `terminators`. Empty lines are skipped, so that CR LF ends one line.
    A line longer than `max_length` bytes is dropped up to its terminator and reported once, as
    soon as it becomes too long (its terminator may never come). At most `max_lines` entries are
    queued. When the queue is full, its last entry reports the overflow, and further lines are lost
    until entries are fetched.
    """

    def __init__(self, terminators: bytes, max_length: int = 256, max_lines: int = 256) -> None:
        self._ends = re.compile(b"[" + re.escape(terminators) + b"]")
        self._max_length = max_length
        self._max_lines = max_lines
        self._waiting: deque[bytes | Dropped] = deque()
        self._partial = bytearray()
        self._dropping = False

    @property
    def partial(self) -> bytes:
        """The incomplete line at the end of the input."""
        return bytes(self._partial)

    @property
    def buffered(self) -> int:
        """Number of buffered bytes."""
        held = sum(len(e.start if isinstance(e, Dropped) else e) for e in self._waiting)
        return held + len(self._partial)

    def feed(self, data: bytes) -> None:
        """Take bytes in any chunks."""
        *ended, rest = self._ends.split(data)
        for piece in ended:
            self._extend(piece)
            self._finish()
        self._extend(rest)

    def next_line(self) -> bytes | Dropped | None:
        """Return the next line without its terminator, or a report; None if the queue is empty."""
        return self._waiting.popleft() if self._waiting else None

    def discard(self) -> None:
        """Discard all buffered bytes; the next byte begins a new line.

        Call this only while the line is quiet: the rest of a line that is still arriving would be
        taken for a whole line.
        """
        self._waiting.clear()
        self._partial.clear()
        self._dropping = False

    def _extend(self, piece: bytes) -> None:
        if self._dropping:
            return
        if len(self._partial) + len(piece) <= self._max_length:
            self._partial += piece
            return
        shown = min(SHOWN_BYTES, self._max_length)  # so the report does not depend on the chunks
        start = (bytes(self._partial) + piece[:shown])[:shown]
        self._partial.clear()
        self._dropping = True
        self._put(Dropped(start, f"a line of more than {self._max_length} bytes"))

    def _finish(self) -> None:
        if self._partial:
            self._put(bytes(self._partial))
        self._partial.clear()
        self._dropping = False

    def _put(self, entry: bytes | Dropped) -> None:
        room = self._max_lines - len(self._waiting)
        if room > 1:
            self._waiting.append(entry)
        elif room == 1:
            start = entry.start if isinstance(entry, Dropped) else entry[:SHOWN_BYTES]
            reason = f"{self._max_lines} lines were waiting: from here on they are lost"
            self._waiting.append(Dropped(start, reason))


class AnswerLines(Generic[E]):
    """Turns a device's lines into events, and keeps early lines from passing for answers.

    A line is early if it began before the command was sent. `read` takes a line and whether it is
    early, and returns an event or None. Lines that consist only of `padding` are skipped.
    """

    def __init__(
        self,
        terminators: bytes,
        read: Callable[[bytes | Dropped, bool], E | None],
        *,
        padding: bytes = b"",
        max_length: int = 256,
    ) -> None:
        self._lines = LineSplitter(terminators, max_length)
        self._read = read
        self._padding = padding
        self._early: deque[E] = deque(maxlen=MAX_EARLY)
        self._began_early = False

    @property
    def buffered(self) -> int:
        """Number of buffered bytes."""
        return self._lines.buffered

    @property
    def partial(self) -> bytes:
        """The incomplete line at the end of the input; empty if it is only padding."""
        partial = self._lines.partial
        return partial if partial.strip(self._padding) else b""

    def feed(self, data: bytes) -> None:
        """Take bytes in any chunks."""
        self._lines.feed(data)

    def keep_early(self) -> None:
        """Interpret all complete lines now, so that none can answer the next command."""
        while (event := self._next()) is not None:
            self._early.append(event)

    def mark_early(self, *, early: bool = True) -> None:
        """Mark the incomplete line as early, or remove the mark."""
        self._began_early = early and bool(self.partial)

    def next_event(self) -> E | None:
        """Return the next event, or None."""
        return self._early.popleft() if self._early else self._next()

    def discard(self) -> None:
        """Discard all received bytes and unread events; the next byte begins a line."""
        self._lines.discard()
        self._early.clear()
        self._began_early = False

    def _next(self) -> E | None:
        while (line := self._lines.next_line()) is not None:
            early, self._began_early = self._began_early, False
            if isinstance(line, bytes) and not line.strip(self._padding):
                continue
            if (event := self._read(line, early)) is not None:
                return event
        return None
