"""Whether one MKS drive was gone for a moment while the others were there: it may have begun anew.

A drive that loses its supply for a tenth of a second counts from zero again, and obeys the next
target from there. Where it counted near zero anyway its count shows nothing. But it has answered
nothing meanwhile, and other drives have: neither a busy computer nor a slow adapter does that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

TICK_S = 0.015
"""Questions that follow each other sooner are one: a single frame may have been lost."""
MISSED = 2
"""Whoever has missed so many in a row, while another drive answered, may have been gone."""


@dataclass(slots=True)
class Gap:
    """What one drive has left unanswered. Seconds."""

    obedient: bool = False
    """Whether it answers orders as well: its mode of replies may be that it does not."""
    missed: int = 0
    doubted_s: float = math.inf
    """Since when it may have been gone; infinity where nothing speaks for it."""
    _since_s: float = math.inf
    _last_s: float = -math.inf

    def asked(self, now_s: float, others_s: float) -> None:
        """Take note that it is told something, and when another drive was heard last."""
        if math.isinf(self._since_s):
            self._since_s = self._last_s = now_s
        elif now_s >= self._last_s + TICK_S:
            self._last_s = now_s
            self.missed += others_s > self._since_s

    @property
    def since_s(self) -> float:
        """When it was told what it answers first; infinity where it has nothing to answer."""
        return self._since_s

    def heard(self) -> None:
        """Take note that it says something."""
        if self.missed >= MISSED:
            self.doubted_s = min(self.doubted_s, self._since_s)
        self.missed, self._since_s = 0, math.inf

    def forget(self) -> None:
        """Doubt it no more, and wait for nothing."""
        self.doubted_s = self._since_s = math.inf
        self.missed = 0
