"""A CAN bus on simulated time: one frame at a time, the lowest id first, at the bit rate.

The host's end carries packed frames, so the engine and the recorder are those of every wire. Times
are in seconds on the caller's clock. python-can is not used.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections import defaultdict, deque
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from armdrive.sim.wire import DeviceLine, TimeQueue, WireDevice, WireDirection
from armdrive.transports.address import BITRATE
from armdrive.transports.can_health import frame_bits, left_bus
from firmware_protocol.frames import Frame, Unpacker, pack


class BusSide(Enum):
    """The sender of a frame."""

    HOST = "host"
    DEVICE = "device"


class Transmission(NamedTuple):
    """A frame on the bus; it has passed at `time_s`."""

    frame: Frame
    sender: BusSide
    time_s: float


class FrameBus:
    """The bus: a sender waits until it is free and frames with lower ids have passed.

    The host's adapter sends its frames in their order, whatever their ids. A node offers all that
    it has to send; frames with one id keep their order. Pull up to a time before pushing at it.
    """

    def __init__(self, bitrate: int) -> None:
        self.bit_s = 1.0 / bitrate
        self._of_host: deque[Frame] = deque()
        self._of_nodes: list[tuple[int, int, Frame]] = []
        """A heap by priority; frames with one id keep their order by their number."""
        self._number = itertools.count()
        self._now: Transmission | None = None

    def push(self, frame: Frame, sender: BusSide, now_s: float) -> None:
        """Give a frame to its sender's controller, which sends it as soon as the bus allows."""
        if sender is BusSide.HOST:
            self._of_host.append(frame)
        else:
            heapq.heappush(self._of_nodes, (_priority(frame), next(self._number), frame))
        if self._now is None:
            self._begin(now_s)

    def pull(self, now_s: float) -> list[Transmission]:
        """Return the frames that have passed completely by now, in order."""
        passed = []
        while self._now is not None and self._now.time_s <= now_s:
            passed.append(self._now)
            self._now = None
            if self._of_host or self._of_nodes:
                self._begin(passed[-1].time_s)
        return passed

    def next_s(self) -> float:
        """Return when the next frame will have passed; infinity while the bus is silent."""
        return math.inf if self._now is None else self._now.time_s

    def waiting_of(self, sender: BusSide) -> int:
        """Return how many frames of one side are on the bus or waiting."""
        under_way = self._now is not None and self._now.sender is sender
        return len(self._waiting(sender)) + under_way

    def clear(self, sender: BusSide, now_s: float) -> None:
        """Drop the frames that one side has to send; one on the bus is cut off, which frees it."""
        self._waiting(sender).clear()
        if self._now and self._now.sender is sender:
            self._now = None
            if self._of_host or self._of_nodes:
                self._begin(now_s)

    def _waiting(self, sender: BusSide) -> deque[Frame] | list[tuple[int, int, Frame]]:
        return self._of_host if sender is BusSide.HOST else self._of_nodes

    def _begin(self, now_s: float) -> None:
        """Give the free bus to the waiting frame with the lowest id."""
        nodes, host = self._of_nodes, self._of_host
        if nodes and not (host and _priority(host[0]) < nodes[0][0]):
            frame, sender = heapq.heappop(nodes)[2], BusSide.DEVICE
        else:
            frame, sender = host.popleft(), BusSide.HOST
        self._now = Transmission(frame, sender, now_s + frame_bits(frame) * self.bit_s)


def _priority(frame: Frame) -> int:
    """Return the bits of arbitration: a dominant one wins, so the lowest number goes first."""
    base, rest = (frame.can_id, 0) if not frame.extended else divmod(frame.can_id, 1 << 18)
    return base << 20 | frame.extended << 19 | rest << 1 | frame.remote


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
        self.bus = FrameBus(bitrate)
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
        return self.bus.waiting_of(BusSide.HOST)

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
        self._unread.clear()
        self.bus.clear(BusSide.HOST, self._advanced_s)

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
            self.bus.clear(BusSide.HOST, self._advanced_s)
            self._unread.clear()

    @property
    def _on_bus(self) -> bool:
        return self._plugged and not self.adapter.bus_off

    def _due_s(self) -> float:
        return min(self.bus.next_s(), self.device.next_s(), self.faults.late.next_s)

    def _carry(self, lane: WireDirection, message: tuple[Frame, ...], now_s: float) -> None:
        sender = BusSide.HOST if lane is self.faults.host else BusSide.DEVICE
        for frame in message:
            self.bus.push(frame, sender, now_s)

    def _deliver(self, now_s: float) -> None:
        """Give the drives the frames of the host, and the host those of the drives."""
        for passed in self.bus.pull(now_s):
            if passed.sender is BusSide.HOST:
                self.device.receive((passed.frame,), now_s)
            elif self._on_bus:
                self._unread.append((now_s, pack(passed.frame)))

    def _answer(self, sent: tuple[Frame, ...], now_s: float) -> None:
        for frame in sent:
            self._pass(self.faults.device, (frame,), now_s)


# --- Frames on their way from the drives to the bus ----------------------------------------------
#
# Several drives of one id answer the same question, some microseconds apart: longer than a bit (a
# guess; no two firmwares were measured side by side). So the first one's frame passes alone. The
# others wait for its end and begin in the very same bit (Bosch, CAN 2.0 B, 3.2.5: a pending message
# is started in the first bit after intermission). Arbitration sees only ids, so they overlap. Equal
# frames pass as one. Different frames destroy each other until one drive's controller has counted
# enough errors to yield; then they come late and one after the other.

# Sixteen tries of a frame at 500 kbit/s, which make a controller error-passive (ISO 11898-1).
COLLISION_S = 0.004


class ReadyFrame(NamedTuple):
    """A frame that a drive has ready; it may have `waited` for the same id to pass."""

    drive: int
    frame: Frame
    waited: bool = False


class Outbox(TimeQueue[ReadyFrame]):
    """The frames of drives, by the time at which each is ready."""

    def __init__(self, bits_s: int) -> None:
        super().__init__()
        self._bits_s = bits_s

    def take(self, now_s: float) -> list[Frame]:
        """Return the frames that are ready by now."""
        ready: list[Frame] = []
        while (ready_s := self.next_s) <= now_s:
            together = [self.pop()]
            while self.next_s == ready_s:
                together.append(self.pop())
            if len({one.frame.can_id for one in together}) == len(together):
                ready += [one.frame for one in together]
            else:
                ready += self._passing(together, now_s)
        return ready

    def _passing(self, together: list[ReadyFrame], now_s: float) -> list[Frame]:
        """Return the frames that pass, out of several that are ready at once and share ids."""
        by_id: defaultdict[int, defaultdict[int, list[ReadyFrame]]]
        by_id = defaultdict(lambda: defaultdict(list))
        for one in together:
            by_id[one.frame.can_id][one.drive].append(one)
        ready: list[Frame] = []
        for first, *others in (list(drives.values()) for drives in by_id.values()):
            frames = [one.frame for one in first]
            if not all(one.waited for one in first):
                ready += frames
                ends_s = now_s + sum(map(frame_bits, frames)) / self._bits_s
                for one in itertools.chain(*others):
                    self.put(ends_s, one._replace(waited=True))
            elif all([one.frame for one in other] == frames for other in others):
                ready += frames
            else:
                for number, each in enumerate((first, *others), 1):
                    for one in each:
                        self.put(now_s + number * COLLISION_S, one)
        return ready
