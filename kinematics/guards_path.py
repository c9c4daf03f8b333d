"""Guards over whole paths: proved between the postures looked at, not only at them.

Lengths in mm, angles in rad. Conservative advancement (Mirtich, 1996): while no point of the arm
travels further than its room (guards_found.py), no guard can be broken. Two postures whose rooms
together cover the travel between them prove all that lies between; where they do not, the motion
is halved, until the travel is `step_mm` or less. So nowhere is the arm further beyond a guard
than half of `step_mm`, and mostly a few looks are enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from kinematics.arm_geometry import ArmGeometry
from kinematics.errors import KinematicsError, finite
from kinematics.guards import GuardedArm, Guards, Violation, deepest, worst
from kinematics.paths import JointPath
from kinematics.spaces import Joints

STEP_MM = 2.0
"""How near to one another postures are looked at, at most, where a guard is near."""

SLACK_MM = 1e-6
"""A depth that rounding alone makes greater has not grown."""

Key = tuple[str, str]


def first_violation(
    arm: ArmGeometry,
    guards: Guards,
    waypoints: Sequence[Joints],
    step_mm: float = STEP_MM,
    *,
    way_out: bool = False,
) -> tuple[float, Violation] | None:
    """Return where a path of joint motions first breaks a guard, or None.

    The fraction (0 to 1) of the answer is the share of a bound of the travel, over the whole
    path, that lies before it. With `way_out`, a guard that the start breaks is held against the
    path only where it gets deeper: every such guard by itself, from one look to the next, at
    most `step_mm` of travel apart, until the arm is free of it.
    """
    step = finite("step_mm", step_mm)
    if step <= 0.0:
        raise KinematicsError(f"step_mm must be more than 0, not {step}")
    if not waypoints:
        return None
    watch = _Watch(guards.over(arm), step)
    broken = watch.begin(waypoints[0])
    if broken is not None and not way_out:
        return 0.0, broken
    paths = [JointPath(a, b) for a, b in pairwise(waypoints)]
    travels = [arm.travel_bound_mm(path.changes_rad) for path in paths]
    total, done = sum(travels), 0.0
    for path, travel in zip(paths, travels, strict=True):
        found = watch.along(path, travel)
        if found is not None:
            share, violation = found
            return ((done + travel * share) / total if total > 0.0 else 1.0), violation
        done += travel
    return None


class _Watch:
    """One pass along a path: the room where it stands, and how deep each guard still may be."""

    def __init__(self, guarded: GuardedArm, step_mm: float) -> None:
        self._guarded = guarded
        self._step_mm = step_mm
        self._depths: dict[Key, float] = {}
        self._room_mm = 0.0

    def begin(self, joints: Joints) -> Violation | None:
        """Stand at the start; return the worst guard that it breaks."""
        self._room_mm = self._guarded.room_mm(joints)
        if self._room_mm >= 0.0:
            return None
        broken = self._guarded.violations(joints)
        self._depths = {(one.guard, one.quantity): one.excess_mm for one in broken}
        return worst(broken)

    def along(self, path: JointPath, travel_mm: float) -> tuple[float, Violation] | None:
        """Go along one joint motion; return the share of it where a guard is first broken."""
        share = 0.0
        if self._depths:
            count = max(int(travel_mm / self._step_mm) + 1, 1)
            for part in range(1, count + 1):
                share = part / count
                worse = self._deeper(path.at(share))
                if worse is not None:
                    return share, worse
                if not self._depths:
                    break
        if share >= 1.0:
            return None
        found = self._prove(path, share, travel_mm)
        if found is None:
            return None
        return found, deepest(self._guarded.violations(path.at(found)))

    def _deeper(self, joints: Joints) -> Violation | None:
        """Return the guard that is deeper than a moment ago, or newly broken."""
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
        self._room_mm = self._guarded.room_mm(joints) if not broken else self._room_mm
        return worst(grown)

    def _prove(self, path: JointPath, low: float, travel_mm: float) -> float | None:
        """Return the first share looked at that breaks a guard, None where all is proved free."""
        room = self._guarded.room_mm
        ahead = [(1.0, room(path.goal))]
        while ahead:
            high, beyond_mm = ahead[-1]
            gap_mm = (high - low) * travel_mm
            near = gap_mm <= self._step_mm
            if beyond_mm < 0.0 and near:
                return high
            if beyond_mm >= 0.0 and (near or self._room_mm + beyond_mm >= gap_mm):
                low, self._room_mm = high, beyond_mm
                ahead.pop()
            else:
                middle = (low + high) / 2.0
                ahead.append((middle, room(path.at(middle))))
        return None
