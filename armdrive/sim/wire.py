"""One direction of a serial line: bytes arrive no faster than the baud rate carries them.

Without a baud rate the line is that of a network: what is pushed at once arrives at once, as one.
Times are in seconds on whatever clock the caller keeps.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

BITS_A_BYTE = 10
"""A start bit, eight data bits and a stop bit."""
_ROUNDING = 1e-3
"""The share of a byte's time that may be missing through floating-point rounding."""


@dataclass(slots=True)
class _Piece:
    data: bytes
    start_s: float
    byte_s: float

    @property
    def end_s(self) -> float:
        return self.start_s + len(self.data) * self.byte_s

    def arrived(self, now_s: float) -> int:
        """Count the bytes whose last bit has arrived."""
        if not self.byte_s:
            return len(self.data) if now_s >= self.start_s else 0
        count = math.floor((now_s - self.start_s) / self.byte_s + _ROUNDING)
        return min(max(count, 0), len(self.data))


class PacedWire:
    """A line at `baud` bits a second; `extra_s` is a pause after each byte pushed from now on."""

    def __init__(self, baud: int | None, extra_s: float = 0.0) -> None:
        self.bit_s = 1.0 / baud if baud else 0.0
        self.extra_s = extra_s
        self._pieces: deque[_Piece] = deque()
        self._free_s = -math.inf

    def push(self, data: bytes, now_s: float) -> None:
        """Put bytes on the line, behind those that are still under way."""
        if not data:
            return
        start_s = max(now_s, self._free_s)
        piece = _Piece(bytes(data), start_s, BITS_A_BYTE * self.bit_s + self.extra_s)
        self._pieces.append(piece)
        self._free_s = piece.end_s

    def pull(self, now_s: float) -> bytes:
        """Take the bytes that have arrived whole by now."""
        return b"".join(self.pull_each(now_s))

    def pull_each(self, now_s: float) -> list[bytes]:
        """Take them apart as they were pushed."""
        taken: list[bytes] = []
        while self._pieces:
            piece = self._pieces[0]
            count = piece.arrived(now_s)
            if count:
                taken.append(piece.data[:count])
            if count < len(piece.data):
                piece.data = piece.data[count:]
                piece.start_s += count * piece.byte_s
                break
            self._pieces.popleft()
        return taken

    @property
    def waiting(self) -> int:
        """How many bytes are still under way, or were not taken yet."""
        return sum(len(piece.data) for piece in self._pieces)

    def next_s(self) -> float:
        """Tell when the bytes of the oldest `push` will all have arrived; infinity when idle.

        One moment for each push, not one for each byte: a whole line is what a reader waits for.
        """
        return self._pieces[0].end_s if self._pieces else math.inf

    def clear(self) -> None:
        """Lose what is under way."""
        self._pieces.clear()
        self._free_s = -math.inf
