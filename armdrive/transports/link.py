"""The one face of every wire: what the engine asks of a serial port, a socket or a simulated one.

The engine passes its own clock in, so that a wire on simulated time and a real one look alike.
"""

from __future__ import annotations

import contextlib
import select
import socket
from typing import Protocol

from armdrive.errors import LinkLost


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


# A bell that ends a sleep on files: for threads and signal handlers that have something to say.

_ENOUGH = 4096


class Bell:
    """Ends a sleep, from any thread or a signal handler: ringing takes no lock.

    Its sockets are made at the first sleep, so that a bell nobody sleeps on costs nothing.
    """

    def __init__(self) -> None:
        self._rung = False
        self._ends: tuple[socket.socket, socket.socket] | None = None
        self._closed = False

    def ring(self) -> None:
        """End the present sleep, or the next one."""
        self._rung = True  # before looking for the sockets: a sleep looks in the other order
        ends = self._ends
        if ends is not None:
            with contextlib.suppress(OSError):  # full: it rings already; closed: nobody sleeps
                ends[1].send(b"!")

    def wait(self, timeout_s: float, *files: int) -> None:
        """Sleep until one of the files is readable, the bell rings, or the time is over."""
        if self._closed:
            return
        ear = self._ear()
        pause_s = 0.0 if self._rung else max(timeout_s, 0.0)
        ready, _, _ = select.select([*files, ear.fileno()], [], [], pause_s)
        self._rung = False
        if ear.fileno() in ready:
            with contextlib.suppress(BlockingIOError):
                ear.recv(_ENOUGH)

    def close(self) -> None:
        """Give the sockets back."""
        self._closed = True
        ends, self._ends = self._ends, None
        for end in ends or ():
            end.close()

    def _ear(self) -> socket.socket:
        if self._ends is None:
            ends = socket.socketpair()
            for end in ends:
                end.setblocking(False)
            self._ends = ends
        return self._ends[0]


# What stands in a wire's place while it is gone: nothing can be said or heard, only waited.


class AbsentLink:
    """A `Link` without a wire."""

    def __init__(self, description: str) -> None:
        """`description` is what the wire was called."""
        self._description = description
        self._bell = Bell()

    @property
    def description(self) -> str:
        """Name the wire that is gone."""
        return self._description

    def write(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 - as any link
        """Raise `LinkLost`."""
        raise LinkLost(f"there is no wire in place of {self._description}: connect again")

    def read(self, now_s: float) -> bytes:  # noqa: ARG002
        """Raise `LinkLost`."""
        raise LinkLost(f"there is no wire in place of {self._description}: connect again")

    def next_s(self) -> float:
        """Return infinity: nothing comes."""
        return float("inf")

    def wait(self, timeout_s: float) -> None:
        """Sleep until `wake` is called, or the time is over."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Give up waiting."""
        self._bell.close()
