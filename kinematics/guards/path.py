"""Guards over whole paths: proved between the sampled postures, not only at them.

Lengths in mm, angles in rad. Conservative advancement (Mirtich, 1996): while no point of the arm
travels further than its room (`GuardedArm.room_mm`), no guard can be violated. Two postures whose
rooms together cover the travel between them prove everything in between. If they do not, the motion
is halved, until the travel is `STEP_MM` or less. So the arm is nowhere further beyond a guard than
half of `STEP_MM`, and usually a few samples are enough.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from kinematics.geometry import ArmGeometry
from kinematics.guards import GuardedArm, Guards, GuardViolation, deepest
from kinematics.paths.curves import JointPath
from kinematics.spaces import Joints

# The largest distance between sampled postures near a guard.
STEP_MM = 2.0

# A depth that grows by rounding alone has not grown.
SLACK_MM = 1e-6

# A guard and its quantity: each of them on its own may get no deeper.
Key = tuple[str, str]


def first_violation(
    arm: ArmGeometry, guards: Guards, waypoints: Sequence[Joints]
) -> tuple[float, GuardViolation] | None:
    """Return where a path of joint motions first violates a guard, or None.

    The fraction (0 to 1) in the result is the share of the total travel bound that lies before the
    violation. A path may lead out of a guard: one violated at the start counts only if it gets
    deeper, every such guard separately, from one sample to the next, at most `STEP_MM` of travel
    apart, until the arm is free of it.
    """
    if not waypoints:
        return None
    watch = _Watch(guards.over(arm), waypoints[0])
    motions = [JointPath(a, b) for a, b in pairwise(waypoints)]
    travels_mm = [arm.travel_bound_mm(motion.changes_rad) for motion in motions]
    done_mm, total_mm = 0.0, sum(travels_mm)
    for motion, travel_mm in zip(motions, travels_mm, strict=True):
        found = watch.along(motion, travel_mm)
        if found is not None:
            share, violation = found
            whole = done_mm + travel_mm * share
            return (whole / total_mm if total_mm > 0.0 else 1.0), violation
        done_mm += travel_mm
    return None


class _Watch:
    """One pass along a path: the room at the present posture, and how deep each guard may be."""

    def __init__(self, guarded: GuardedArm, start: Joints) -> None:
        self._guarded = guarded
        self._room_mm = guarded.room_mm(start)
        broken = guarded.violations(start) if self._room_mm < 0.0 else ()
        self._depths: dict[Key, float] = {
            (one.guard, one.quantity): one.excess_mm for one in broken
        }

    def along(self, motion: JointPath, travel_mm: float) -> tuple[float, GuardViolation] | None:
        """Follow one joint motion; return the share at which a guard is first violated.

        No point of the arm travels further during it than `travel_mm`.
        """
        share = 0.0
        if self._depths:
            count = int(travel_mm / STEP_MM) + 1
            for part in range(1, count + 1):
                share = part / count
                worse = self._deeper(motion.at(share))
                if worse is not None:
                    return share, worse
                if not self._depths:
                    break
        if share >= 1.0:
            return None
        found = self._prove(motion, travel_mm, share)
        if found is None:
            return None
        return found, deepest(self._guarded.violations(motion.at(found)))

    def _deeper(self, joints: Joints) -> GuardViolation | None:
        """Return a guard that is deeper than at the previous sample, or newly violated."""
        broken = self._guarded.violations(joints)
        now = {(one.guard, one.quantity): one.excess_mm for one in broken}
        grown = tuple(
            one
            for one in broken
            if one.excess_mm > self._depths.get((one.guard, one.quantity), 0.0) + SLACK_MM
        )
        self._depths = {
            key: min(depth, now[key]) for key, depth in self._depths.items() if key in now
        }
        self._room_mm = self._guarded.room_mm(joints)
        return deepest(grown) if grown else None

    def _prove(self, motion: JointPath, travel_mm: float, low: float) -> float | None:
        """Return the first sampled share that violates a guard; None if all is proved free."""
        room_mm = self._guarded.room_mm
        ahead = [(1.0, room_mm(motion.goal))]
        while ahead:
            high, beyond_mm = ahead[-1]
            part_mm = (high - low) * travel_mm
            near = part_mm <= STEP_MM
            if near and beyond_mm < 0.0:
                return high
            if beyond_mm >= 0.0 and (near or self._room_mm + beyond_mm >= part_mm):
                low, self._room_mm = high, beyond_mm
                ahead.pop()
            else:
                middle = (low + high) / 2.0
                ahead.append((middle, room_mm(motion.at(middle))))
        return None


# How near an arm comes to each of its guards along a path, and where. Only guards on distances are
# considered; sums of joint angles are not.


@dataclass(frozen=True, slots=True)
class Clearance:
    """The least distance from one guard, negative beyond it, and what comes so near to it.

    `quantity` is the part of the arm, or the measure, that the guard concerns; `index` is the index
    of the posture, and `joints` the posture itself.
    """

    guard: str
    quantity: str
    clearance_mm: float
    index: int
    joints: Joints


def least_clearances(guarded: GuardedArm, postures: Iterable[Joints]) -> tuple[Clearance, ...]:
    """Return each guard's least clearance over some postures, the nearest guard first.

    Between two postures no clearance is below the smaller one by more than half of the travel of
    any point of the arm from one to the other.
    """
    least: dict[str, Clearance] = {}
    for index, joints in enumerate(postures):
        for reading in guarded.readings(joints):
            known = least.get(reading.guard)
            if known is None or reading.clearance_mm < known.clearance_mm:
                least[reading.guard] = Clearance(
                    reading.guard, reading.quantity, reading.clearance_mm, index, joints
                )
    return tuple(sorted(least.values(), key=lambda one: one.clearance_mm))
