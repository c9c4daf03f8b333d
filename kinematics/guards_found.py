"""What a guard says of a posture: readings of every guard, and the ones that are broken.

Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from kinematics.limits import LIMIT_TOLERANCE_RAD

ROUNDING_MM = 1e-6
"""A pose that stands on a guard's bound is allowed, whichever way its last digit fell."""


class Reading(NamedTuple):
    """How one guard measures a posture: `value_mm` of `quantity` against `bound_mm`.

    `clearance_mm` is how far the arm is from the bound, below 0 beyond it. While no point of the
    arm travels further than some distance, it changes by no more than `pace` times that.
    """

    guard: str
    quantity: str
    value_mm: float
    bound_mm: float
    clearance_mm: float
    tolerance_mm: float = 0.0
    pace: float = 1.0

    @property
    def room_mm(self) -> float:
        """How far the arm may travel without breaking this guard; below 0 where it is broken."""
        return (self.clearance_mm + self.tolerance_mm + ROUNDING_MM) / self.pace


class Room(NamedTuple):
    """How far every point of the arm may travel, at least, before a guard is broken.

    `own_mm` for the guards about the base axis, which the base's turning leaves alone, `boxes_mm`
    for those of places in the room. One that is broken already makes it less than 0.
    """

    own_mm: float
    boxes_mm: float

    @property
    def free(self) -> bool:
        """Whether no guard is broken."""
        return self.own_mm >= 0.0 and self.boxes_mm >= 0.0


@dataclass(frozen=True, slots=True)
class GuardViolation:
    """One guard that a posture breaks.

    `value_mm` of `quantity` against `bound_mm`; `excess_mm` is the least distance that would
    free the arm of this guard. `sentence` says it to a person.
    """

    guard: str
    quantity: str
    value_mm: float
    bound_mm: float
    excess_mm: float
    sentence: str


@dataclass(frozen=True, slots=True)
class SumViolation:
    """A sum of joint angles out of its range.

    `excess_mm` is how far the tip of the stretched arm travels while one joint turns by the
    excess: so that it compares with the guards on distances.
    """

    guard: str
    quantity: str
    value_rad: float
    bound_rad: float
    excess_mm: float

    @property
    def sentence(self) -> str:
        """The violation in words."""
        value, bound = math.degrees(self.value_rad), math.degrees(self.bound_rad)
        return (
            f"the {self.quantity} would be {value:.1f}°, {abs(value - bound):.1f}° beyond its "
            f"bound of {bound:.1f}°"
        )


Violation = GuardViolation | SumViolation


@dataclass(frozen=True, slots=True)
class AngleSum:
    """A sum of joint angles and the range it must stay in, as where cables couple two links.

    The forearm's elevation is 1 shoulder + 1 elbow. `shares` are pairs of joint and factor.
    """

    name: str
    shares: tuple[tuple[str, float], ...]
    low_rad: float
    high_rad: float

    def excess_rad(self, value_rad: float) -> float:
        """Return how far beyond a bound, 0 within the range."""
        excess = max(self.low_rad - value_rad, value_rad - self.high_rad)
        return excess if excess > LIMIT_TOLERANCE_RAD else 0.0

    def bound_rad(self, value_rad: float) -> float:
        """Return the bound that is nearest."""
        return min(max(value_rad, self.low_rad), self.high_rad)
