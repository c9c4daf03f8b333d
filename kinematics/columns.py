"""The base as an upright column, and how far a segment is from it or how deep inside. In mm."""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinematics.arm_geometry import Point

HALVINGS = 40
"""How often the place of the least distance is halved: a metre becomes a millionth of a micron."""


@dataclass(frozen=True, slots=True)
class Column:
    """A cylinder about a vertical axis, from below the table up to a height."""

    x_mm: float
    y_mm: float
    radius_mm: float
    top_mm: float

    def distance_mm(self, a: Point, b: Point) -> float:
        """Return the signed distance of the segment from a to b: of its point that is deepest.

        Outside, the exact distance. Inside, how far that point is from wall or top, whichever is
        nearer. Along the segment this is a convex function, so halving finds its least value; it
        changes by no more than the points of the segment travel.
        """
        low, high = 0.0, 1.0
        at_a, slope = self._at(a, b, 0.0)
        if slope >= 0.0:
            return at_a
        at_b, slope = self._at(a, b, 1.0)
        if slope <= 0.0:
            return at_b
        least = min(at_a, at_b)
        for _ in range(HALVINGS):
            middle = (low + high) / 2.0
            value, slope = self._at(a, b, middle)
            least = min(least, value)
            low, high = (middle, high) if slope < 0.0 else (low, middle)
        return least

    def _at(self, a: Point, b: Point, share: float) -> tuple[float, float]:
        """Return the signed distance of a point of the segment, and its slope along it."""
        dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        x, y = a[0] + share * dx - self.x_mm, a[1] + share * dy - self.y_mm
        r = math.hypot(x, y)
        beside, above = r - self.radius_mm, a[2] + share * dz - self.top_mm
        outwards = (x * dx + y * dy) / r if r > 0.0 else 0.0
        if beside > 0.0 and above > 0.0:
            distance = math.hypot(beside, above)
            return distance, (beside * outwards + above * dz) / distance
        return (beside, outwards) if beside > above else (above, dz)
