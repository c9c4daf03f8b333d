"""The interfaces of the two ends of a wire, and what every link needs: a bell, and an absent link.

A link is handed the engine's clock, so that simulated time and real time look alike to it.
"""

from __future__ import annotations

import contextlib
import math
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
        """Tell when the wire next has something by itself; infinity, since nobody knows it."""
        return math.inf

    def wait(self, timeout_s: float) -> None:
        """Sleep until bytes arrive, `wake` is called, or the time is over (real time only)."""

    def wake(self) -> None:
        """End a `wait` early, from any thread."""

    def close(self) -> None:
        """Give the wire back. Closing twice is no error."""


class ByteLine(Protocol):
    """The far end of a link within this process: a device, and the line that paces its bytes."""

    @property
    def pace(self) -> str:
        """How fast bytes travel, for people: `at 9600 baud`; empty where they arrive at once."""

    @property
    def trouble(self) -> str:
        """Why the host is cut off although its cable is in; empty while it is not."""

    def send(self, data: bytes, now_s: float) -> None:
        """Put bytes on the line to the device."""

    def receive(self, now_s: float) -> bytes:
        """Take what has come back by now."""

    def advance(self, now_s: float) -> None:
        """Let everything happen that is due by now."""

    def next_s(self) -> float:
        """Tell when something next happens on either side; infinity while all is quiet."""

    def readable_s(self) -> float:
        """Return when the host next has bytes to read, by what is on its way; else infinity."""

    def unplug(self) -> None:
        """Pull the cable: what is under way is lost in both directions."""

    def replug(self, now_s: float) -> None:
        """Put the cable back."""

    def reopen(self) -> None:
        """Begin again, as the host opens its port again: a controller comes back to its bus."""


_ENOUGH = 4096


class Bell:
    """Ends a sleep on files, from any thread or a signal handler: ringing takes no lock.

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


class AbsentLink(Link):
    """A `Link` in place of a wire that is gone: it can only wait."""

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

    def wait(self, timeout_s: float) -> None:
        """Sleep until `wake` is called, or the time is over."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Give up waiting."""
        self._bell.close()
