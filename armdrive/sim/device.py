"""The face of every simulated controller: bytes in, bytes out, on a clock that is handed to it."""

from __future__ import annotations

from typing import Protocol


class SimDevice(Protocol):
    """The device side of a dialect together with the physical arm that it moves."""

    @property
    def byte_gap_s(self) -> float:
        """How long the device pauses after each byte that it sends, beyond the baud rate's time."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that have arrived at the device by now."""

    def transmit(self, now_s: float) -> bytes:
        """Advance the arm to now and return the bytes that it has to say since the last call."""

    def next_s(self) -> float:
        """Tell when the device next does something by itself; infinity while it only waits."""
