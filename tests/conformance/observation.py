"""Observations of the physical arm, and the check that raises `Broken`.

Motors are in the steps or half-steps of the model's coordinates, as in `Status.acknowledged`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from kinematics import Motors, Pose

ON_THE_STEP = 1
"""How many steps two counts of the same place may differ by, because both are rounded."""

Point = tuple[float, float, float]


def place(pose: Pose) -> Point:
    """Return where a pose has the tip."""
    return pose.x_mm, pose.y_mm, pose.z_mm


def rests_within(settings: object) -> int:
    """Return how far from its target a closed-loop drive may rest, in counts; 0 for a stepper."""
    return max(getattr(settings, name, 0) for name in ("in_position_counts", "position_window"))


class Broken(AssertionError):
    """A behaviour is not as promised; the sentence says what happened and what was promised."""


def check(kept: bool, sentence: str) -> None:
    """Raise `Broken` with a sentence unless a promise was kept."""
    if not kept:
        raise Broken(sentence)


@dataclass(frozen=True, slots=True)
class Observation:
    """The physical arm at one moment of the bench's clock; no register is read."""

    time_s: float
    motors: Motors
    tip: Point
    opening_mm: float
    energised: bool = True
    powered: bool = True

    def off_steps(self, other: Sequence[int]) -> int:
        """Return the largest distance of a motor from another place, in steps."""
        return (self.motors - Motors(other)).largest

    def off_mm(self, other: Observation) -> float:
        """Return the distance of the tip from that of another observation."""
        return math.dist(self.tip, other.tip)


@dataclass(frozen=True, slots=True)
class Standstill:
    """How an arm came to rest: when it last moved, and how far its tip got from the start."""

    after_s: float
    way_mm: float
    end: Observation
