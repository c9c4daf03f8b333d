"""Curves of the tip through space: a segment, part of a circle, a cubic Bezier curve.

Lengths in mm. A trace knows nothing about arms or hands; its points are given at shares (0 to 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from kinematics.errors import NoArc, positive
from kinematics.frames.vectors import Vector, add, cross, distance, dot, norm, scale, subtract, unit
from kinematics.geometry import Point

EIGHTH_RAD = math.pi / 4.0
QUARTER_RAD = math.pi / 2.0
BLEND_CHORDS = 8


class Trace(Protocol):
    """A curve of the tip."""

    @property
    def shape(self) -> str:
        """The kind of curve, in words."""

    @property
    def least_chords(self) -> int:
        """How many parts the curve is cut into before it is examined."""

    def at(self, share: float) -> Point:
        """Return the point at a share of the curve; the ends are exact."""


class Blendable(Trace, Protocol):
    """A trace that a blend may leave or join; it looks the same from both ends."""

    @property
    def largest_blend_mm(self) -> float:
        """How far from its end a blend may leave it."""

    def share_beside_end(self, radius_mm: float) -> float:
        """Return the share of the curve that lies within this distance of an end."""

    def slope(self, share: float) -> Vector:
        """Return how the point moves with the share, in mm for the whole curve."""


@dataclass(frozen=True, slots=True)
class LineSegment:
    """A straight line between two points."""

    start: Point
    end: Point
    shape = "straight line"
    least_chords = 1

    def at(self, share: float) -> Point:
        """Return the point at a share of the line."""
        if share >= 1.0:
            return self.end
        (a, b, c), (x, y, z) = self.start, self.end
        return a + share * (x - a), b + share * (y - b), c + share * (z - c)

    @property
    def largest_blend_mm(self) -> float:
        """Half of its length."""
        return distance(self.start, self.end) / 2.0

    def share_beside_end(self, radius_mm: float) -> float:
        """Return the share of the line within this distance of an end."""
        return radius_mm / distance(self.start, self.end)

    def slope(self, share: float) -> Vector:  # noqa: ARG002 - the same everywhere
        """Return the vector from end to end."""
        return subtract(self.end, self.start)


@dataclass(frozen=True, slots=True)
class Round:
    """A circular arc about a centre by a sweep in rad; `ahead` is a quarter turn beyond `out`.

    `out` leads from the centre to the start; both have the length of the radius.
    """

    centre: Point
    out: Vector
    ahead: Vector
    sweep_rad: float
    end: Point
    shape = "arc"

    @property
    def least_chords(self) -> int:
        """One part for each eighth of a turn."""
        return max(1, math.ceil(self.sweep_rad / EIGHTH_RAD - 1e-9))

    @property
    def radius_mm(self) -> float:
        """The distance from the centre."""
        return math.hypot(*self.out)

    def at(self, share: float) -> Point:
        """Return the point at a share of the sweep."""
        if share >= 1.0:
            return self.end
        return turned(self.centre, self.out, self.ahead, share * self.sweep_rad)

    @property
    def largest_blend_mm(self) -> float:
        """The distance of an end from the middle, but at most from a quarter of a turn away."""
        return 2.0 * self.radius_mm * math.sin(min(self.sweep_rad / 2.0, QUARTER_RAD) / 2.0)

    def share_beside_end(self, radius_mm: float) -> float:
        """Return the share of the sweep within this straight-line distance of an end."""
        half = min(radius_mm / (2.0 * self.radius_mm), 1.0)
        return 2.0 * math.asin(half) / self.sweep_rad

    def slope(self, share: float) -> Vector:
        """Return the direction of the tangent, as long as the whole arc."""
        angle = share * self.sweep_rad
        tangent = subtract(scale(math.cos(angle), self.ahead), scale(math.sin(angle), self.out))
        return scale(self.sweep_rad, tangent)


@dataclass(frozen=True, slots=True)
class Bezier:
    """A cubic curve from the first of four points to the last, shaped by the two between."""

    points: tuple[Point, Point, Point, Point]
    shape = "blend"
    least_chords = BLEND_CHORDS

    def at(self, share: float) -> Point:
        """Return the point at a share of the curve's parameter."""
        x, y, z = cubic(self.points, share)
        return x, y, z


def turned(centre: Point, out: Vector, ahead: Vector, angle_rad: float) -> Point:
    """Return the point about a centre; see `Round`."""
    off = add(scale(math.cos(angle_rad), out), scale(math.sin(angle_rad), ahead))
    return add(centre, off)


def cubic(points: tuple[tuple[float, ...], ...], share: float) -> tuple[float, ...]:
    """Return the point of a cubic Bezier curve of any dimension (Bernstein's form)."""
    left = 1.0 - share
    a, d = left * left * left, share * share * share
    b, c = 3.0 * left * left * share, 3.0 * left * share * share
    return tuple(
        a * one + b * two + c * three + d * four
        for one, two, three, four in zip(*points, strict=True)
    )


# Arcs through three points: their centre is the circumcentre of the triangle.

LEAST_MM = 0.01
"""Points nearer to one another, or to a line, define no circle: a motor step moves further."""


def round_through(start: Point, via: Point, goal: Point, sweep_rad: float | None = None) -> Round:
    """Return the arc through three points, to the third or by a sweep.

    Raises `NoArc`.
    """
    _check_apart(start, via, goal)
    b, c = subtract(via, start), subtract(goal, start)
    normal = cross(b, c)
    weighed = add(
        scale(dot(c, c), cross(normal, b)),
        scale(dot(b, b), cross(c, normal)),
    )
    from_start = scale(0.5 / dot(normal, normal), weighed)
    centre, out = add(start, from_start), scale(-1.0, from_start)
    ahead = cross(unit(normal), out)
    if sweep_rad is None:
        return Round(centre, out, ahead, _angle_about(subtract(goal, centre), out, ahead), goal)
    sweep = positive("sweep_rad", sweep_rad)
    end = start if sweep == math.tau else turned(centre, out, ahead, sweep)
    return Round(centre, out, ahead, sweep, end)


def _angle_about(point: Vector, out: Vector, ahead: Vector) -> float:
    return math.atan2(dot(point, ahead), dot(point, out)) % math.tau


def _check_apart(start: Point, via: Point, goal: Point) -> None:
    named = {"start": start, "via point": via, "goal": goal}
    pairs = (("start", "via point"), ("via point", "goal"), ("start", "goal"))
    sides = {pair: distance(named[pair[0]], named[pair[1]]) for pair in pairs}
    (one, two), nearest = min(sides.items(), key=lambda side: side[1])
    if nearest < LEAST_MM:
        remedy = "give three points that lie apart"
        if (one, two) == ("start", "goal"):
            remedy += ", or for a full circle another point of it as the goal, and a sweep of 2 pi"
        raise NoArc(f"{one} and {two} are the same point", remedy, nearest)
    off = norm(cross(subtract(via, start), subtract(goal, start))) / max(sides.values())
    if off < LEAST_MM:
        raise NoArc(
            f"start, via point and goal lie in a line, to within {off:.3f} mm",
            "use a straight line, or a via point beside it",
            off,
        )
