"""A motion of a Robko 01 under way: what is left of it, and whether positions belong to it."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.robko01 import wrap
from kinematics.spaces import Motors


@dataclass(slots=True)
class Way:
    """A motion under way: where from, where to, and how long it should take."""

    start: Motors
    steps: Motors
    expected_s: float
    began_s: float

    def left(self, seen: Motors) -> Motors:
        """Return the steps still to be made."""
        return Motors(
            map(wrap, (a + b - at for a, b, at in zip(self.start, self.steps, seen, strict=True)))
        )

    def holds(self, seen: Motors) -> bool:
        """Tell whether every motor is between its start and its target."""
        made = (wrap(at - a) for a, at in zip(self.start, seen, strict=True))
        return all(min(0, b) <= m <= max(0, b) for m, b in zip(made, self.steps, strict=True))
