"""Two joint axes in space: skew, intersecting, parallel or the same, and their common normal.

Source: McKerrow, chapter 4, section 3 (the common normal of a link). Lengths in mm.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from kinematics.errors import finite
from kinematics.vectors import Vector, add, cross, distance, dot, norm, scale, subtract, unit

SAME_DIRECTION = 1e-9
"""Sine of the angle below which two axes count as parallel."""

TOUCHING_MM = 1e-6
"""Axes nearer to each other than this intersect, or are the same."""


class Relation(Enum):
    """How two axes lie to each other."""

    SKEW = "skew"
    INTERSECTING = "intersecting"
    PARALLEL = "parallel"
    COINCIDENT = "coincident"


@dataclass(frozen=True, slots=True)
class Line:
    """A line in space: any point on it, and its direction, which is made 1 long.

    Raises `ZeroVector` for no direction and `BadNumber` for what is not a finite number.
    """

    point: Vector
    direction: Vector

    def __post_init__(self) -> None:
        for name in ("point", "direction"):
            x, y, z = (finite(f"an axis' {name}", one) for one in getattr(self, name))
            object.__setattr__(self, name, (x, y, z))
        object.__setattr__(self, "direction", unit(self.direction))

    def foot(self, point: Vector) -> Vector:
        """Return the point of the line that is nearest to a point."""
        along = dot(subtract(point, self.point), self.direction)
        return add(self.point, scale(along, self.direction))


@dataclass(frozen=True, slots=True)
class AxisPair:
    """Two axes' common normal: its ends on the one and on the other, and how the axes lie.

    Of parallel axes the common normal may be anywhere along them; `relate` was told where.
    """

    relation: Relation
    near: Vector
    far: Vector


def relate(first: Line, second: Line, level: Vector) -> AxisPair:
    """Return the common normal of two axes, through the height of `level` where it is free."""
    across = cross(first.direction, second.direction)
    if norm(across) < SAME_DIRECTION:
        near = first.foot(level)
        far = second.foot(near)
        same = distance(near, far) < TOUCHING_MM
        return AxisPair(Relation.COINCIDENT if same else Relation.PARALLEL, near, far)
    between = subtract(second.point, first.point)
    size = dot(across, across)
    along_first = dot(cross(between, second.direction), across) / size
    along_second = dot(cross(between, first.direction), across) / size
    near = add(first.point, scale(along_first, first.direction))
    far = add(second.point, scale(along_second, second.direction))
    meet = distance(near, far) < TOUCHING_MM
    return AxisPair(Relation.INTERSECTING if meet else Relation.SKEW, near, far)
