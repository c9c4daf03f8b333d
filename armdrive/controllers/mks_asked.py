"""Of what moment the answer of an MKS drive is, and how fast the drive has been told to go lately.

An answer does not say which question it answers. It may be that to the oldest one still open, so a
reading is taken to be of any moment from then on.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

LOST_S = 0.3
"""What has not been answered for so long is not answered any more."""


@dataclass(slots=True)
class Questions:
    """When one drive was asked where it is, and where by its orders it was then; not yet answered.

    Counts, seconds.
    """

    asked_s: float = -math.inf
    """When what was read last was asked for, at the earliest."""
    asked_at: float = 0.0
    """Where it was then by its orders."""
    last_s: float = -math.inf
    """When it was asked last."""
    _open: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=16))

    def ask(self, place: float, now_s: float) -> None:
        """Take note that it is asked."""
        while self._open and self._open[0][0] < now_s - LOST_S:
            self._open.popleft()
        self._open.append((now_s, place))
        self.last_s = now_s

    def answered(self) -> None:
        """Take note that it has told where it is."""
        if self._open:
            self.asked_s, self.asked_at = self._open.popleft()

    def place_anew(self, place: float) -> None:
        """Have it be elsewhere than its orders said, in all that is unanswered as well."""
        self.asked_at = place
        self._open = deque(((asked_s, place) for asked_s, _ in self._open), maxlen=16)


@dataclass(slots=True)
class Speeds:
    """How fast one drive went, by its orders, until it was given each of the last ones."""

    _until: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=32))

    def change(self, before: float, now_s: float) -> None:
        """Take note of the speed, in counts a second, that ends now."""
        self._until.append((now_s, before))

    def forget(self) -> None:
        """Take note that it stands."""
        self._until.clear()

    def fastest_since(self, since_s: float) -> float:
        """Return the highest that has ended since; 0 where none has."""
        return max((speed for until_s, speed in self._until if until_s > since_s), default=0.0)
