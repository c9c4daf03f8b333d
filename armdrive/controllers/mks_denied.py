"""Whether an MKS drive takes its orders no more: it says that one failed, and not that one began.

A drive in flight says that the order has failed which a newer one replaces, and the same of one
that it refuses; no bit tells which. But right beside the first it says that the newer one began.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from firmware_protocol.mks import (
    Code,
    Event,
    Failed,
    MoveAbsoluteAxis,
    Outcome,
    Started,
    Status,
    Stray,
    Superseded,
)

BESIDE_S = 0.01
"""What a drive says of an order that it takes comes within so long, before or behind that."""
DENIALS = 2
"""A drive is looked into at so many in a row: of one, the word that it began may have been lost."""


@dataclass(slots=True)
class Denials:
    """What one drive has said of its orders since it took one. Seconds."""

    refused: int = 0
    """How many targets in a row it said that it failed."""
    due_s: float = math.inf
    """When that is a denial which it has said last; infinity where it takes its orders."""
    _count: int = 0
    _began_s: float = -math.inf

    def heard(self, heard: Event, now_s: float) -> None:
        """Take note of what it says."""
        match heard:
            case Started() | Stray(_, Status(Code.ABSOLUTE_AXIS, Outcome.STARTED)):
                self.refused = self._count = 0
                self.due_s, self._began_s = math.inf, now_s
            case Failed(_, MoveAbsoluteAxis()):
                self.refused += 1
                self._doubt(now_s)
            case Superseded():
                self._doubt(now_s)

    def _doubt(self, now_s: float) -> None:
        if now_s > self._began_s + BESIDE_S:
            self.due_s = min(self.due_s, now_s + BESIDE_S)

    def confirm(self) -> bool:
        """Take what is due for a denial; tell whether there were enough to look into the drive."""
        self.due_s, self._count = math.inf, self._count + 1
        if self._count < DENIALS:
            return False
        self._count = 0
        return True

    def forget(self) -> None:
        """Doubt it no more, whatever it said of orders that are over."""
        self.due_s, self._count = math.inf, 0
