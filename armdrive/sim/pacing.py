"""A simulated device behind its serial line: both directions paced, events taken in their order."""

from __future__ import annotations

import re

from armdrive.sim.device import WireDevice
from armdrive.sim.wire import PacedWire
from armdrive.sim.wire_faults import WireFaults

_LINES = re.compile(rb"[^\r\n]*[\r\n]|[^\r\n]+")


class PacedDevice:
    """Carries bytes to a device and back at a baud rate, or at once where there is none.

    Time may be advanced in steps of any size: what happens in between happens at its own moment,
    so that an answer is as late as it would be if somebody had looked all the time. Of lines that
    are put on a paced line at once, each arrives at its own moment.
    """

    def __init__(self, device: WireDevice, baud: int | None) -> None:
        self.device = device
        self.faults = WireFaults()
        self._paced = bool(baud)
        self._in = PacedWire(baud)
        self._out = PacedWire(baud)
        self._plugged = True

    @property
    def backlog(self) -> int:
        """How many bytes are still on their way to the device."""
        return self._in.waiting

    def send(self, data: bytes, now_s: float) -> None:
        """Put bytes on the line to the device."""
        self.advance(now_s)
        if self._plugged:
            for piece in self.faults.host.passed(data, now_s):
                self._push(piece, now_s)

    def receive(self, now_s: float) -> bytes:
        """Take what has come back by now."""
        self.advance(now_s)
        return self._out.pull(now_s)

    def advance(self, now_s: float) -> None:
        """Let everything happen that is due by now."""
        while (due_s := self._due_s()) < now_s:
            self._exchange(due_s)
        self._exchange(now_s)

    def next_s(self) -> float:
        """Tell when something next happens on either side; infinity while all is quiet."""
        return min(self._due_s(), self._out.next_s())

    def unplug(self) -> None:
        """Pull the cable: what is under way is lost in both directions; the device lives on."""
        self._plugged = False
        self._in.clear()
        self._out.clear()
        self.faults.lose_late()

    def replug(self, now_s: float) -> None:
        """Put the cable back; what the device said meanwhile went nowhere."""
        self.advance(now_s)
        self.plug()

    def plug(self) -> None:
        """Put the cable back at the device's present moment."""
        self._plugged = True

    def say(self, data: bytes, now_s: float) -> None:
        """Put bytes on the line to the host that the device itself never sent."""
        if self._plugged:
            self._out.push(data, now_s)

    def _push(self, data: bytes, now_s: float) -> None:
        for line in _LINES.findall(data) if self._paced else (data,):
            self._in.push(line, now_s)

    def _due_s(self) -> float:
        """Tell when something next happens that is more than an arrival at the host."""
        return min(self._in.next_s(), self.device.next_s(), self.faults.next_s)

    def _exchange(self, now_s: float) -> None:
        for late in self.faults.host.due(now_s):
            self._push(late, now_s)
        for arrived in self._in.pull_each(now_s):
            self.device.receive(arrived, now_s)
        said = self.device.transmit(now_s)
        pieces = self.faults.device.due(now_s)
        if said and self._plugged:
            pieces += self.faults.device.passed(said, now_s)
        for piece in pieces:
            self._out.extra_s = self.device.byte_gap_s
            self._out.push(piece, now_s)
