"""What came in over a wire while an answer was waited for, in words for an error."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Protocol

MOST_BYTES = 512
"""So much is remembered: more than any excerpt shows."""
MOST_SHOWN = 48
"""Bytes of an excerpt."""
MOST_IDS = 6
"""Ids of frames that are named."""
NOT_THE_ANSWER = "but not the answer"
"""Stands before what was received, in an error's words."""
ANOTHER = "and that port, baud rate and dialect are right"


class ReceivedFrame(Protocol):
    """A frame, of which the id is told."""

    @property
    def can_id(self) -> int:
        """The id that it was sent with."""


class FrameReader(Protocol):
    """Reads frames out of what comes in, whatever the chunks."""

    def feed(self, data: bytes) -> Iterable[ReceivedFrame]:
        """Take bytes; return the frames that they complete."""


class Received:
    """What has come since a call began: bytes, or the frames that `frames` reads out of them."""

    def __init__(self, frames: Callable[[], FrameReader] | None = None) -> None:
        self._frames = frames
        self.clear()

    def clear(self) -> None:
        """Forget what came: another call begins."""
        self.count = 0
        self._first = bytearray()
        self._reader = None if self._frames is None else self._frames()
        self._ids: dict[int, None] = {}

    def add(self, data: bytes) -> None:
        """Take note of what came."""
        if self._reader is not None:
            for frame in self._reader.feed(data):
                self.count += 1
                if len(self._ids) <= MOST_IDS:
                    self._ids[frame.can_id] = None
            return
        self.count += len(data)
        self._first += data[: MOST_BYTES - len(self._first)]

    def look_at(self, silent: str) -> str:
        """Return what a person does about it: `silent`, and more where bytes came."""
        return silent if self._frames or not self.count else f"{silent}, {ANOTHER}"

    def __str__(self) -> str:
        if not self.count:
            return "nothing was received"
        if self._frames:
            named = [f"{each:X}" for each in list(self._ids)[:MOST_IDS]]
            more = ", ..." if len(self._ids) > MOST_IDS else ""
            return f"{_many(self.count, 'frame')}, {NOT_THE_ANSWER}: ids {', '.join(named)}{more}"
        return f"{_many(self.count, 'byte')}, {NOT_THE_ANSWER}: {excerpt(bytes(self._first))}"


def _many(count: int, noun: str) -> str:
    return f"1 {noun} was received" if count == 1 else f"{count} {noun}s were received"


def excerpt(heard: bytes, most: int = MOST_SHOWN) -> str:
    """Return bytes for people, with nothing that a terminal obeys; the end of them cut off."""
    text = heard[:most].decode("latin-1").encode("unicode_escape").decode("ascii")
    return f"'{text}'{' ...' if len(heard) > most else ''}"
