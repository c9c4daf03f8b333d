"""Whether the count of an MKS drive has leapt: no shaft turns so far, or that way, between looks.

A drive whose firmware begins anew within some hundredths of a second answers everything, and goes
on to its targets from a new zero: beyond them by as much as it had counted. Nothing that it tells
later shows that, and it keeps pace. A drive that is late, or blocked, stands or turns on; it never
turns back. So orders and answers may be as late as they like.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from armdrive.controllers.mks_asked import Speeds
from firmware_protocol.mks import COUNTS_PER_TURN

MARGIN = COUNTS_PER_TURN // 32
"""Counts by which a loaded shaft may give, without its loop losing it."""
LATE_S = 0.3
"""A drive may still obey what it was told so long ago."""


@dataclass(slots=True)
class Leap:
    """The last look at one drive that fitted those before it. Counts, seconds."""

    leapt: bool = False
    """Whether two looks in a row do not fit: one alone may be an answer that was late."""
    suspected: bool = False
    """Whether the last look did not fit: the drive is to be asked again."""
    _count: int | None = None
    _asked_s: float = -math.inf
    _told: tuple[float, float] = (0.0, 0.0)
    _up: Speeds = field(default_factory=Speeds)
    _down: Speeds = field(default_factory=Speeds)

    @property
    def since_s(self) -> float:
        """When the last look that fitted was asked for: it leapt since then, if it did."""
        return self._asked_s

    def begin(self, count: int | None, asked_s: float) -> None:
        """Take a drive for standing at a count, and look at it from then on."""
        self._count, self._asked_s = count, asked_s
        self.leapt = self.suspected = False
        self._told = 0.0, 0.0
        self._up.forget()
        self._down.forget()

    def order(self, up: float, down: float, now_s: float) -> None:
        """Take note of an order, and how fast it lets the drive go each way, in counts a second."""
        self._up.change(self._told[0], now_s)
        self._down.change(self._told[1], now_s)
        self._told = up, down

    def weigh(self, count: int, asked_s: float, place: float, now_s: float) -> None:
        """Weigh a look that was asked for then, at a drive that should be at a place by now."""
        if self._count is None or self._fits(count, place, now_s):
            self._count, self._asked_s, self.suspected = count, asked_s, False
        else:
            self.leapt, self.suspected = self.suspected or self.leapt, True

    def _fits(self, count: int, place: float, now_s: float) -> bool:
        before, late_s = self._count or 0, self._asked_s - LATE_S
        for_s, left = now_s - self._asked_s, place - before
        up = max(self._told[0], self._up.fastest_since(late_s)) * for_s
        down = max(self._told[1], self._down.fastest_since(late_s)) * for_s
        return min(left, -down) - MARGIN <= count - before <= max(left, up) + MARGIN
