"""Questions to MKS drives that were given up: what answers them yet is late, and no oddity.

A busy computer hears an answer after it has asked again, and then two answers come.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

LATEST_S = 5.0
"""An answer that comes later than this was not lost on its way."""


@dataclass(slots=True)
class Owed:
    """When each question was given up, by the drive and the code of its answer. Seconds."""

    _since_s: dict[tuple[int, int], deque[float]] = field(default_factory=dict)

    def give_up(self, node: int, code: int, now_s: float) -> None:
        """Take note that an answer is not waited for any more."""
        self._since_s.setdefault((node, code), deque(maxlen=16)).append(now_s)

    def takes(self, node: int, code: int, now_s: float) -> bool:
        """Tell whether an answer too many is a late one, which it is then no longer."""
        given_up = self._since_s.get((node, code))
        while given_up:
            if now_s <= given_up.popleft() + LATEST_S:
                return True
        return False
