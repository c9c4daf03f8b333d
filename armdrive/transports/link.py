"""Links: the interface, the bell that wakes one, and one that is absent.

A link is passed the engine's time, so that simulated and real time look alike to it.
"""

from __future__ import annotations

import contextlib
import math
import select
import socket
from typing import Protocol

from armdrive.errors import LinkLost


class Link(Protocol):
    """A byte stream to one controller. Only the engine's thread uses it, except for `wake`."""

    @property
    def description(self) -> str:
        """A readable name of the link, for example `/dev/ttyUSB0 at 9600 baud`."""

    def write(self, data: bytes, now_s: float) -> None:
        """Send bytes. Raises `LinkLost` if the link is gone."""

    def read(self, now_s: float) -> bytes:
        """Return what has arrived by now, possibly nothing. Raises `LinkLost`."""

    def next_s(self) -> float:
        """Return when the next bytes will arrive; infinity, as a real link cannot know."""
        return math.inf

    def run(self, until_s: float) -> float:
        """Run the device until `until_s`, or until the host has something to do; return that time.

        Simulated time only: the host skips all calls in between, which would do nothing. By default
        the host is called whenever `next_s` says.
        """
        return min(self.next_s(), until_s)

    def wait(self, timeout_s: float) -> None:
        """Sleep until bytes arrive, `wake` is called, or the timeout (real time only)."""

    def wake(self) -> None:
        """End a `wait` early, from any thread."""

    def close(self) -> None:
        """Release the link. May be called twice."""


def lost_link(wire: str, why: str, todo: str) -> LinkLost:
    """Return the error for a lost `wire`, such as "the connection on COM3"; `todo` comes first."""
    return LinkLost(
        f"{wire} was lost ({why}). The arm moves on for at most the time and distance that its "
        f"status announces; {todo}, then call `reconnect()`"
    )


def closed_link(wire: str) -> LinkLost:
    """Return the error for the use of a `wire` that this program has closed or given up."""
    return LinkLost(f"{wire} was closed: connect again")


_CHUNK = 4096


class Bell:
    """Ends a sleep on files, from any thread or a signal handler: ringing takes no lock.

    The sockets are created at the first sleep, so that an unused bell costs nothing.
    """

    def __init__(self) -> None:
        self._rung = False
        self._ends: tuple[socket.socket, socket.socket] | None = None
        self._closed = False

    def ring(self) -> None:
        """End the present sleep, or the next one."""
        self._rung = True  # before checking the sockets, as `wait` does both in the opposite order
        ends = self._ends
        if ends is not None:
            with contextlib.suppress(OSError):  # full: ringing already; closed: no thread sleeps
                ends[1].send(b"!")

    def wait(self, timeout_s: float, *files: int) -> None:
        """Sleep until one of the files is readable, the bell rings, or the timeout."""
        if self._closed:
            return
        receiver = self._receiver()
        pause_s = 0.0 if self._rung else max(timeout_s, 0.0)
        ready, _, _ = select.select([*files, receiver.fileno()], [], [], pause_s)
        self._rung = False
        if receiver.fileno() in ready:
            with contextlib.suppress(BlockingIOError):
                receiver.recv(_CHUNK)

    def close(self) -> None:
        """Close the sockets."""
        self._closed = True
        ends, self._ends = self._ends, None
        for end in ends or ():
            end.close()

    def _receiver(self) -> socket.socket:
        if self._ends is None:
            ends = socket.socketpair()
            for end in ends:
                end.setblocking(False)
            self._ends = ends
        return self._ends[0]


class AbsentLink(Link):
    """Stands in for a link that is gone: it can only wait."""

    def __init__(self, description: str) -> None:
        """`description` is the name of the lost link."""
        self._description = description
        self._bell = Bell()

    @property
    def description(self) -> str:
        """The name of the lost link."""
        return self._description

    def write(self, data: bytes, now_s: float) -> None:  # noqa: ARG002 - as any link
        """Raise `LinkLost`."""
        raise closed_link(f"the connection on {self._description}")

    def read(self, now_s: float) -> bytes:  # noqa: ARG002
        """Raise `LinkLost`."""
        raise closed_link(f"the connection on {self._description}")

    def wait(self, timeout_s: float) -> None:
        """Sleep until `wake` is called, or the timeout."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Close the bell."""
        self._bell.close()
