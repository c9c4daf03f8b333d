"""A pose near a goal that is in reach and outside every guard. Lengths in mm, angles in rad."""

from __future__ import annotations

import math
from dataclasses import replace

from kinematics.frames.numbers import last_that
from kinematics.geometry import ArmGeometry
from kinematics.guards import GuardedArm, Guards
from kinematics.spaces import Joints, Pose

# How far a goal is raised in search of a way over what it is in, in steps of this length.
HIGHEST_MM, RISE_MM = 400.0, 10.0

# How often the last step of a search is halved: to less than a hundredth of a mm.
HALVINGS = 12


def nearest_allowed(
    arm: ArmGeometry, guards: Guards, pose: Pose, seed: Joints | None = None
) -> Pose | None:
    """Return a reachable pose near `pose` that violates no guard, with its pitch and roll if any.

    It is the goal (or the reachable pose nearest to it) raised until it is allowed, or the furthest
    allowed pose on the straight way from an allowed seed's pose to the goal: the nearer of them.
    `arm.ik` with this seed solves it outside every guard. None if there is neither.
    """
    guarded = guards.over(arm)
    near = arm.nearest_pose(pose, seed)
    if _is_allowed(guarded, near, seed):
        return near
    found = [_raised(guarded, near, seed), _on_the_way(guarded, pose, seed)]
    allowed = (one for one in found if one is not None and _is_allowed(guarded, one, seed))
    return min(allowed, key=lambda one: math.dist(one.position_mm, pose.position_mm), default=None)


def _is_allowed(guarded: GuardedArm, pose: Pose, seed: Joints | None) -> bool:
    joints = guarded.arm.solve(pose, seed)
    return joints is not None and not guarded.violations(joints)


def _raised(guarded: GuardedArm, pose: Pose, seed: Joints | None) -> Pose | None:
    """Return the lowest pose above a reachable one that is clear of every guard's bound, if any.

    The arm is followed upwards in small steps: one that is solved numerically needs a posture near
    by, or it takes long to be sure that there is none.
    """
    z_mm, joints = pose.z_mm, guarded.arm.solve(pose, seed)

    def at(z_mm: float) -> Joints | None:
        return joints and guarded.arm.solve_near(replace(pose, z_mm=z_mm), joints)

    while joints is not None and z_mm < pose.z_mm + HIGHEST_MM:
        above_mm, above = z_mm + RISE_MM, at(z_mm + RISE_MM)
        if _is_clear(guarded, above):
            lowest_mm = last_that(lambda z: _is_clear(guarded, at(z)), above_mm, z_mm, HALVINGS)
            return replace(pose, z_mm=lowest_mm)
        z_mm, joints = above_mm, above
    return None


def _is_clear(guarded: GuardedArm, joints: Joints | None) -> bool:
    """Whether there is a posture, and it passes no guard's bound, not even within the tolerance."""
    return (
        joints is not None
        and not guarded.violations(joints)
        and all(reading.clearance_mm >= 0.0 for reading in guarded.readings(joints))
    )


def _on_the_way(guarded: GuardedArm, goal: Pose, seed: Joints | None) -> Pose | None:
    """Return the furthest allowed pose on the way to a goal; None without an allowed seed."""
    if seed is None or guarded.violations(seed):
        return None
    start = guarded.arm.fk(seed)
    low, high, nearby = 0.0, 1.0, seed
    for _ in range(HALVINGS):
        middle = (low + high) / 2.0
        there = _between(start, goal, middle)
        joints = guarded.arm.solve_near(there, nearby)
        if joints is not None and _is_allowed(guarded, there, seed):
            low, nearby = middle, joints
        else:
            high = middle
    return _between(start, goal, low)


def _between(start: Pose, end: Pose, share: float) -> Pose:
    """Return the pose at a share of the way in x, y, z and, the shorter way round, the angles."""
    values = {
        name: getattr(start, name) + share * (getattr(end, name) - getattr(start, name))
        for name in ("x_mm", "y_mm", "z_mm")
    }
    for name in ("pitch_rad", "roll_rad", "yaw_rad"):
        begun, ended = getattr(start, name), getattr(end, name)
        if begun is not None and ended is not None:
            values[name] = begun + share * math.remainder(ended - begun, math.tau)
    return Pose(**values)
