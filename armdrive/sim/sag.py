"""How an arm without motor current comes down: each link a little, until it meets the table."""

from __future__ import annotations

import math
from collections.abc import Callable

from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.tool_arm import ToolArm
from kinematics.geometry import ArmGeometry
from kinematics.spaces import Joints

SAG_RAD = (math.radians(3.0), math.radians(5.2), math.radians(4.7))
"""How far upper arm, forearm and hand come down: about 60, 60 and 20 half-steps.

How far a real arm sags depends on its friction and load; this much is plain to see on a picture
and far beyond any tolerance.
"""
_HALVINGS = 20
_LOOK_RAD = 1e-4


def sagged(arm: ArmGeometry, joints: Joints) -> Joints:
    """Return the posture that the arm comes to rest in; what lowers nothing keeps its angle."""
    if arm.fk(joints).z_mm <= 0.0:
        return joints
    linked = isinstance(arm, FiveAxisArm | ToolArm)
    lowered = _links_lowered if linked else _tip_lowered(arm, joints)
    if arm.fk(lowered(joints, 1.0)).z_mm >= 0.0:
        return lowered(joints, 1.0)
    free, blocked = 0.0, 1.0
    for _ in range(_HALVINGS):
        half = (free + blocked) / 2
        if arm.fk(lowered(joints, half)).z_mm >= 0.0:
            free = half
        else:
            blocked = half
    return lowered(joints, free)


def _links_lowered(joints: Joints, share: float) -> Joints:
    base, shoulder, elbow, wrist, roll = joints.angles_rad
    upper, fore, hand = (
        _fallen(elevation, share * most)
        for elevation, most in zip(
            (shoulder, shoulder + elbow, shoulder + elbow + wrist), SAG_RAD, strict=True
        )
    )
    return Joints((base, upper, fore - upper, hand - fore, roll), joints.names)


def _fallen(elevation: float, most: float) -> float:
    """Turn a link towards hanging straight down, whichever way is down for it."""
    way = math.remainder(-math.pi / 2 - elevation, math.tau)
    return elevation + math.copysign(min(abs(way), most), way)


def _tip_lowered(arm: ArmGeometry, start: Joints) -> Callable[[Joints, float], Joints]:
    """Return how the joints of any arm give way: each as it lowers the tip, within its range."""
    here_mm = arm.fk(start).z_mm
    slopes = [
        (arm.fk(start.replace(**{name: angle + _LOOK_RAD})).z_mm - here_mm) / _LOOK_RAD
        for name, angle in zip(start.names, start, strict=True)
    ]
    steepest = max(map(abs, slopes)) or 1.0

    def lowered(joints: Joints, share: float) -> Joints:
        angles = (
            min(max(angle - share * SAG_RAD[0] * slope / steepest, low), high)
            for angle, slope, low, high in zip(
                joints,
                slopes,
                (min(one.low_rad, at) for one, at in zip(arm.limits, start, strict=True)),
                (max(one.high_rad, at) for one, at in zip(arm.limits, start, strict=True)),
                strict=True,
            )
        )
        return Joints(tuple(angles), joints.names)

    return lowered
