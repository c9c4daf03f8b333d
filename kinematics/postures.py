"""Every posture that an arm has for one pose, with the names that its build gives to them.

Units: mm and rad. An arm of the Mini-mover's build has four: base front or back, elbow up or down
(five_axis.py). Of an arm that is solved by numbers the one nearest to the seed is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from kinematics.five_axis import Branch

if TYPE_CHECKING:
    from kinematics.arm_geometry import ArmGeometry
    from kinematics.limits import LimitViolation
    from kinematics.spaces import Joints, Pose


@dataclass(frozen=True, slots=True)
class Posture:
    """One posture that holds the hand at a pose, and the limits it would break.

    `name` is empty where the arm's build gives no names to its postures.
    """

    name: str
    joints: Joints
    violations: tuple[LimitViolation, ...] = ()


@runtime_checkable
class Branching(Protocol):
    """An arm that knows all its postures for a pose."""

    def branches(self, pose: Pose, seed: Joints | None = None) -> tuple[Branch, ...]:
        """Return every posture for a pose, those beyond the limits included."""
        ...


def postures(arm: ArmGeometry, pose: Pose, seed: Joints) -> tuple[Posture, ...]:
    """Return the postures for a pose, each angle of the turn nearest to the seed that is allowed.

    Those beyond the limits are among them. None where no posture holds the hand there, whatever
    the limits; of an arm that is solved by numbers, also where no posture within them was found.
    """
    if isinstance(arm, Branching):
        return tuple(_named(branch) for branch in arm.branches(pose, seed))
    found = arm.solve(pose, seed)
    return () if found is None else (Posture("", found),)


def _named(branch: Branch) -> Posture:
    name = f"elbow {branch.elbow.value}, base {branch.base.value}"
    return Posture(name, branch.joints, branch.violations)
