"""Links: the interface, the bell that wakes one, an absent one, and one to a simulated line.

A link is passed the engine's time, so that simulated and real time look alike to it.
"""

from __future__ import annotations

import contextlib
import math
import select
import socket
from typing import Generic, Protocol, TypeVar

from armdrive.errors import LinkLost, NoSuchPort


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


class ByteLine(Protocol):
    """A simulated device, and the line that sends its bytes at a baud rate."""

    @property
    def pace(self) -> str:
        """The speed in words, `at 9600 baud`; empty if bytes arrive at once."""

    @property
    def trouble(self) -> str:
        """Why the host is cut off although the cable is plugged in; empty while it is not."""

    def send(self, data: bytes, now_s: float) -> None:
        """Send bytes to the device."""

    def receive(self, now_s: float) -> bytes:
        """Return the device's bytes that have arrived by now."""

    def advance(self, now_s: float) -> None:
        """Run the device up to now."""

    def exchange(self, now_s: float) -> None:
        """Do what is due at the time of the next event."""

    def next_s(self) -> float:
        """Return the time of the next event on either side; infinity if there is none."""

    def readable_s(self) -> float:
        """Return when the next bytes in transit reach the host; infinity if there are none."""

    def unplug(self) -> None:
        """Pull the cable: bytes in transit are lost in both directions."""

    def replug(self, now_s: float) -> None:
        """Plug the cable in again."""

    def reopen(self) -> None:
        """React to the host reopening its port: a CAN controller returns to its bus."""


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
        raise LinkLost(f"the connection on {self._description} is gone: connect again")

    def read(self, now_s: float) -> bytes:  # noqa: ARG002
        """Raise `LinkLost`."""
        raise LinkLost(f"the connection on {self._description} is gone: connect again")

    def wait(self, timeout_s: float) -> None:
        """Sleep until `wake` is called, or the timeout."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` early."""
        self._bell.ring()

    def close(self) -> None:
        """Close the bell."""
        self._bell.close()


# A link within this process, from the engine to the line of a simulated device. It runs on the time
# that the engine passes in, simulated or real. The line sets the baud rate.

L = TypeVar("L", bound=ByteLine)
MOST_EVENTS = 100
"""`run` returns after this many events, so that its caller notices a clock that stands still."""


class MemoryLink(Generic[L]):
    """A `Link` over a line in this process.

    Any thread may call `wake`, `unplug` and `replug`; everything else belongs to one thread.
    """

    def __init__(self, line: L, name: str) -> None:
        """Use a line; `name` is the readable name of the device at its far end."""
        self._line = line
        self._name = name
        self._bell = Bell()
        self._plugged = True
        self._connected = True
        self._closed = False
        self._woken = False

    @property
    def line(self) -> L:
        """The line that carries the bytes; its faults are those of the link."""
        return self._line

    @property
    def description(self) -> str:
        """Name the wire for people."""
        return f"{self._name} {self._line.pace}".rstrip()

    def write(self, data: bytes, now_s: float) -> None:
        """Send bytes. Raises `LinkLost` while unplugged."""
        self._check(now_s)
        self._line.send(data, now_s)

    def read(self, now_s: float) -> bytes:
        """Return what has arrived by now. Raises `LinkLost` while unplugged."""
        self._check(now_s)
        return self._line.receive(now_s)

    def next_s(self) -> float:
        """Return when bytes next arrive at either end, or the device next acts."""
        return self._line.next_s()

    def run(self, until_s: float) -> float:
        """Run the device until `until_s`, or until the host has something to do; return that time.

        The host has to act on received bytes, a `wake`, and a lost link. On simulated time it can
        skip all device events before that.
        """
        for _ in range(MOST_EVENTS):
            next_s = self.next_s()
            if next_s >= until_s:
                return until_s
            cut_off = not (self._plugged and self._connected) or self._closed
            if cut_off or self._line.readable_s() <= next_s:
                break
            self._line.exchange(next_s)
            if self._woken or self._line.trouble:
                self._woken = False
                break
        return next_s

    def wait(self, timeout_s: float) -> None:
        """Sleep until `wake` is called, or the timeout (real time only)."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` or a `run` early, from any thread."""
        self._woken = True
        self._bell.ring()

    def unplug(self) -> None:
        """Pull the cable: calls raise `LinkLost` from now on, and bytes in transit are lost."""
        self._plugged = False
        self.wake()

    def replug(self, name: str | None = None) -> None:
        """Plug the cable in again, optionally under another name.

        Everything that the device sent meanwhile is lost.
        """
        self._name = self._name if name is None else name
        self._plugged = True
        self.wake()

    def reopen(self, now_s: float | None = None) -> MemoryLink[L]:
        """Open the link again after `close`. Raises `NoSuchPort` while unplugged.

        The device has run on until `now_s`, when its cable may have been plugged in again.
        """
        if not self._plugged and now_s is not None:
            self._cut_off(now_s)
        if not self._plugged:
            raise NoSuchPort(f"the cable to the {self._name} is unplugged: plug it in")
        if self._closed:
            self._closed, self._bell = False, Bell()
        self._line.reopen()
        return self

    def close(self) -> None:
        """Release the link; the device keeps its state."""
        self._closed = True
        self._bell.close()

    def _cut_off(self, now_s: float) -> None:
        """Let the device run on without its host."""
        self._line.unplug()
        self._connected = False
        self._line.advance(now_s)

    def _check(self, now_s: float) -> None:
        """Pass a pulled or replugged cable on to the line, on the thread that owns the line."""
        if self._closed:
            raise LinkLost(f"the wire to the {self._name} is closed: connect again")
        if not self._plugged:
            self._cut_off(now_s)
            raise LinkLost(
                f"the cable to the {self._name} is unplugged: plug it in and connect again"
            )
        if not self._connected:
            self._line.replug(now_s)
            self._connected = True
        if trouble := self._line.trouble:
            self._line.advance(now_s)  # the device keeps running
            raise LinkLost(f"the adapter of the {self._name} {trouble}")
