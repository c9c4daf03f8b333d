"""Whether one MKS drive was gone for a moment while the others were there: it may have begun anew.

A drive that loses its supply for a tenth of a second counts from zero again, and obeys the next
target from there. Where it counted near zero anyway its count shows nothing. But what it was told
meanwhile it never answers, and a drive behind a busy computer or a slow adapter answers all of it,
late.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

TICK_S = 0.01
"""Questions that follow each other sooner are one. One that is not answered, while another drive is
heard, is followed by others so soon: what tells lost frames from a drive that has no power."""
MISSED = 3
"""Whoever has missed so many more in a row, while another drive answered, may have been gone."""
ALONE_S = 0.15
"""One that brakes and is silent for so long may have been gone, though nobody else is heard."""
LATE_S = 0.12
"""An answer that has not come so long after its drive was heard again will not come."""


@dataclass(slots=True)
class Gap:
    """What one drive has left unanswered. Seconds."""

    obedient: bool = False
    """Whether it answers orders as well: its mode of replies may be that it does not."""
    missed: int = 0
    doubted_s: float = math.inf
    """Since when it may have been gone; infinity where nothing speaks for it."""
    outstanding: int = 0
    """How many orders and questions more than answers there have been."""
    since_s: float = math.inf
    """When it was told what it answers first; infinity where it has nothing to answer."""
    alone: bool = False
    """Whether it brakes, so that others may have nothing to say meanwhile."""
    _before: int = 0
    _last_s: float = -math.inf
    _maybe_s: float = math.inf
    _maybe_owed: int = 0
    _back_s: float = math.inf

    def urge_s(self, others_s: float) -> float:
        """Return when it is asked again, if another one answered then; infinity for not at all."""
        return self._last_s + TICK_S if others_s > self.since_s else math.inf

    @property
    def pending(self) -> bool:
        """Whether it may have been gone, and may answer yet what it was told meanwhile."""
        return math.isfinite(self._maybe_s)

    @property
    def gone_s(self) -> float:
        """Since when it was gone, if it was; infinity where nothing speaks for it."""
        return min(self.doubted_s, self._maybe_s)

    @property
    def owed(self) -> int:
        """How many answers were outstanding when it was heard last."""
        return self._before if math.isfinite(self.since_s) else self.outstanding

    def asked(self, now_s: float, others_s: float, *, counts: bool) -> None:
        """Take note that it is told something, and when another drive answered last.

        What `counts` has one answer, whenever it comes.
        """
        if self.pending and now_s >= self._back_s + LATE_S:
            self.doubted_s, self._maybe_s = min(self.doubted_s, self._maybe_s), math.inf
        if math.isinf(self.since_s):
            self.since_s = self._last_s = now_s
            self._before = self.outstanding
        elif now_s >= self._last_s + TICK_S:
            self._last_s = now_s
            self.missed += others_s > self.since_s
        self.outstanding += counts

    def heard(self, now_s: float, *, counts: bool) -> None:
        """Take note that it says something; what `counts` is the answer to something that did."""
        self.outstanding -= counts
        silent = self.alone and now_s >= self.since_s + ALONE_S
        if (silent or self.missed >= MISSED) and not self.pending:
            self._maybe_s, self._maybe_owed, self._back_s = self.since_s, self._before, now_s
        if self.pending and self.outstanding <= self._maybe_owed:
            self._maybe_s = math.inf  # it has answered all: it was there
        self.missed, self.since_s = 0, math.inf

    def forget(self) -> None:
        """Doubt it no more, and wait for nothing."""
        self.doubted_s = self.since_s = self._maybe_s = math.inf
        self.missed, self.alone = 0, False
