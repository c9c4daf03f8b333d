"""The nearest pose that is both in reach and outside every guard.

Lengths in mm.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from kinematics.arm_geometry import ArmGeometry
from kinematics.closed_form import AXIS_MM
from kinematics.guards import Guards, GuardViolation
from kinematics.spaces import Joints, Pose

MOVES = 4
"""How many bounds a goal is moved to, one after another, before that way is given up."""


def nearest_allowed(
    arm: ArmGeometry, guards: Guards, pose: Pose, seed: Joints | None = None
) -> Pose | None:
    """Return a reachable pose near `pose` that breaks no guard, its pitch and roll held if any.

    The goal is moved to the bounds of the guards that it breaks, alone and one after another,
    each time to the nearest pose in reach. Of the poses that `arm.ik` then solves (with this
    seed) outside every guard, the one nearest to the goal is returned; None where `MOVES` such
    moves find none. With one guard broken and the bound in reach, the answer is exact.
    """
    best: Pose | None = None
    least = math.inf
    direction = _direction(arm, pose, seed)
    seen: set[Pose] = set()
    tries = [pose]
    for _ in range(MOVES + 1):
        following: list[Pose] = []
        for goal in tries:
            near = arm.nearest_pose(goal, seed)
            joints = arm.solve(near, seed)
            if joints is None:  # pragma: no cover - what is in reach has a posture
                continue
            broken = guards.violations(arm, joints)
            distance = _distance(near, pose)
            if not broken and distance < least:
                best, least = near, distance
            for violation in broken:
                for start in (goal, near):
                    following += _escapes(guards, violation, start, direction)
        tries = [goal for goal in following if _new(goal, seen)]
    return best


def _direction(arm: ArmGeometry, pose: Pose, seed: Joints | None) -> float:
    """Return the direction of a pose from the base axis, or the seed's for a pose on the axis."""
    if math.hypot(pose.x_mm, pose.y_mm) > AXIS_MM:
        return math.atan2(pose.y_mm, pose.x_mm)
    return arm.limits[0].clamp(seed[0] if seed else 0.0)


def _new(pose: Pose, seen: set[Pose]) -> bool:
    """Say whether a pose was not tried yet, to a thousandth of a mm, and note it."""
    rounded = replace(
        pose, x_mm=round(pose.x_mm, 3), y_mm=round(pose.y_mm, 3), z_mm=round(pose.z_mm, 3)
    )
    if rounded in seen:
        return False
    seen.add(rounded)
    return True


def _escapes(
    guards: Guards, violation: GuardViolation, pose: Pose, direction: float
) -> Iterator[Pose]:
    """Yield the poses that leave one guard by each of its bounds."""
    if violation.guard == "table":
        yield replace(pose, z_mm=pose.z_mm + violation.excess_mm)
    elif violation.guard == "outer radius" and guards.outer_radius_mm is not None:
        yield _at_radius(pose, guards.outer_radius_mm, direction)
    elif violation.guard == "inner radius" and guards.inner_radius_mm is not None:
        yield _at_radius(pose, guards.inner_radius_mm, direction)
        yield replace(pose, z_mm=guards.inner_height_mm)
    elif violation.guard == "hand against base":
        yield _at_radius(pose, guards.hand_tip_radius_mm, direction)
        yield replace(pose, z_mm=guards.hand_height_mm)
        yield _at_radius(pose, math.hypot(pose.x_mm, pose.y_mm) + violation.excess_mm, direction)


def _at_radius(pose: Pose, radius: float, direction: float) -> Pose:
    """Return the pose moved to a distance from the base axis, in a direction from it."""
    return replace(pose, x_mm=radius * math.cos(direction), y_mm=radius * math.sin(direction))


def _distance(a: Pose, b: Pose) -> float:
    return math.dist((a.x_mm, a.y_mm, a.z_mm), (b.x_mm, b.y_mm, b.z_mm))
