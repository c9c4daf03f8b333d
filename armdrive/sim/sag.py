"""How an arm without motor current comes down: each link a little, until it meets the table."""

from __future__ import annotations

import math

from kinematics.five_axis import FiveAxisArm
from kinematics.spaces import Joints

SAG_RAD = (math.radians(3.0), math.radians(5.2), math.radians(4.7))
"""How far upper arm, forearm and hand come down: about 60, 60 and 20 half-steps.

How far a real arm sags depends on its friction and load; this much is plain to see on a picture
and far beyond any tolerance.
"""
_HALVINGS = 20


def sagged(arm: FiveAxisArm, joints: Joints) -> Joints:
    """Return the posture that the arm comes to rest in; base and roll keep theirs."""
    if arm.fk(joints).z_mm <= 0.0:
        return joints
    if arm.fk(_lowered(joints, 1.0)).z_mm >= 0.0:
        return _lowered(joints, 1.0)
    free, blocked = 0.0, 1.0
    for _ in range(_HALVINGS):
        half = (free + blocked) / 2
        if arm.fk(_lowered(joints, half)).z_mm >= 0.0:
            free = half
        else:
            blocked = half
    return _lowered(joints, free)


def _lowered(joints: Joints, share: float) -> Joints:
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
