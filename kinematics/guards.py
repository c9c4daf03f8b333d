"""Places where the arm would hit the table or itself, as a table of rules on its points.

Lengths in mm, angles in rad. r is the distance from the base axis. Source of the numbers: the
guards that public TeachMover programs carry.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from kinematics.arm_geometry import ArmGeometry
from kinematics.spaces import Joints

ROUNDING_MM = 1e-6
"""A pose that stands on a guard's bound is allowed, whichever way its last digit fell."""


@dataclass(frozen=True, slots=True)
class GuardViolation:
    """One guard that a posture breaks.

    `value_mm` of `quantity` against `bound_mm`; `excess_mm` is the least distance that would
    free the arm of this guard. `sentence` says it to a person.
    """

    guard: str
    quantity: str
    value_mm: float
    bound_mm: float
    excess_mm: float
    sentence: str


@dataclass(frozen=True, slots=True)
class Guards:
    """The bounds, each None where an arm has no such guard.

    The tip, wrist and elbow must stay above the table (z = 0), `tolerance_mm` allowed, because
    rounding to motor steps alone puts a tip on the table some hundredths below it. The tip must
    not be nearer to the base axis than `inner_radius_mm` while below `inner_height_mm`, nor
    further than `outer_radius_mm`. And the hand must not point backwards (pitch below -90
    degrees) into the base: wrist nearer than `hand_wrist_radius_mm`, tip nearer than
    `hand_tip_radius_mm` (public programs write x for it, with the arm turned to the front) and
    the tip lower than `hand_height_mm`.
    """

    tolerance_mm: float = 1.0
    table: bool = True
    inner_radius_mm: float | None = 57.0
    inner_height_mm: float = 381.0
    outer_radius_mm: float | None = 453.0
    hand_wrist_radius_mm: float | None = 89.0
    hand_tip_radius_mm: float = 57.0
    hand_height_mm: float = 32.0

    def violations(self, arm: ArmGeometry, joints: Joints) -> tuple[GuardViolation, ...]:
        """Return every guard that a posture breaks."""
        points = arm.points(joints)
        tip_r, wrist_r = math.hypot(*points[-1][:2]), math.hypot(*points[-2][:2])
        tip_z = points[-1][2]
        return (
            *self._table(arm.moving_points, points),
            *self._inner(tip_r, tip_z),
            *self._outer(tip_r),
            *self._hand(arm.fk(joints).pitch_rad, wrist_r, tip_r, tip_z),
        )

    def violation(self, arm: ArmGeometry, joints: Joints) -> GuardViolation | None:
        """Return the guard that a posture breaks most, or None."""
        return max(self.violations(arm, joints), key=lambda broken: broken.excess_mm, default=None)

    def depth_mm(self, arm: ArmGeometry, joints: Joints) -> float:
        """Return how deep a posture is inside the guards, 0 outside all: leaving makes it less."""
        worst = self.violation(arm, joints)
        return worst.excess_mm if worst else 0.0

    def _table(
        self, names: tuple[str, ...], points: tuple[tuple[float, float, float], ...]
    ) -> Iterator[GuardViolation]:
        if not self.table:
            return
        for name, (_, _, z) in zip(names, points[-len(names) :], strict=True):
            if z < -self.tolerance_mm - ROUNDING_MM:
                yield GuardViolation(
                    "table",
                    f"{name} z",
                    z,
                    0.0,
                    -z,
                    f"the {name} would be {-z:.1f} mm below the table",
                )

    def _inner(self, tip_r: float, tip_z: float) -> Iterator[GuardViolation]:
        if self.inner_radius_mm is None:
            return
        short, low = self.inner_radius_mm - tip_r, self.inner_height_mm - tip_z
        if min(short, low) > ROUNDING_MM:
            yield GuardViolation(
                "inner radius",
                "tip radius",
                tip_r,
                self.inner_radius_mm,
                min(short, low),
                f"the tip would be {tip_r:.1f} mm from the base axis, inside the arm's body: below "
                f"z {self.inner_height_mm:.0f} mm it must keep {self.inner_radius_mm:.0f} mm away",
            )

    def _outer(self, tip_r: float) -> Iterator[GuardViolation]:
        if self.outer_radius_mm is None or tip_r <= self.outer_radius_mm + ROUNDING_MM:
            return
        yield GuardViolation(
            "outer radius",
            "tip radius",
            tip_r,
            self.outer_radius_mm,
            tip_r - self.outer_radius_mm,
            f"the tip would be {tip_r:.1f} mm from the base axis, "
            f"beyond the guard at {self.outer_radius_mm:.0f} mm",
        )

    def _hand(
        self, pitch: float, wrist_r: float, tip_r: float, tip_z: float
    ) -> Iterator[GuardViolation]:
        if self.hand_wrist_radius_mm is None or not -math.pi < pitch < -math.pi / 2.0 - 1e-9:
            return
        gaps = (
            self.hand_wrist_radius_mm - wrist_r,
            self.hand_tip_radius_mm - tip_r,
            self.hand_height_mm - tip_z,
        )
        if min(gaps) > ROUNDING_MM:
            yield GuardViolation(
                "hand against base",
                "wrist radius",
                wrist_r,
                self.hand_wrist_radius_mm,
                min(gaps),
                f"the hand would hit the base: it points backwards with the wrist {wrist_r:.1f} mm "
                f"from the base axis, where {self.hand_wrist_radius_mm:.0f} mm are needed",
            )
