"""Places where the arm would hit the table, itself, or its surroundings, as a table of rules.

Lengths in mm, angles in rad. r is the distance from the base axis. Source of the numbers: the
guards in public TeachMover programs. docs/how-to/guards-and-backlash.md explains each of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from kinematics.geometry import ArmGeometry
from kinematics.guards.links import (
    AGAINST_ITSELF,
    BASE_COLUMN,
    BOX,
    ROUNDING_MM,
    AngleSum,
    GuardViolation,
    Links,
    Reading,
    SumViolation,
    Violation,
    links_of,
)
from kinematics.guards.shapes import Box
from kinematics.spaces import Joints

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
    one, _, other = reading.quantity.partition(" against ")
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


__all__ = ["AngleSum", "Box", "GuardViolation", "GuardedArm", "Guards", "SumViolation", "Violation"]


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
            links = links_of(arm, self.radii_mm, self.boxes, self.base_radius_mm, self.base_top_mm)
        return GuardedArm(self, arm, links)

    def violations(self, arm: ArmGeometry, joints: Joints) -> tuple[Violation, ...]:
        """Return every guard that a posture violates."""
        return self.over(arm).violations(joints)

    def violation(self, arm: ArmGeometry, joints: Joints) -> Violation | None:
        """Return the guard that a posture violates most, or None."""
        broken = self.violations(arm, joints)
        return deepest(broken) if broken else None

    def depth_mm(self, arm: ArmGeometry, joints: Joints) -> float:
        """Return how deep a posture is inside the guards; 0 outside all. Leaving decreases it."""
        return max((one.excess_mm for one in self.violations(arm, joints)), default=0.0)


def deepest(broken: Sequence[Violation]) -> Violation:
    """Return the deepest of some violations."""
    return max(broken, key=lambda one: one.excess_mm)


@dataclass(frozen=True, slots=True, eq=False)
class GuardedArm:
    """Guards bound to an arm, for checking many postures."""

    guards: Guards
    arm: ArmGeometry
    links: Links | None

    def violations(self, joints: Joints) -> tuple[Violation, ...]:
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

    def _broken_sums(self, joints: Joints) -> Iterator[SumViolation]:
        for one in self.guards.sums:
            value = math.fsum(share * joints[joint] for joint, share in one.shares)
            excess = one.excess_rad(value)
            if excess > 0.0:
                reach_mm = max(self.arm.levers_mm(None))
                name = f"range of the {one.name}"
                yield SumViolation(name, one.name, value, one.bound_rad(value), excess * reach_mm)
