"""How near an arm comes to each of its guards along a way, and where on it.

Lengths in mm. Only guards on distances are looked at; sums of joint angles are not among them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kinematics.guards import GuardedArm

if TYPE_CHECKING:
    from kinematics.guards_found import Reading
    from kinematics.spaces import Joints


@dataclass(frozen=True, slots=True)
class Clearance:
    """The least distance from one guard, below 0 beyond it, and what comes so near to it.

    `quantity` is the part of the arm, or the measure, that the guard is about; `index` is that of
    the posture, and `joints` the posture itself.
    """

    guard: str
    quantity: str
    clearance_mm: float
    index: int
    joints: Joints


def least_clearances(guarded: GuardedArm, postures: Iterable[Joints]) -> tuple[Clearance, ...]:
    """Return each guard's least clearance over some postures, the nearest guard first.

    Between two postures no clearance is less than the smaller one by more than half of the way
    that any point of the arm travels from one to the other.
    """
    least: dict[str, Clearance] = {}
    for index, joints in enumerate(postures):
        for reading in guarded.readings(joints):
            known = least.get(reading.guard)
            if known is None or reading.clearance_mm < known.clearance_mm:
                least[reading.guard] = _clearance(reading, index, joints)
    return tuple(sorted(least.values(), key=lambda one: one.clearance_mm))


def _clearance(reading: Reading, index: int, joints: Joints) -> Clearance:
    return Clearance(reading.guard, reading.quantity, reading.clearance_mm, index, joints)
