"""A link within this process, from the engine to the line of a simulated device.

The link runs on the time that the engine passes in, simulated or real. The line sets the baud rate.
"""

from __future__ import annotations

from typing import Generic, TypeVar

from armdrive.errors import LinkLost, NoSuchPort
from armdrive.transports.link import Bell, ByteLine

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

    def reopen(self) -> MemoryLink[L]:
        """Open the link again after `close`. Raises `NoSuchPort` while unplugged."""
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

    def _check(self, now_s: float) -> None:
        """Pass a pulled or replugged cable on to the line, on the thread that owns the line."""
        if self._closed:
            raise LinkLost(f"the wire to the {self._name} is closed: connect again")
        if not self._plugged:
            self._line.unplug()
            self._connected = False
            self._line.advance(now_s)  # the device keeps running, and may be plugged in again
            raise LinkLost(
                f"the cable to the {self._name} is unplugged: plug it in and connect again"
            )
        if not self._connected:
            self._line.replug(now_s)
            self._connected = True
        if trouble := self._line.trouble:
            self._line.advance(now_s)  # the device keeps running
            raise LinkLost(f"the adapter of the {self._name} {trouble}")
