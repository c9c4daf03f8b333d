"""Collision checks of the arm with the table, itself and its surroundings, as a table of rules.

A guard measures a posture (`Reading`): its clearance from its bound, negative beyond it, changes by
no more than the arm's points travel. Everything else follows from the readings: the violations of a
posture, the proof that a whole path is clear (`path`), and the nearest pose that is (`escape`).
`shapes` has the volumes. Sums of joint angles are the only guards without a distance.

Lengths in mm, angles in rad. r is the distance from the base axis. Source of the numbers: the
guards in public TeachMover programs. docs/how-to/guards-and-backlash.md explains each of them.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType
from typing import NamedTuple

from kinematics.errors import KinematicsError
from kinematics.geometry import ArmGeometry, Point
from kinematics.guards.shapes import Box, Column, segment_distance_mm
from kinematics.limits import LIMIT_TOLERANCE_RAD
from kinematics.spaces import Joints
from kinematics.text import beyond, joint_text

# What a guard measures in a posture: readings of every guard, and the violations.

# A pose on a guard's bound is allowed, whichever way its last digit was rounded.
ROUNDING_MM = 1e-6


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
    def parts(self) -> tuple[str, str]:
        """What is measured, and the part of the arm that it may hit; empty for other guards."""
        one, _, other = self.quantity.partition(" against ")
        return one, other

    @property
    def room_mm(self) -> float:
        """How far the arm may travel without violating this guard; negative if it is violated."""
        return (self.clearance_mm + self.tolerance_mm + ROUNDING_MM) / self.pace


@dataclass(frozen=True, slots=True)
class GuardViolation:
    """One guard that a posture violates.

    `value` of `quantity` against `bound`, both in `unit`: mm, or rad of a sum of joint angles.
    `excess_mm` is the least distance that would free the arm from this guard. Of a sum it is how
    far the tip of the stretched arm travels while one joint turns by the excess, which makes it
    comparable with the guards on distances. `sentence` explains it to a person.
    """

    guard: str
    quantity: str
    value: float
    bound: float
    excess_mm: float
    sentence: str
    unit: str = "mm"


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
# The prefix of the names of box guards.
BOX = "box "


# The message for each violated guard. `inside` is how far the arm is beyond the bound.

_SENTENCES: Mapping[str, str] = MappingProxyType(
    {
        "table": "the {point} would be {inside:.1f} mm below the table",
        "inner radius": "the tip would be {value:.1f} mm from the base axis, inside the arm's "
        "body: below z {guards.inner_height_mm:.0f} mm it must keep {bound:.0f} mm away",
        "outer radius": "the tip would be {value:.1f} mm from the base axis, beyond the guard at "
        "{bound:.0f} mm",
        "hand against base": "the hand would hit the base: it points backwards with the wrist "
        "{value:.1f} mm from the base axis, where {bound:.0f} mm are needed",
        BOX: "the {quantity} would be {inside:.1f} mm inside the box {box!r}",
        BASE_COLUMN: "the {quantity} would be {inside:.1f} mm inside the base column (radius "
        "{guards.base_radius_mm:g} mm, up to z {guards.base_top_mm:g} mm)",
        AGAINST_ITSELF: "the {one} would be {inside:.1f} mm inside {other}",
    }
)


def sentence_of(reading: Reading, guards: Guards) -> str:
    """Return the message for the guard that this reading violates."""
    one, other = reading.parts
    return _SENTENCES[BOX if reading.guard.startswith(BOX) else reading.guard].format(
        quantity=reading.quantity,
        point=reading.quantity.removesuffix(" z"),
        one=one,
        other=other,
        box=reading.guard.removeprefix(BOX),
        value=reading.value_mm,
        inside=-reading.value_mm,
        bound=reading.bound_mm,
        guards=guards,
    )


@dataclass(frozen=True, slots=True)
class Guards:
    """The bounds, each None or empty where an arm has no such guard.

    The tip, wrist and elbow must stay above the table (z = 0), `tolerance_mm` allowed, because
    rounding to motor steps alone puts a tip on the table some hundredths below it. The tip must
    not be nearer to the base axis than `inner_radius_mm` while below `inner_height_mm`, nor
    further than `outer_radius_mm`. And the hand must not point backwards (pitch below -90
    degrees) into the base: wrist nearer than `hand_wrist_radius_mm`, tip nearer than
    `hand_tip_radius_mm` (public programs write x for it, with the arm turned to the front) and
    the tip lower than `hand_height_mm`.

    `radii_mm`, one for each link from the upper arm to the hand, makes the links capsules: these
    keep out of one another, of `boxes`, and of the base, a column of `base_radius_mm` up to
    `base_top_mm`, all with the same tolerance. `sums` of joint angles stay in their ranges.
    """

    tolerance_mm: float = 1.0
    table: bool = True
    inner_radius_mm: float | None = 57.0
    inner_height_mm: float = 381.0
    outer_radius_mm: float | None = 453.0
    hand_wrist_radius_mm: float | None = 89.0
    hand_tip_radius_mm: float = 57.0
    hand_height_mm: float = 32.0
    radii_mm: tuple[float, ...] = ()
    base_radius_mm: float | None = None
    base_top_mm: float = 150.0
    boxes: tuple[Box, ...] = ()
    sums: tuple[AngleSum, ...] = ()

    def over(self, arm: ArmGeometry) -> GuardedArm:
        """Return these guards for an arm. Raises `KinematicsError` if they do not fit it."""
        links = None
        if self.radii_mm or self.boxes or self.base_radius_mm is not None:
            links = links_of(arm, self)
        return GuardedArm(self, arm, links)

    def violations(self, arm: ArmGeometry, joints: Joints) -> tuple[GuardViolation, ...]:
        """Return every guard that a posture violates."""
        return self.over(arm).violations(joints)

    def violation(self, arm: ArmGeometry, joints: Joints) -> GuardViolation | None:
        """Return the guard that a posture violates most, or None."""
        broken = self.violations(arm, joints)
        return deepest(broken) if broken else None


def deepest(broken: Sequence[GuardViolation]) -> GuardViolation:
    """Return the deepest of some violations."""
    return max(broken, key=lambda one: one.excess_mm)


@dataclass(frozen=True, slots=True, eq=False)
class GuardedArm:
    """Guards bound to an arm, for checking many postures."""

    guards: Guards
    arm: ArmGeometry
    links: Links | None

    def violations(self, joints: Joints) -> tuple[GuardViolation, ...]:
        """Return every guard that a posture violates."""
        return (
            *(
                GuardViolation(
                    *reading[:4], -reading.clearance_mm, sentence_of(reading, self.guards)
                )
                for reading in self.readings(joints)
                if reading.room_mm < 0.0
            ),
            *self._broken_sums(joints),
        )

    def room_mm(self, joints: Joints) -> float:
        """Return how far every point of the arm may travel before a guard is violated.

        Negative where one already is. Sums of angles add nothing else: along a joint motion they
        are worst at its ends.
        """
        rooms = [reading.room_mm for reading in self.readings(joints)]
        if any(self._broken_sums(joints)):
            rooms.append(-1.0)
        return min(rooms, default=math.inf)

    def readings(self, joints: Joints) -> Iterator[Reading]:
        """Yield the reading of every distance guard for a posture."""
        points = self.arm.points(joints)
        yield from self._table(points)
        yield from self._tip(joints, points)
        if self.links is not None:
            yield from self.links.readings(points, self.guards.tolerance_mm)

    def _table(self, points: tuple[tuple[float, float, float], ...]) -> Iterator[Reading]:
        if self.guards.table:
            names, tolerance = self.arm.moving_points, self.guards.tolerance_mm
            for name, (_, _, z) in zip(names, points[-len(names) :], strict=True):
                yield Reading("table", f"{name} z", z, 0.0, z, tolerance)

    def _tip(
        self, joints: Joints, points: tuple[tuple[float, float, float], ...]
    ) -> Iterator[Reading]:
        """Yield the readings that depend only on tip, wrist and pitch."""
        guards = self.guards
        tip_r, wrist_r = math.hypot(*points[-1][:2]), math.hypot(*points[-2][:2])
        tip_z = points[-1][2]
        inner, outer, hand = (
            guards.inner_radius_mm,
            guards.outer_radius_mm,
            guards.hand_wrist_radius_mm,
        )
        if inner is not None:
            off = max(tip_r - inner, tip_z - guards.inner_height_mm)
            yield Reading("inner radius", "tip radius", tip_r, inner, off)
        if outer is not None:
            yield Reading("outer radius", "tip radius", tip_r, outer, outer - tip_r)
        if hand is not None:
            off = max(
                wrist_r - hand, tip_r - guards.hand_tip_radius_mm, tip_z - guards.hand_height_mm
            )
            if off < -ROUNDING_MM and not self._backwards(joints):
                off = 0.0  # the hand may turn without travelling far: there is no room to rely on
            yield Reading("hand against base", "wrist radius", wrist_r, hand, off)

    def _backwards(self, joints: Joints) -> bool:
        return -math.pi < self.arm.fk(joints).pitch_rad < -math.pi / 2.0 - 1e-9

    def _broken_sums(self, joints: Joints) -> Iterator[GuardViolation]:
        for one in self.guards.sums:
            value = math.fsum(share * joints[joint] for joint, share in one.shares)
            excess = one.excess_rad(value)
            if excess > 0.0:
                bound, reach_mm = one.bound_rad(value), max(self.arm.levers_mm(None))
                passed = beyond(value, bound, what="bound")
                yield GuardViolation(
                    f"range of the {one.name}",
                    one.name,
                    value,
                    bound,
                    excess * reach_mm,
                    f"the {one.name} would be {joint_text(value, 'rad')}, {passed}",
                    "rad",
                )


# The arm's links as capsules: against keep-out boxes, the base column, one another.
#
# A link is the straight line between two neighbouring points of the arm with a radius around it.
# Neighbours always touch, and so do links separated only by short ones: those pairs are left out,
# as is a link whose first joint stands within the base column.

# The number of random postures to test: a property that all of them share holds in general.
LOOKS = 4

# Lengths that differ by less than this are the same in different postures.
STILL_MM = 1e-6

# Links named by the point where they end; the others are called after that point.
_ENDING_AT = {
    "shoulder": "shoulder column",
    "elbow": "upper arm",
    "wrist": "forearm",
    "wrist pitch": "forearm",
    "tip": "hand",
}

Segments = tuple[tuple[Point, Point], ...]


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
def links_of(arm: ArmGeometry, guards: Guards) -> Links:
    """Return what must be checked on an arm; results are cached.

    Raises `KinematicsError` if the number of radii differs from the number of links.
    """
    names, radii_mm = link_names(arm), guards.radii_mm
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
    if guards.base_radius_mm is not None:
        x, y, _ = points[0]
        column = Column(x, y, guards.base_radius_mm, guards.base_top_mm)
        over = _free_of_base(arm, column, radii_mm)
    return Links(names, radii_mm, guards.boxes, column, over, pairs)


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
