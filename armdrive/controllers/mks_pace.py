"""Whether an MKS drive turns as fast as it is told: how far it came, and how far its orders went.

A drive that is too weak for its speed is told a higher one to make up for what it lags, so that it
stays near its way and gets to its target late. What it turned of what it should have shows that,
for as long as it lasts. Orders and answers that are late by some hundredths of a second show in
all drives, and go by.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

LOOKS = 5
"""A drive that is too slow is so at so many looks in a row: half a second."""
LOOK_S = 0.08
"""Looks that follow each other sooner are one."""
SLACK = 0.75
"""A drive that turns by less than this share of what another one turns is too slow."""


@dataclass(slots=True)
class Pace:
    """How far one drive turned from look to look, and how far it should have. Counts, seconds."""

    _looks: deque[tuple[float, float]] = field(default_factory=lambda: deque(maxlen=LOOKS))

    _since_s: float = -math.inf

    def note(self, turned: float, ran: float, now_s: float) -> None:
        """Take note of what it turned since the last look, and of what it should have."""
        turned, ran = turned if ran > 0.0 else -turned, abs(ran)
        if self._looks and now_s < self._since_s + LOOK_S:
            before = self._looks.pop()
            turned, ran = turned + before[0], ran + before[1]
        else:
            self._since_s = now_s
        self._looks.append((turned, ran))

    def forget(self) -> None:
        """Begin anew."""
        self._looks.clear()

    def shares(self, least: float) -> list[float]:
        """Return what it turned at each look of what it should have; none if that is too little."""
        if len(self._looks) < LOOKS or any(ran < least for _, ran in self._looks):
            return []
        return [turned / ran for turned, ran in self._looks]


def laggard(paces: Sequence[Pace], least: float) -> int | None:
    """Return the index of one that lags behind another one at every look; None for no such one.

    `least` is what it should have turned from look to look. One that moves alone lags behind
    nobody: it is on its way, only late.
    """
    shares = {i: found for i, each in enumerate(paces) if (found := each.shares(least))}
    if len(shares) < 2:
        return None
    slowest = min(shares, key=lambda index: max(shares[index]))
    best = min(max(sum(found) / LOOKS for found in shares.values()), 1.0)
    return slowest if max(shares[slowest]) < SLACK * best else None
