"""Why an arm given by its link table cannot take a pose, and which pose it can take instead.

What numbers did not find is not proved to be out of reach, and the sentence says so. Units: mm
and rad.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from kinematics.chain_task import pose_of
from kinematics.errors import Constraint, Unreachable, limit_sentence
from kinematics.following import largest_turn, leap_sentence
from kinematics.ik_account import Reason

if TYPE_CHECKING:
    from kinematics.chain_arm import ChainArm
    from kinematics.ik_account import Solution
    from kinematics.spaces import Joints, Pose

HELD_RAD = 1e-6
"""An angle of the hand nearer to the asked one than this is the asked one."""


def chain_refusal(arm: ChainArm, pose: Pose, found: Solution) -> Unreachable:
    """Return the error that explains the best posture found for a pose."""
    nearest = nearest_of(arm, pose, found)
    if found.reason is Reason.BEYOND_REACH:
        centre, radius = arm.chain.reach_sphere
        away = math.dist((pose.x_mm, pose.y_mm, pose.z_mm), centre)
        reason = (
            f"the tip would be {away - radius:.1f} mm beyond the {radius:.1f} mm that all links "
            "together span"
        )
        return _refused(Constraint.TOO_FAR, reason, away, radius, "mm", pose, nearest)
    if found.reason is Reason.JOINT_LIMIT and found.violations:
        worst = max(found.violations, key=lambda one: one.excess)
        reason = limit_sentence(worst.joint, worst.value, worst.bound)
        return _refused(
            Constraint.JOINT_LIMIT,
            reason,
            worst.value,
            worst.bound,
            "rad",
            pose,
            nearest,
            joint=worst.joint,
        )
    return _not_found(pose, nearest, found)


def step_refusal(arm: ChainArm, pose: Pose, found: Solution, seed: Joints) -> Unreachable:
    """Return the error for a small step that leads nowhere near the posture it starts from."""
    if found.ok:
        name, turn = largest_turn(seed, arm.joints_of(found.joints))
        reason = leap_sentence(name, turn, "the posture is singular here")
        return _refused(Constraint.NO_POSTURE, reason, turn, 0.0, "rad", pose, arm.fk(seed))
    if found.at_limit:
        joint = found.at_limit[0]
        index = arm.joint_names.index(joint)
        value, nearest = found.joints[index], nearest_of(arm, pose, found)
        reason = f"the {joint.replace('_', ' ')} is at its limit of {math.degrees(value):.1f}°"
        return _refused(
            Constraint.JOINT_LIMIT, reason, value, value, "rad", pose, nearest, joint=joint
        )
    return _not_found(pose, nearest_of(arm, pose, found), found)


def nearest_of(arm: ChainArm, pose: Pose, found: Solution) -> Pose:
    """Return the pose of the best posture found, in the goal's own angles where they are held.

    A tip on the other side of the base axis than the goal holds another pitch and roll, although
    its hand points where the goal's does.
    """
    reached = pose_of(found.frame, arm.task, arm.centre)
    pairs = (
        (pose.pitch_rad, reached.pitch_rad),
        (pose.roll_rad, reached.roll_rad),
        (pose.yaw_rad or 0.0, reached.yaw_rad or 0.0),
    )
    if all(abs(math.remainder(a - b, math.tau)) <= HELD_RAD for a, b in pairs):
        return replace(pose, x_mm=reached.x_mm, y_mm=reached.y_mm, z_mm=reached.z_mm)
    return reached


def _not_found(pose: Pose, nearest: Pose, found: Solution) -> Unreachable:
    away = math.dist((pose.x_mm, pose.y_mm, pose.z_mm), (nearest.x_mm, nearest.y_mm, nearest.z_mm))
    if found.residual_rad > HELD_RAD:
        gap = math.degrees(found.residual_rad)
        reason = f"no posture was found; the nearest one misses the hand's direction by {gap:.2f}°"
        value, unit = found.residual_rad, "rad"
    else:
        reason = f"no posture was found; the nearest one stays {away:.2f} mm away"
        value, unit = away, "mm"
    return _refused(Constraint.NO_POSTURE, reason, value, 0.0, unit, pose, nearest)


def _refused(
    constraint: Constraint,
    reason: str,
    value: float,
    bound: float,
    unit: str,
    goal: Pose,
    nearest: Pose,
    joint: str | None = None,
) -> Unreachable:
    return Unreachable(
        reason,
        constraint=constraint,
        joint=joint,
        value=value,
        bound=bound,
        unit=unit,
        goal=goal,
        nearest=nearest,
    )
