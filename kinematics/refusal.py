"""Why a pose cannot be reached, by how much, and what could be reached instead.

Units: mm and rad.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from kinematics.closed_form import wrist_distance
from kinematics.errors import Constraint, Unreachable, limit_sentence
from kinematics.nearest import nearest

if TYPE_CHECKING:
    from kinematics.five_axis import FiveAxisArm, RollFrame
    from kinematics.spaces import Joints, Pose


def refusal(
    arm: FiveAxisArm, pose: Pose, seed: Joints | None, roll_frame: RollFrame
) -> Unreachable:
    """Return the error that explains a pose which `arm.solve` could not meet.

    Where every branch breaks a limit, the branch that breaks its limits least is the one told of.
    """
    instead = nearest(arm, pose, seed, roll_frame).pose
    branches = arm.branches(pose, seed, roll_frame)
    if not branches:
        return _span_refusal(arm, pose, instead)
    best = min(branches, key=lambda branch: branch.excess_rad)
    worst = max(best.violations, key=lambda violation: violation.excess_rad)
    return Unreachable(
        limit_sentence(worst.joint, worst.value_rad, worst.bound_rad),
        constraint=Constraint.JOINT_LIMIT,
        joint=worst.joint,
        value=worst.value_rad,
        bound=worst.bound_rad,
        unit="rad",
        goal=pose,
        nearest=instead,
    )


def _span_refusal(arm: FiveAxisArm, pose: Pose, instead: Pose) -> Unreachable:
    """Return the error for a wrist that upper arm and forearm cannot span."""
    r = math.hypot(pose.x_mm, pose.y_mm)
    distance = wrist_distance(r, pose.z_mm, pose.pitch_rad, arm.lengths)
    longest = arm.upper_arm_mm + arm.forearm_mm
    too_far = distance > longest
    bound = longest if too_far else abs(arm.upper_arm_mm - arm.forearm_mm)
    gap = abs(distance - bound)
    reason = (
        f"the wrist would be {gap:.1f} mm beyond the {bound:.1f} mm that upper arm and forearm span"
        if too_far
        else f"the wrist would be {gap:.1f} mm nearer to the shoulder than the {bound:.1f} mm "
        "at which forearm folds back on upper arm"
    )
    return Unreachable(
        reason,
        constraint=Constraint.TOO_FAR if too_far else Constraint.TOO_NEAR,
        joint=None,
        value=distance,
        bound=bound,
        unit="mm",
        goal=pose,
        nearest=instead,
    )
