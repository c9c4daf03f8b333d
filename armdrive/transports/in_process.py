"""A wire within this process. One end is the engine's; the other end is a line to some device.

It runs on the clock that the engine passes in, simulated or real. The line sets the pace.
"""

from __future__ import annotations

from typing import Generic, TypeVar

from armdrive.errors import LinkLost, NoSuchPort
from armdrive.transports.link import Bell, ByteLine

L = TypeVar("L", bound=ByteLine)
MOST_EVENTS = 100
"""A host looks after so many events at the latest; where time does not pass, it finds that out."""


class MemoryLink(Generic[L]):
    """A `Link` over a line in this process. Only one thread may use it.

    `wake`, `unplug` and `replug` are the exceptions: any thread may call them.
    """

    def __init__(self, line: L, name: str) -> None:
        """Take a line; `name` is what stands at its far end, for people."""
        self._line = line
        self._name = name
        self._bell = Bell()
        self._plugged = True
        self._connected = True
        self._closed = False
        self._woken = False

    @property
    def line(self) -> L:
        """The line that carries the bytes; its faults are the wire's."""
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
        """Tell when bytes arrive at either end or the device does something next."""
        return self._line.next_s()

    def run(self, until_s: float) -> float:
        """Let the device act by itself while its host has nothing to read, at most until a moment.

        Returns when the host has to look: at that moment, or earlier for bytes, for a `wake`, or
        for a wire that was lost. On simulated time a host need not look at everything between.
        """
        for _ in range(MOST_EVENTS):
            next_s = self.next_s()
            if next_s >= until_s:
                return until_s
            cut_off = not (self._plugged and self._connected) or self._closed
            if cut_off or self._line.readable_s() <= next_s:
                break
            self._line.advance(next_s)
            if self._woken or self._line.trouble:
                self._woken = False
                break
        return next_s

    def wait(self, timeout_s: float) -> None:
        """Sleep until `wake` is called or the time is over (real time only)."""
        self._bell.wait(timeout_s)

    def wake(self) -> None:
        """End a `wait` or a `run` early, from any thread."""
        self._woken = True
        self._bell.ring()

    def unplug(self) -> None:
        """Pull the cable: from now on `LinkLost`, and what is under way never arrives."""
        self._plugged = False
        self.wake()

    def replug(self, name: str | None = None) -> None:
        """Put the cable back, as a wire of another name perhaps.

        What the device said meanwhile is lost.
        """
        self._name = self._name if name is None else name
        self._plugged = True
        self.wake()

    def reopen(self) -> MemoryLink[L]:
        """Take the wire up again after `close`. Raises `NoSuchPort` while it is unplugged."""
        if not self._plugged:
            raise NoSuchPort(f"the cable to the {self._name} is unplugged: plug it in")
        if self._closed:
            self._closed, self._bell = False, Bell()
        self._line.reopen()
        return self

    def close(self) -> None:
        """Give the wire back; the device stays as it is."""
        self._closed = True
        self._bell.close()

    def _check(self, now_s: float) -> None:
        """Act on a cable that was pulled or put back, on the thread that owns the line."""
        if self._closed:
            raise LinkLost(f"the wire to the {self._name} is closed: connect again")
        if not self._plugged:
            self._line.unplug()
            self._connected = False
            self._line.advance(now_s)  # the device lives on, and may have its cable put back
            raise LinkLost(
                f"the cable to the {self._name} is unplugged: plug it in and connect again"
            )
        if not self._connected:
            self._line.replug(now_s)
            self._connected = True
        if trouble := self._line.trouble:
            self._line.advance(now_s)  # the device lives on
            raise LinkLost(f"the adapter of the {self._name} {trouble}")
