"""A CAN bus on simulated time: one frame at a time, the lowest id first, at the bit rate.

The host's end carries packed frames, so the engine and the recorder are those of every wire. Times
are in seconds on the caller's clock. python-can is not used.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from armdrive.sim.wire import DeviceLine, WireDevice, WireDirection
from armdrive.transports.address import BITRATE
from armdrive.transports.can_health import frame_bits, left_bus
from firmware_protocol.frames import Frame, Unpacker, pack


class BusFrame(NamedTuple):
    """A frame on the bus, or one that waits for it."""

    frame: Frame
    to_device: bool

    @property
    def priority(self) -> int:
        """The bits that decide which frame goes first: the lowest number does."""
        return self.frame.can_id >> 18 if self.frame.extended else self.frame.can_id


@dataclass(slots=True)
class AdapterFaults:
    """Faults of the host's CAN adapter or its bus; all off by default."""

    bus_off: bool = False
    """Its controller has left the bus, until the channel is closed and opened again."""
    alone: bool = False
    """No other node acknowledges frames."""
    mute: bool = False
    """The adapter answers no command except `V`, like the CANable's first firmware."""
    dead: bool = False
    """The adapter hangs and sends nothing at all."""


class BusLine(DeviceLine):
    """A line over a bus to simulated drives: all the drives of an arm are one device.

    The device gets each frame at the moment when it has passed. Each frame is one message of the
    fault lanes.
    """

    def __init__(
        self,
        device: WireDevice,
        bitrate: int = BITRATE,
        adapter: AdapterFaults | None = None,
    ) -> None:
        super().__init__(device, None)
        self._bitrate = bitrate
        self._waiting: list[BusFrame] = []
        self._passing: BusFrame | None = None
        self._passed_s = math.inf
        """When the frame on the bus has passed."""
        self.adapter = adapter or AdapterFaults()
        self._of_host = Unpacker()
        self._unread: list[tuple[float, bytes]] = []

    @property
    def pace(self) -> str:
        """The speed of the bus, in words."""
        return f"on a CAN bus at {self._bitrate // 1000} kbit/s"

    @property
    def trouble(self) -> str:
        """Why the host is cut off, if its controller has left the bus."""
        if not self.adapter.bus_off:
            return ""
        return left_bus("bus-off: it saw too many errors")

    @property
    def backlog(self) -> int:
        """How many frames of the host are still to pass."""
        return sum(each.to_device for each in (self._passing, *self._waiting) if each)

    def send(self, data: bytes, now_s: float) -> None:
        """Give the host's frames to its adapter; an incomplete frame waits for the rest."""
        self.advance(now_s)
        for frame in self._of_host.feed(data):
            if self._on_bus:
                self._pass(self.faults.host, (frame,), now_s)

    def receive(self, now_s: float) -> bytes:
        """Return the frames that have reached the host by now."""
        self.advance(now_s)
        if not self._unread:
            return b""
        taken, self._unread = self._unread, []
        return b"".join([data for _, data in taken])

    def next_s(self) -> float:
        """Return when something next happens on either side; infinity while all is quiet."""
        return self._unread[0][0] if self._unread else self._due_s()

    def readable_s(self) -> float:
        """Return when the first unread frame reached the host; infinity without one."""
        return self._unread[0][0] if self._unread else math.inf

    def unplug(self) -> None:
        """Pull the adapter out: its waiting frames are lost; the drives go on."""
        super().unplug()
        self._of_host = Unpacker()
        self._lose_frames()

    def say(self, data: bytes, now_s: float) -> None:
        """Let the host read bytes that no drive has sent: noise from its adapter."""
        if self._on_bus:
            self._unread.append((now_s, data))

    def reopen(self) -> None:
        """Open the adapter again, which brings its controller back to the bus."""
        self.leave_bus(off=False)

    def leave_bus(self, off: bool = True) -> None:
        """Make the host's controller go bus-off, or come back; its waiting frames are lost."""
        self.adapter.bus_off = off
        if off:
            self._lose_frames()

    @property
    def _on_bus(self) -> bool:
        return self._plugged and not self.adapter.bus_off

    def _lose_frames(self) -> None:
        """Drop the frames in the host's adapter; one on the bus is cut off, which frees the bus."""
        self._waiting = [each for each in self._waiting if not each.to_device]
        self._unread.clear()
        if self._passing and self._passing.to_device:
            self._begin(self._advanced_s)

    def _due_s(self) -> float:
        return min(self._passed_s, self.device.next_s(), self.faults.late.next_s)

    def _carry(self, lane: WireDirection, message: tuple[Frame, ...], now_s: float) -> None:
        self._waiting += [BusFrame(frame, lane is self.faults.host) for frame in message]
        if self._passing is None:
            self._begin(now_s)

    def _begin(self, now_s: float) -> None:
        """Give the free bus to the waiting frame with the lowest id.

        The host's adapter sends its frames in their order, whatever their ids.
        """
        ready = [each for each in self._waiting if not each.to_device]
        ready += [each for each in self._waiting if each.to_device][:1]
        self._passing = min(ready, key=lambda each: each.priority, default=None)
        self._passed_s = math.inf
        if self._passing is not None:
            self._waiting.remove(self._passing)
            self._passed_s = now_s + frame_bits(self._passing.frame) / self._bitrate

    def _deliver(self, now_s: float) -> None:
        """Give the drives the frames of the host, and the host those of the drives."""
        while self._passing is not None and self._passed_s <= now_s:
            passed = self._passing
            self._begin(self._passed_s)
            if passed.to_device:
                self.device.receive((passed.frame,), now_s)
            elif self._on_bus:
                self._unread.append((now_s, pack(passed.frame)))

    def _answer(self, sent: tuple[Frame, ...], now_s: float) -> None:
        for frame in sent:
            self._pass(self.faults.device, (frame,), now_s)
