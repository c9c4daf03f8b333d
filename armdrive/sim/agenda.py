"""Things that somebody wants done to a simulated device at stated times."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable

Action = Callable[[], None]


class Agenda:
    """Actions by their time in seconds; of two at the same time the one added first goes first."""

    def __init__(self) -> None:
        self._entries: list[tuple[float, int, Action]] = []
        self._number = itertools.count()

    @property
    def next_s(self) -> float:
        """When the next action is due; infinity while there is none."""
        return self._entries[0][0] if self._entries else math.inf

    def add(self, time_s: float, action: Action) -> None:
        """Have something done at a time."""
        heapq.heappush(self._entries, (time_s, next(self._number), action))

    def pop(self) -> Action:
        """Take the next action out."""
        return heapq.heappop(self._entries)[2]
