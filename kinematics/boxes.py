"""Keep-out boxes in the table's frame, and how far a segment is from one or how deep inside.

Lengths in mm. The signed distance of two convex bodies: outside, the least distance; inside, the
shortest way by which the segment could be pushed out, with the sign turned. It changes by no more
than the points of the segment travel, so that a path can be judged by it from a few postures.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinematics.arm_geometry import Point
from kinematics.errors import KinematicsError, finite

LEAST_SINE2 = 1e-14
"""A segment this parallel to an edge of the box has no direction across both."""

_AXES = range(3)


@dataclass(frozen=True, slots=True)
class Box:
    """A place the arm keeps out of, its sides along x, y and z; raises `KinematicsError`."""

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
        """Return how far outside a point is, 0 inside."""
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
        return self._apart_mm(a, b) if depth <= 0.0 else -depth

    def ways_out_mm(self, a: Point, b: Point, radius_mm: float) -> tuple[Point, ...]:
        """Return the translations that take a capsule out by each side but the lower one."""
        ways = []
        for axis in _AXES:
            back = self.min_mm[axis] - radius_mm - max(a[axis], b[axis])
            forth = self.max_mm[axis] + radius_mm - min(a[axis], b[axis])
            for by in (forth,) if axis == 2 else (back, forth):
                x, y, z = (by if one == axis else 0.0 for one in _AXES)
                ways.append((x, y, z))
        return tuple(ways)

    def _depth_mm(self, a: Point, b: Point) -> float:
        """Return by how much box and segment overlap in the direction where it is least.

        Directions: the sides of the box, and across the segment and an edge (separating axes).
        Not above 0 where they are apart.
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

    def _apart_mm(self, a: Point, b: Point) -> float:
        """Return the least distance: the root of what is a run of parabolas along the segment."""
        u = tuple(q - p for p, q in zip(a, b, strict=True))
        share = self._lowest(a, u)
        x, y, z = (p + share * d for p, d in zip(a, u, strict=True))
        return self.point_distance_mm((x, y, z))

    def _lowest(self, a: Point, u: tuple[float, ...]) -> float:
        """Return where along the segment its distance from the box is least."""
        before, slope = 0.0, self._slope(a, u, 0.0)
        if slope >= 0.0:
            return 0.0
        for cut in (*sorted(self._cuts(a, u)), 1.0):
            following = self._slope(a, u, cut)
            if following >= 0.0:
                return before + (cut - before) * slope / (slope - following)
            before, slope = cut, following
        return 1.0

    def _cuts(self, a: Point, u: tuple[float, ...]) -> list[float]:
        """Return where the segment crosses the planes of the sides: one parabola ends there."""
        cuts = []
        for p, d, low, high in zip(a, u, self.min_mm, self.max_mm, strict=True):
            if d != 0.0:
                cuts += [cut for cut in ((low - p) / d, (high - p) / d) if 0.0 < cut < 1.0]
        return cuts

    def _slope(self, a: Point, u: tuple[float, ...], share: float) -> float:
        """Return half the slope of the squared distance; it only ever rises along the segment."""
        slope = 0.0
        for p, d, low, high in zip(a, u, self.min_mm, self.max_mm, strict=True):
            at = p + share * d
            if at < low:
                slope += (at - low) * d
            elif at > high:
                slope += (at - high) * d
        return slope
