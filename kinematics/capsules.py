"""Exact distances between straight segments, the middle lines of capsules, in mm.

Source: Ericson, Real-Time Collision Detection, section 5.1.
"""

from __future__ import annotations

import math

from kinematics.arm_geometry import Point

PARALLEL = 1e-12
"""Squared sine below which two segments count as parallel: their ends then decide."""


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
    """Return the distance of the two lines where both segments hold its points, else None."""
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
