"""What `home` asks of whoever looks at the arm."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from kinematics import Joints, Pose

if TYPE_CHECKING:
    from armdrive.arm import Arm


class PostureRequest:
    """What `home` asks of an operator: bring the arm to this posture, and say whether it is there.

    While the operator is at work, `arm` may be jogged; nothing else is allowed.
    """

    def __init__(self, arm: Arm, pose: Pose, joints: Joints, opening_mm: float) -> None:
        self.arm = arm
        self.pose = pose
        self.joints = joints
        self.opening_mm = opening_mm

    def __str__(self) -> str:
        return (
            f"Bring the arm to its reference posture: finger tips touching the table "
            f"{self.pose.x_mm:.0f} mm in front of the base axis, hand straight down, wrist "
            f"turnbuckles lined up, fingers just touching each other. ({self.pose})"
        )


class MarkRequest(PostureRequest):
    """What `verify` asks: the same posture, brought about by small jogs, as exactly as can be."""

    def __str__(self) -> str:
        return (
            f"Bring the finger tips onto the reference mark, {self.pose.x_mm:.0f} mm in front of "
            f"the base axis, in small jogs: tips just touching the table, hand straight down, "
            f"wrist turnbuckles lined up, fingers just touching each other. ({self.pose})"
        )


Operator = Callable[[PostureRequest], bool]
"""Somebody who looks at the arm: returns True when it stands in the posture asked for."""
