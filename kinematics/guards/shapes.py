"""Shapes that guards keep apart: boxes, upright columns, and the middle lines of capsules.

Lengths in mm. The signed distance of two convex bodies: outside, the least distance; inside, the
shortest way by which the segment could be pushed out, with the sign turned. It changes by no more
than the points of the segment travel, so that a path can be judged by it from a few postures.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from kinematics.errors import KinematicsError, finite
from kinematics.geometry import Point

# A segment this parallel to an edge of the box has no direction across both.
LEAST_SINE2 = 1e-14

_AXES = range(3)


@dataclass(frozen=True, slots=True)
class Box:
    """A keep-out box with its sides along x, y and z. Raises `KinematicsError`."""

    name: str
    min_mm: Point
    max_mm: Point

    def __post_init__(self) -> None:
        for key in ("min_mm", "max_mm"):
            corner = tuple(finite(f"{key} of {self.name!r}", one) for one in getattr(self, key))
            if len(corner) != len(_AXES):
                raise KinematicsError(f"{key} of the box {self.name!r} needs x, y and z")
            object.__setattr__(self, key, corner)
        if not self.name:
            raise KinematicsError("a keep-out box needs a name, which refusals say")
        for axis, low, high in zip("xyz", self.min_mm, self.max_mm, strict=True):
            if low >= high:
                raise KinematicsError(
                    f"the box {self.name!r} needs a {axis} of min_mm below that of max_mm, "
                    f"not {low:g} and {high:g}"
                )

    def point_distance_mm(self, p: Point) -> float:
        """Return how far outside a point is; 0 inside."""
        x, y, z = p
        (x0, y0, z0), (x1, y1, z1) = self.min_mm, self.max_mm
        return math.hypot(
            x0 - x if x < x0 else x - x1 if x > x1 else 0.0,
            y0 - y if y < y0 else y - y1 if y > y1 else 0.0,
            z0 - z if z < z0 else z - z1 if z > z1 else 0.0,
        )

    def distance_mm(self, a: Point, b: Point) -> float:
        """Return the signed distance of the segment from a to b."""
        depth = self._depth_mm(a, b)
        return least_along(a, b, self.point_distance_mm) if depth <= 0.0 else -depth

    def _depth_mm(self, a: Point, b: Point) -> float:
        """Return by how much box and segment overlap in the direction of least overlap.

        Directions: the sides of the box, and across the segment and an edge (separating axes). Not
        above 0 if they are apart.
        """
        half = [(high - low) / 2.0 for low, high in zip(self.min_mm, self.max_mm, strict=True)]
        middle = [(low + high) / 2.0 for low, high in zip(self.min_mm, self.max_mm, strict=True)]
        u = [(q - p) / 2.0 for p, q in zip(a, b, strict=True)]
        c = [(p + q) / 2.0 - m for p, q, m in zip(a, b, middle, strict=True)]
        least = math.inf
        for axis in _AXES:
            overlap = half[axis] + abs(u[axis]) - abs(c[axis])
            if overlap <= 0.0:
                return overlap
            least = min(least, overlap)
        length2 = u[0] * u[0] + u[1] * u[1] + u[2] * u[2]
        for i, j in ((1, 2), (2, 0), (0, 1)):  # across the segment and the third axis
            across2 = u[i] * u[i] + u[j] * u[j]
            if across2 <= LEAST_SINE2 * length2:
                continue
            reach = half[i] * abs(u[j]) + half[j] * abs(u[i])
            overlap = (reach - abs(c[i] * u[j] - c[j] * u[i])) / math.sqrt(across2)
            if overlap <= 0.0:
                return overlap
            least = min(least, overlap)
        return least


# Distances along a segment. That of a point from a convex body is a convex function of the point,
# so a search by golden section finds the least one.

# How often the interval is cut: a link of 200 mm is searched to a thousandth of a mm.
CUTS = 25

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def least_along(a: Point, b: Point, distance_mm: Callable[[Point], float]) -> float:
    """Return the least distance of the points between a and b."""
    (x, y, z), (dx, dy, dz) = a, (b[0] - a[0], b[1] - a[1], b[2] - a[2])

    def at(share: float) -> float:
        return distance_mm((x + share * dx, y + share * dy, z + share * dz))

    ends = min(at(0.0), at(1.0))
    low, high = 0.0, 1.0
    left, right = 1.0 - _GOLDEN, _GOLDEN
    at_left, at_right = at(left), at(right)
    for _ in range(CUTS):
        if at_left < at_right:
            high, right, at_right = right, left, at_left
            left = high - _GOLDEN * (high - low)
            at_left = at(left)
        else:
            low, left, at_left = left, right, at_right
            right = low + _GOLDEN * (high - low)
            at_right = at(right)
    return min(ends, at_left, at_right)


def point_distance_mm(p: Point, a: Point, b: Point) -> float:
    """Return the distance of a point from the segment between a and b."""
    dx, dy, dz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    px, py, pz = p[0] - a[0], p[1] - a[1], p[2] - a[2]
    length2 = dx * dx + dy * dy + dz * dz
    share = (px * dx + py * dy + pz * dz) / length2 if length2 > 0.0 else 0.0
    share = 0.0 if share < 0.0 else min(share, 1.0)
    return math.hypot(px - share * dx, py - share * dy, pz - share * dz)


def segment_distance_mm(a: Point, b: Point, c: Point, d: Point) -> float:
    """Return the distance between the segments from a to b and from c to d."""
    return least_along(a, b, lambda point: point_distance_mm(point, c, d))


@dataclass(frozen=True, slots=True)
class Column:
    """A cylinder about a vertical axis, from below the table up to a height."""

    x_mm: float
    y_mm: float
    radius_mm: float
    top_mm: float

    def point_distance_mm(self, p: Point) -> float:
        """Return how far outside a point is; inside, minus the way to the wall or the top."""
        beside = math.hypot(p[0] - self.x_mm, p[1] - self.y_mm) - self.radius_mm
        above = p[2] - self.top_mm
        return math.hypot(beside, above) if min(beside, above) > 0.0 else max(beside, above)

    def distance_mm(self, a: Point, b: Point) -> float:
        """Return the signed distance of the segment from a to b: that of its deepest point.

        It changes by no more than the points of the segment travel.
        """
        return least_along(a, b, self.point_distance_mm)
