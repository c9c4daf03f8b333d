"""How a new simulated arm stands in the morning: raised and clear of the table."""

from __future__ import annotations

import random

from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.tool_arm import ToolArm
from kinematics.geometry import ArmGeometry
from kinematics.spaces import Joints

FOUND_POSTURE = Joints.of(0.0, 70.0, -95.0, -35.0, 0.0)
"""The posture of an arm of the Mini-mover's build."""

CLEAR_MM = 30.0
_TRIES = 500
_SHARE = 0.5


def found_posture(arm: ArmGeometry) -> Joints:
    """Return the posture in which somebody left the arm; the same one for the same arm.

    Of an arm that is no Mini-mover, the middle of its ranges if every point is above the table
    there, or else the first clear one of random postures in the middle half of the ranges; where
    none of those is clear, the highest.
    """
    if isinstance(arm, FiveAxisArm | ToolArm):
        return FOUND_POSTURE
    draw = random.Random(1)  # noqa: S311 - any posture will do
    best, height_mm = _between(arm, [0.5] * len(arm.limits)), float("-inf")
    for attempt in range(_TRIES):
        shares = [0.5 + (draw.random() - 0.5) * _SHARE * (attempt > 0) for _ in arm.limits]
        joints = _between(arm, shares)
        lowest_mm = min(point[2] for point in arm.points(joints)[-len(arm.moving_points) :])
        if lowest_mm > height_mm:
            best, height_mm = joints, lowest_mm
        if height_mm >= CLEAR_MM:
            break
    return best


def _between(arm: ArmGeometry, shares: list[float]) -> Joints:
    return Joints(
        tuple(
            one.low_rad + share * (one.high_rad - one.low_rad)
            for one, share in zip(arm.limits, shares, strict=True)
        ),
        arm.joint_names,
    )
