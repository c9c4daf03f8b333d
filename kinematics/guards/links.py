"""Guards on the arm's links as capsules: against keep-out boxes, the base column, one another.

Lengths in mm, angles in rad. A link is the straight line between two neighbouring points of the arm
with a radius around it. Neighbours always touch, and so do links separated only by short ones:
those pairs are left out, as is a link whose first joint stands within the base column.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from kinematics.errors import KinematicsError
from kinematics.geometry import ArmGeometry, Point
from kinematics.guards.shapes import Box, Column, segment_distance_mm
from kinematics.limits import LIMIT_TOLERANCE_RAD
from kinematics.spaces import Joints

# What a guard measures in a posture: readings of every guard, and the violations.

ROUNDING_MM = 1e-6
"""A pose on a guard's bound is allowed, whichever way its last digit was rounded."""


class Reading(NamedTuple):
    """What one guard measures in a posture: `value_mm` of `quantity` against `bound_mm`.

    `clearance_mm` is how far the arm is from the bound, negative beyond it. While no point of the
    arm travels further than some distance, it changes by no more than `pace` times that distance.
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
        """How far the arm may travel without violating this guard; negative if it is violated."""
        return (self.clearance_mm + self.tolerance_mm + ROUNDING_MM) / self.pace


@dataclass(frozen=True, slots=True)
class GuardViolation:
    """One guard that a posture violates.

    `value_mm` of `quantity` against `bound_mm`; `excess_mm` is the least distance that would free
    the arm from this guard. `sentence` explains it to a person.
    """

    guard: str
    quantity: str
    value_mm: float
    bound_mm: float
    excess_mm: float
    sentence: str


@dataclass(frozen=True, slots=True)
class SumViolation:
    """A sum of joint angles outside its range.

    `excess_mm` is how far the tip of the stretched arm travels while one joint turns by the excess,
    which makes it comparable with the guards on distances.
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
    """A sum of joint angles and its range, for example for two links coupled by cables.

    The forearm's elevation is 1 shoulder + 1 elbow. `shares` are pairs of joint and factor.
    """

    name: str
    shares: tuple[tuple[str, float], ...]
    low_rad: float
    high_rad: float

    def excess_rad(self, value_rad: float) -> float:
        """Return how far the sum is beyond a bound; 0 within the range."""
        excess = max(self.low_rad - value_rad, value_rad - self.high_rad)
        return excess if excess > LIMIT_TOLERANCE_RAD else 0.0

    def bound_rad(self, value_rad: float) -> float:
        """Return the nearest bound."""
        return min(max(value_rad, self.low_rad), self.high_rad)


BASE_COLUMN = "base column"
AGAINST_ITSELF = "arm against itself"
BOX = "box "
"""The prefix of the names of box guards."""

LOOKS = 4
"""The number of random postures to test: a property that all of them share holds in general."""

STILL_MM = 1e-6
"""Lengths that differ by less than this are the same in different postures."""

_ENDING_AT = {
    "shoulder": "shoulder column",
    "elbow": "upper arm",
    "wrist": "forearm",
    "wrist pitch": "forearm",
    "tip": "hand",
}
"""Links named by the point where they end; the others are called after that point."""

Segments = tuple[tuple["Point", "Point"], ...]


@dataclass(frozen=True, slots=True)
class Links:
    """Which links of an arm are checked against what; made by `links_of`."""

    names: tuple[str, ...]
    radii_mm: tuple[float, ...]
    boxes: tuple[Box, ...]
    column: Column | None
    over_base: tuple[int, ...]
    pairs: tuple[tuple[int, int], ...]

    def segments(self, points: tuple[Point, ...]) -> Segments:
        """Return the middle line of each link."""
        ends = points[-len(self.names) - 1 :]
        return tuple(pairwise(ends))

    def readings(self, points: tuple[Point, ...], tolerance_mm: float) -> Iterator[Reading]:
        """Yield the readings of every box, the base column and every pair of links."""
        lines = self.segments(points)
        for box in self.boxes:
            for name, radius, (a, b) in zip(self.names, self.radii_mm, lines, strict=True):
                off = box.distance_mm(a, b) - radius
                yield Reading(BOX + box.name, name, off, 0.0, off, tolerance_mm)
        if self.column is not None:
            for index in self.over_base:
                off = self.column.distance_mm(*lines[index]) - self.radii_mm[index]
                yield Reading(BASE_COLUMN, self.names[index], off, 0.0, off, tolerance_mm)
        for i, j in self.pairs:
            off = segment_distance_mm(*lines[i], *lines[j]) - self.radii_mm[i] - self.radii_mm[j]
            both = f"{self.names[j]} against the {self.names[i]}"
            yield Reading(AGAINST_ITSELF, both, off, 0.0, off, tolerance_mm, 2.0)


@lru_cache(maxsize=32)
def links_of(
    arm: ArmGeometry,
    radii_mm: tuple[float, ...],
    boxes: tuple[Box, ...],
    base_radius_mm: float | None,
    base_top_mm: float,
) -> Links:
    """Return what must be checked on an arm; results are cached.

    Raises `KinematicsError` if the number of radii differs from the number of links.
    """
    names = link_names(arm)
    if len(radii_mm) != len(names):
        raise KinematicsError(
            f"a radius is needed for each of {', '.join(names)}: {len(names)}, not {len(radii_mm)}"
        )
    points = arm.points(_zero(arm))
    ends = points[-len(names) - 1 :]
    lengths = [math.dist(a, b) for a, b in pairwise(ends)]
    pairs = tuple(
        (i, j)
        for i in range(len(names))
        for j in range(i + 2, len(names))
        if sum(lengths[i + 1 : j]) >= radii_mm[i] + radii_mm[j]
    )
    column: Column | None = None
    over: tuple[int, ...] = ()
    if base_radius_mm is not None:
        column = Column(points[0][0], points[0][1], base_radius_mm, base_top_mm)
        over = _free_of_base(arm, column, radii_mm)
    return Links(names, radii_mm, boxes, column, over, pairs)


def link_names(arm: ArmGeometry) -> tuple[str, ...]:
    """Return the names of the links that end at the arm's moving points."""
    return tuple(_ENDING_AT.get(name, f"link to the {name}") for name in arm.moving_points)


def _free_of_base(arm: ArmGeometry, column: Column, radii_mm: tuple[float, ...]) -> tuple[int, ...]:
    """Return the links whose first joint does not stand in the base column.

    That joint stays in place while the arm moves, or turns around the base axis with it.
    """
    draw = random.Random(1)  # noqa: S311 - any postures will do
    count = len(radii_mm)
    found: list[list[float]] = [[] for _ in radii_mm]
    for _ in range(LOOKS):
        angles = tuple(draw.uniform(-3.0, 3.0) for _ in arm.limits)
        starts = arm.points(Joints(angles, arm.joint_names))[-count - 1 : -1]
        for distances, start in zip(found, starts, strict=True):
            distances.append(column.distance_mm(start, start))
    return tuple(
        index
        for index, (distances, radius) in enumerate(zip(found, radii_mm, strict=True))
        if max(distances) - min(distances) > STILL_MM or distances[0] >= radius
    )


def _zero(arm: ArmGeometry) -> Joints:
    return Joints((0.0,) * len(arm.limits), arm.joint_names)
