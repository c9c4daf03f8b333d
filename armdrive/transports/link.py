"""The one face of every wire: what the engine asks of a serial port, a socket or a simulated one.

The engine passes its own clock in, so that a wire on simulated time and a real one look alike.
"""

from __future__ import annotations

from typing import Protocol


class Link(Protocol):
    """A byte wire to one controller. Only the engine's thread calls it, except for `wake`."""

    @property
    def description(self) -> str:
        """Name the wire for people, for example `/dev/ttyUSB0 at 9600 baud`."""

    def write(self, data: bytes, now_s: float) -> None:
        """Send bytes. Raises `LinkLost` when the wire is gone."""

    def read(self, now_s: float) -> bytes:
        """Return what has arrived by now, possibly nothing. Raises `LinkLost`."""

    def next_s(self) -> float:
        """Tell when the wire next has something by itself; infinity where it cannot be known."""

    def wait(self, timeout_s: float) -> None:
        """Sleep until bytes arrive, `wake` is called, or the time is over (real time only)."""

    def wake(self) -> None:
        """End a `wait` early, from any thread."""

    def close(self) -> None:
        """Give the wire back. Closing twice is no error."""
