"""Shapes that guards keep apart: boxes, upright columns, and the middle lines of capsules.

Lengths in mm. The signed distance of two convex bodies: outside, the least distance; inside, the
shortest way by which the segment could be pushed out, with the sign turned. It changes by no more
than the points of the segment travel, so that a path can be judged by it from a few postures.
"""

from __future__ import annotations

import math
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
        return self._apart_mm(a, b) if depth <= 0.0 else -depth

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

    def _apart_mm(self, a: Point, b: Point) -> float:
        """Return the least distance: the root of a piecewise quadratic along the segment."""
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
        """Return where the segment crosses the planes of the sides: the pieces of the quadratic."""
        cuts = []
        for p, d, low, high in zip(a, u, self.min_mm, self.max_mm, strict=True):
            if d != 0.0:
                cuts += [cut for cut in ((low - p) / d, (high - p) / d) if 0.0 < cut < 1.0]
        return cuts

    def _slope(self, a: Point, u: tuple[float, ...], share: float) -> float:
        """Return half the slope of the squared distance, which increases along the segment."""
        slope = 0.0
        for p, d, low, high in zip(a, u, self.min_mm, self.max_mm, strict=True):
            at = p + share * d
            if at < low:
                slope += (at - low) * d
            elif at > high:
                slope += (at - high) * d
        return slope


# Exact distances between straight segments (Ericson, Real-Time Collision Detection, section 5.1).

# Squared sine below which two segments count as parallel: their ends then decide.
PARALLEL = 1e-12


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
    inside = _between_inner_points_mm(a, b, c, d)
    if inside is not None:
        return inside
    return min(
        point_distance_mm(a, c, d),
        point_distance_mm(b, c, d),
        point_distance_mm(c, a, b),
        point_distance_mm(d, a, b),
    )


def _between_inner_points_mm(a: Point, b: Point, c: Point, d: Point) -> float | None:
    """Return the distance of the two lines if both segments contain its points; otherwise None."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = d[0] - c[0], d[1] - c[1], d[2] - c[2]
    wx, wy, wz = a[0] - c[0], a[1] - c[1], a[2] - c[2]
    uu = ux * ux + uy * uy + uz * uz
    vv = vx * vx + vy * vy + vz * vz
    uv = ux * vx + uy * vy + uz * vz
    det = uu * vv - uv * uv
    if det <= PARALLEL * uu * vv:
        return None
    uw = ux * wx + uy * wy + uz * wz
    vw = vx * wx + vy * wy + vz * wz
    s, t = (uv * vw - vv * uw) / det, (uu * vw - uv * uw) / det
    if not (0.0 <= s <= 1.0 and 0.0 <= t <= 1.0):
        return None
    return math.hypot(wx + s * ux - t * vx, wy + s * uy - t * vy, wz + s * uz - t * vz)


# The base as an upright column, and how far a segment is from it or how deep inside.

# How often the interval of the least distance is halved: 40 turns a metre into 1e-9 mm.
HALVINGS = 40


@dataclass(frozen=True, slots=True)
class Column:
    """A cylinder about a vertical axis, from below the table up to a height."""

    x_mm: float
    y_mm: float
    radius_mm: float
    top_mm: float

    def distance_mm(self, a: Point, b: Point) -> float:
        """Return the signed distance of the segment from a to b: that of its deepest point.

        Outside, the exact distance. Inside, the distance of that point from the wall or the top,
        whichever is nearer. Along the segment this is a convex function, so interval halving finds
        its minimum; it changes by no more than the points of the segment travel.
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
