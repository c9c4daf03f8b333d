"""Cut a stream of bytes into lines, in bounded memory, for every dialect that speaks in lines."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

E = TypeVar("E")
"""What a host makes of a line."""

SHOWN_BYTES = 32
"""How much of a dropped line is kept to be shown."""
MAX_EARLY = 256
"""How many events from before the last command are kept for a host's owner, the newest."""


@dataclass(frozen=True, slots=True)
class Dropped:
    """Bytes that were thrown away: how they began, and why."""

    start: bytes
    reason: str


class LineSplitter:
    """Lines out of bytes, whatever the chunks they come in.

    A line ends at any byte of `terminators`; empty lines are skipped, so that CR LF ends one
    line and not two. A line longer than `max_length` bytes is dropped up to its terminator and
    reported once, at the moment it becomes too long (its terminator may never come). At most
    `max_lines` entries wait to be fetched: in a flood the last of them is a report, and what
    comes after it is lost until entries are fetched.
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
        """The beginning of a line whose terminator has not come yet."""
        return bytes(self._partial)

    @property
    def buffered(self) -> int:
        """How many bytes are held."""
        held = sum(len(e.start if isinstance(e, Dropped) else e) for e in self._waiting)
        return held + len(self._partial)

    def feed(self, data: bytes) -> None:
        """Take bytes, in any portions."""
        *ended, rest = self._ends.split(data)
        for piece in ended:
            self._extend(piece)
            self._finish()
        self._extend(rest)

    def next_line(self) -> bytes | Dropped | None:
        """Return the next line without its terminator, or a report, or None when there is none."""
        return self._waiting.popleft() if self._waiting else None

    def discard(self) -> None:
        """Forget every byte held: the next byte begins a new line.

        Meant for after a silence. While a line is still coming in, its tail would be taken for a
        whole line.
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
        shown = min(SHOWN_BYTES, self._max_length)  # bytes that are here whatever the chunks
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
    """A device's lines as events for a host, which never takes an early one for an answer.

    `read` makes an event of a line, or nothing; it is told whether the line is an early one, which
    had begun before the command was sent. Lines of nothing but `padding` are skipped.
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
        """How many received bytes are held."""
        return self._lines.buffered

    @property
    def partial(self) -> bytes:
        """The beginning of a line whose terminator has not come yet; empty if it says nothing."""
        partial = self._lines.partial
        return partial if partial.strip(self._padding) else b""

    def feed(self, data: bytes) -> None:
        """Take bytes, in any portions."""
        self._lines.feed(data)

    def keep_early(self) -> None:
        """Read what was received by now: a command that is sent next is not answered by it."""
        while (event := self._next()) is not None:
            self._early.append(event)

    def mark_early(self, *, early: bool = True) -> None:
        """Call the line that has begun an early one, or none."""
        self._began_early = early and bool(self.partial)

    def next_event(self) -> E | None:
        """Return the next event, or None when there is none."""
        return self._early.popleft() if self._early else self._next()

    def discard(self) -> None:
        """Forget all bytes received and all events not fetched; the next byte begins a line."""
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
