"""What a person sees of a small motion: the finger tips go left, up or out, the hand turns.

Everything is in mm at the tip, so that one direction can be compared with another; turning of the
hand about its own axis counts as `ROLL_LEVER_MM` a radian. Directions are seen from behind the
arm: left is counter-clockwise about the base axis from above, and clockwise is seen along the hand.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from kinematics import Joints
from kinematics.geometry import ArmGeometry

ROLL_LEVER_MM = 40.0
SEEN_SHARE = 0.15
"""A direction with less than this share of the strongest one escapes the eye."""
LEAST_MM = 0.05

WAYS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "turn": ("left", "right"),
        "height": ("up", "down"),
        "reach": ("out", "in"),
        "roll": ("clockwise", "counter-clockwise"),
        "fingers": ("open", "close"),
    }
)
"""The words of each direction, the positive one first."""


@dataclass(frozen=True, slots=True)
class Sight:
    """A motion as it is seen: mm in each direction of `WAYS`, signed."""

    way_mm: Mapping[str, float]

    @property
    def strongest_mm(self) -> float:
        """The most that is seen in any direction."""
        return max(map(abs, self.way_mm.values()))

    def visible(self) -> tuple[str, ...]:
        """Return the directions that catch the eye, the strongest first."""
        least = max(SEEN_SHARE * self.strongest_mm, LEAST_MM)
        seen = [way for way, mm in self.way_mm.items() if abs(mm) >= least]
        return tuple(sorted(seen, key=lambda way: -abs(self.way_mm[way])))

    def word(self, way: str) -> str:
        """Return the word for what happens in one direction."""
        positive, negative = WAYS[way]
        return positive if self.way_mm[way] > 0.0 else negative

    def __str__(self) -> str:
        seen = [f"{self.word(way)} {abs(self.way_mm[way]):.1f} mm" for way in self.visible()]
        return ", ".join(seen) or "nothing"


def sight(arm: ArmGeometry, before: Joints, after: Joints, opened_mm: float = 0.0) -> Sight:
    """Return what is seen when an arm goes from one posture to another."""
    (x0, y0, z0), (x1, y1, z1) = arm.points(before)[-1], arm.points(after)[-1]
    radius = math.hypot(x0, y0)
    turned = _wrapped(math.atan2(y1, x1) - math.atan2(y0, x0)) if radius > LEAST_MM else 0.0
    rolled = _wrapped(arm.fk(after).roll_rad - arm.fk(before).roll_rad)
    return Sight(
        {
            "turn": turned * radius,
            "height": z1 - z0,
            "reach": math.hypot(x1, y1) - radius,
            "roll": rolled * ROLL_LEVER_MM,
            "fingers": opened_mm,
        }
    )


def _wrapped(angle_rad: float) -> float:
    return math.remainder(angle_rad, math.tau)
