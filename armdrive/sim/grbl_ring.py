"""The receive ring of a simulated GRBL board: when it is full, bytes are lost without a word."""

from __future__ import annotations

import re

_LINE_END = re.compile(rb"[\r\n]")
_LONGEST = 4096


class Ring:
    """Bytes that the main loop has not read, and the line that it has begun to read.

    `lost` counts the bytes that found no room.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.lost = 0
        self._bytes = bytearray()
        self._begun = bytearray()

    def __len__(self) -> int:
        return len(self._bytes)

    @property
    def free(self) -> int:
        """How many bytes find room."""
        return self.size - len(self._bytes)

    def put(self, data: bytes) -> None:
        """Take bytes as far as there is room."""
        kept = data[: self.free]
        self.lost += len(data) - len(kept)
        self._bytes += kept

    def take_line(self) -> bytes:
        """Read up to a line's end and return the line; nothing while its end has not come."""
        end = _LINE_END.search(self._bytes)
        count = len(self._bytes) if end is None else end.end()
        self._begun += self._bytes[:count]
        del self._bytes[:count]
        if end is None:
            del self._begun[_LONGEST:]  # no line is as long, and its end is still to come
            return b""
        line = bytes(self._begun)
        self._begun.clear()
        return line

    def clear(self) -> None:
        """Forget everything."""
        self._bytes.clear()
        self._begun.clear()
