"""Split a byte stream into lines, for every dialect that uses lines.

The caller of a splitter or a host fetches what it has found before feeding more, so neither limits
how much waits. Only the length of a line is limited, because its end may never come.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections import deque
from typing import Generic, TypeVar

from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.events import Unreadable

E = TypeVar("E")  # a host's event for a line

SHOWN_BYTES = 32  # how much of a line that is dropped is kept for messages


class LineSplitter:
    """Splits bytes, in any chunks, into lines.

    A line ends at any byte of `terminators`. Empty lines are skipped, so that CR LF ends one line.
    A line longer than `max_length` bytes is dropped up to its terminator and reported once, as
    soon as it becomes too long.
    """

    def __init__(self, terminators: bytes, max_length: int = 256) -> None:
        self._ends = re.compile(b"[" + re.escape(terminators) + b"]")
        self._max_length = max_length
        self._waiting: deque[bytes | Unreadable] = deque()
        self._partial = bytearray()
        self._dropping = False

    @property
    def partial(self) -> bytes:
        """The incomplete line at the end of the input."""
        return bytes(self._partial)

    def feed(self, data: bytes) -> None:
        """Take bytes in any chunks."""
        *ended, rest = self._ends.split(data)
        for piece in ended:
            self._extend(piece)
            self._finish()
        self._extend(rest)

    def next_line(self) -> bytes | Unreadable | None:
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
        self._waiting.append(Unreadable(start, f"a line of more than {self._max_length} bytes"))

    def _finish(self) -> None:
        if self._partial:
            self._waiting.append(bytes(self._partial))
        self._partial.clear()
        self._dropping = False


class LineHost(ABC, Generic[E]):
    """The receiving end of a host whose device answers in lines. No input raises.

    A dialect adds `_interpret`. A line is early if it began before the latest command was sent, so
    it must not pass for the answer. Lines that consist only of `padding` are skipped.
    """

    def __init__(self, terminators: bytes, *, padding: bytes = b"", max_length: int = 256) -> None:
        self._lines = LineSplitter(terminators, max_length)
        self._padding = padding
        self._early: deque[E | Unreadable] = deque()
        self._began_early = False

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the device in any chunks."""
        self._lines.feed(data)

    def next_event(self) -> E | Unreadable | None:
        """Return the next event from the bytes received so far, or None."""
        return self._early.popleft() if self._early else self._next()

    def discard(self) -> None:
        """Discard all received bytes and unread events; the next byte begins a line.

        Call this only while the line is quiet. What is unanswered stays unanswered.
        """
        self._lines.discard()
        self._early.clear()
        self._began_early = False

    @abstractmethod
    def _interpret(self, line: bytes) -> E | None:
        """Return the event of a line, if any. Raises `RemoteProtocolError` if it is unreadable."""

    def _interpret_early(self, line: bytes) -> E | None:  # noqa: ARG002
        """Return the event of an early line; by default, none is readable."""
        raise RemoteProtocolError("the line began before the command was sent")

    @property
    def _partial(self) -> bytes:
        """The incomplete line at the end of the input; empty if it is only padding."""
        partial = self._lines.partial
        return partial if partial.strip(self._padding) else b""

    def _keep_early(self) -> None:
        """Interpret all complete lines now, so that none can answer the next command."""
        # Their events are queued, because the caller of `send` did not ask for them.
        while (event := self._next()) is not None:
            self._early.append(event)

    def _mark_early(self, *, early: bool = True) -> None:
        """Mark the incomplete line as early, or remove the mark."""
        self._began_early = early and bool(self._partial)

    def _next(self) -> E | Unreadable | None:
        while (line := self._lines.next_line()) is not None:
            early, self._began_early = self._began_early, False
            if isinstance(line, Unreadable):
                return line
            if not line.strip(self._padding):
                continue
            try:
                event = self._interpret_early(line) if early else self._interpret(line)
            except RemoteProtocolError as error:
                return Unreadable(line, str(error))
            if event is not None:
                return event
        return None
