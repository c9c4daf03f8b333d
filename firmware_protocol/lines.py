"""Cut a stream of bytes into lines, in bounded memory, for every dialect that speaks in lines."""

from __future__ import annotations

import re
from collections import deque
from dataclasses import dataclass

SHOWN_BYTES = 32
"""How much of a dropped line is kept to be shown."""


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
