"""What simulated drives say on its way to their bus, and what happens to twins of an id.

Several drives of one id answer in the same moment. Frames that are alike lie on each other bit by
bit, and the host hears one; others destroy each other until one drive's controller has counted
so many errors that it yields, so that both come, late and one after the other.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections import defaultdict

from firmware_protocol.frames import Unpacker

COLLISION_S = 0.004
"""Sixteen tries of a frame at 500 kbit/s, which make a controller error-passive (ISO 11898-1)."""


class Outbox:
    """Frames by the time at which their drive has them ready."""

    def __init__(self) -> None:
        self._frames: list[tuple[float, int, int, bytes]] = []
        self._number = itertools.count()

    @property
    def next_s(self) -> float:
        """When the next frame is ready; infinity while there is none."""
        return self._frames[0][0] if self._frames else math.inf

    def put(self, ready_s: float, drive: int, data: bytes) -> None:
        """Have a drive say a frame at a time."""
        heapq.heappush(self._frames, (ready_s, next(self._number), drive, data))

    def take(self, now_s: float) -> bytes:
        """Return what comes to the bus by now."""
        said = b""
        while self.next_s <= now_s:
            together = self._together()
            if len(together) == 1:
                said += together[0][1]
            else:
                said += self._sorted_out(together, now_s)
        return said

    def clear(self) -> None:
        """Lose everything."""
        self._frames.clear()

    def _together(self) -> list[tuple[int, bytes]]:
        """Take all that are ready at the same moment as the next one."""
        ready_s, found = self.next_s, []
        while self.next_s == ready_s:
            _, _, drive, data = heapq.heappop(self._frames)
            found.append((drive, data))
        return found

    def _sorted_out(self, together: list[tuple[int, bytes]], now_s: float) -> bytes:
        """Return what passes of frames that are ready at once."""
        by_id: defaultdict[int, dict[int, list[bytes]]] = defaultdict(dict)
        for drive, data in together:
            (frame,) = Unpacker().feed(data)
            by_id[frame.can_id].setdefault(drive, []).append(data)
        said = b""
        for drives in by_id.values():
            first, *others = (b"".join(frames) for frames in drives.values())
            if all(other == first for other in others):
                said += first
                continue
            for number, (drive, frames) in enumerate(drives.items(), 1):
                for data in frames:
                    self.put(now_s + number * COLLISION_S, drive, data)
        return said
