"""What one sees of the physical arm, and the sentence that is said where it breaks a promise.

Motors are in half-steps or steps of the model's own coordinates, as in `Status.acknowledged`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from kinematics import Motors

ON_THE_STEP = 1
"""So many steps may be between two counts of the same place: both are rounded."""

Point = tuple[float, float, float]


def rests_within(settings: object) -> int:
    """Return how far from its place a drive that measures its shaft may rest; 0 for a stepper."""
    return max(getattr(settings, name, 0) for name in ("rest_counts", "rest_window"))


class Broken(AssertionError):
    """A behaviour is not as promised; the sentence says what was seen and what was promised."""


def check(kept: bool, sentence: str) -> None:
    """Raise `Broken` unless a promise was kept."""
    if not kept:
        raise Broken(sentence)


@dataclass(frozen=True, slots=True)
class Seen:
    """The physical arm at one moment, by the bench's own clock: no register is asked."""

    time_s: float
    motors: Motors
    tip: Point
    opening_mm: float
    energised: bool = True
    powered: bool = True

    def off_steps(self, other: Sequence[int]) -> int:
        """Return how far the motor that is furthest off is from where it should be."""
        return (self.motors - Motors(other)).largest

    def off_mm(self, other: Seen) -> float:
        """Return how far the tip is from where it was seen another time."""
        return math.dist(self.tip, other.tip)


@dataclass(frozen=True, slots=True)
class Rest:
    """How an arm came to rest: when it last moved, how far its tip was from the start at most."""

    after_s: float
    way_mm: float
    end: Seen
