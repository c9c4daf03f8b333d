"""A CAN bus on simulated time: one frame at a time, the lowest id first, at the bit rate.

Times are in seconds on whatever clock the caller keeps; python-can has no part in it.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from enum import Enum

from armdrive.transports.can_timing import frame_bits
from firmware_protocol.frames import Frame


class Side(Enum):
    """Who has sent a frame."""

    HOST = "host"
    DEVICE = "device"


@dataclass(frozen=True, slots=True)
class Arrival:
    """A frame that everybody on the bus has heard, and when."""

    frame: Frame
    sender: Side
    time_s: float


@dataclass(frozen=True, slots=True)
class _Waiting:
    frame: Frame
    sender: Side
    ready_s: float


class FrameWire:
    """The bus: whoever sends waits until it is free, and for those with lower ids.

    Frames of one node with one id keep their order. Those of a host leave one after the other,
    as from the queue of its adapter; nodes have a queue each, told apart by the id they send with.
    """

    def __init__(self, bitrate: int) -> None:
        self.bit_s = 1.0 / bitrate
        self.busy_s = 0.0
        """For how long the bus has carried frames altogether."""
        self._queues: dict[tuple[Side, int], deque[_Waiting]] = {}
        self._now: tuple[_Waiting, float] | None = None
        self._free_s = -math.inf
        self._arrived: list[Arrival] = []

    def push(self, frame: Frame, sender: Side, now_s: float) -> None:
        """Hand a frame to its sender's controller, which sends it as soon as it may."""
        self._run(now_s)
        lane = (sender, -1 if sender is Side.HOST else frame.can_id)
        self._queues.setdefault(lane, deque()).append(_Waiting(frame, sender, now_s))
        self._begin()

    def pull(self, now_s: float) -> list[Arrival]:
        """Take the frames that have passed whole by now, in their order."""
        self._run(now_s)
        arrived, self._arrived = self._arrived, []
        return arrived

    def next_s(self) -> float:
        """Tell when the next frame has passed; infinity while the bus is silent."""
        if self._arrived:
            return self._arrived[0].time_s
        return self._now[1] if self._now else math.inf

    @property
    def waiting(self) -> int:
        """How many frames are under way or wait to be sent."""
        return sum(map(len, self._queues.values())) + (self._now is not None)

    def waiting_of(self, sender: Side) -> int:
        """Return how many of one side's are."""
        queued = sum(len(queue) for (side, _), queue in self._queues.items() if side is sender)
        return queued + (self._now is not None and self._now[0].sender is sender)

    def clear(self, sender: Side | None = None) -> None:
        """Lose what waits, of one side or of both; what is on the bus is cut off."""
        for lane in [each for each in self._queues if sender in (None, each[0])]:
            del self._queues[lane]
        if self._now and sender in (None, self._now[0].sender):
            self._now = None

    def _run(self, now_s: float) -> None:
        while self._now is not None and self._now[1] <= now_s:
            sent, end_s = self._now
            self._arrived.append(Arrival(sent.frame, sent.sender, end_s))
            self._now, self._free_s = None, end_s
            self._begin()

    def _begin(self) -> None:
        """Let the frame with the lowest id of those that wait have the bus, if it is free."""
        if self._now is not None or not self._queues:
            return
        heads = [queue[0] for queue in self._queues.values()]
        won = heads[0]
        start_s = max(self._free_s, won.ready_s)
        if len(heads) > 1:
            start_s = max(self._free_s, min([each.ready_s for each in heads]))
            able = [each for each in heads if each.ready_s <= start_s]
            won = able[0] if len(able) == 1 else min(able, key=lambda each: _priority(each.frame))
        lane = (won.sender, -1 if won.sender is Side.HOST else won.frame.can_id)
        self._queues[lane].popleft()
        if not self._queues[lane]:
            del self._queues[lane]
        length_s = frame_bits(won.frame) * self.bit_s
        self.busy_s += length_s
        self._now = won, start_s + length_s


def _priority(frame: Frame) -> tuple[int, int, int, int]:
    """Return what arbitration goes by: a dominant bit wins, so the lower the earlier."""
    base = frame.can_id >> 18 if frame.extended else frame.can_id
    rest = frame.can_id & 0x3FFFF if frame.extended else 0
    return base, int(frame.extended), rest, int(frame.remote)
