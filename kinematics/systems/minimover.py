"""The Mini-mover 5 in the textbook's terms: its link table in this project's own joint angles.

Source: McKerrow, chapter 4, section 16. Joint angles are relative and up is positive: base;
shoulder, the elevation of the upper arm; elbow, forearm less upper arm; wrist pitch, hand less
forearm; wrist roll. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from kinematics.chains import Chain
from kinematics.five_axis import FiveAxisArm
from kinematics.links import DHLink
from kinematics.presets import preset
from kinematics.spaces import JOINT_NAMES
from kinematics.systems.mini_build import ELBOW_TRIANGLE, MiniBuild
from kinematics.systems.named_system import Step

QUARTER_TURN = math.pi / 2.0


def _minimover() -> FiveAxisArm:
    return preset("minimover5").arm


@dataclass(frozen=True, slots=True)
class MiniMover(MiniBuild):
    """The Mini-mover 5, or any arm of its build, in relative angles with up positive."""

    arm: FiveAxisArm = field(default_factory=_minimover)

    name: ClassVar[str] = "minimover5"
    title: ClassVar[str] = "Mini-mover 5 (five revolute joints)"
    source: ClassVar[str] = "McKerrow, chapter 4, section 16"
    derivation: ClassVar[tuple[Step, ...]] = (
        Step("base", "theta1 = atan2(y, x)", "the arm's plane holds the tip; or half a turn on"),
        Step(
            "wrist",
            "r0 = sqrt(x^2 + y^2) - d5 cos(P),  z0 = z - d1 - d5 sin(P)",
            "from the tip back along the hand, whose pitch P is given, seen from the shoulder",
        ),
        Step("elbow triangle", *ELBOW_TRIANGLE),
        Step(
            "shoulder",
            "theta2 = direction + lift,  direction = atan2(z0, r0)",
            "elbow up; elbow down takes the lift away. With equal links a2 = a3 = L, "
            "lift = acos(sqrt(r0^2 + z0^2) / 2L)",
        ),
        Step("elbow", "theta3 = -+ bend", "minus for elbow up"),
        Step("wrist pitch", "theta4 = P - theta2 - theta3", "elevations of parallel axes add up"),
        Step("wrist roll", "theta5 = R", "in the hand's frame; plus theta1 in the table's"),
    )
    drawing: ClassVar[str] = r"""
      z        theta3
      |   a2  .o-._  a3
      |    .-'     `-o theta4
      | .-'          | d5
      o' theta2      |
      | d1           v tip, theta5 about the hand
     _|_
    (___) theta1
    """

    def relative(self, joints: tuple[float, ...]) -> tuple[float, ...]:
        """Return the joint values as they are."""
        return joints

    def own(self, angles: tuple[float, ...]) -> tuple[float, ...]:
        """Return the angles as they are."""
        return angles

    def chain(self) -> Chain:
        """Return the link table: alpha = 90, 0, 0, 90, 0 degrees, theta4 offset by 90."""
        height, upper, fore, hand = self.arm.lengths
        rows = (
            (height, 0.0, QUARTER_TURN, 0.0),
            (0.0, upper, 0.0, 0.0),
            (0.0, fore, 0.0, 0.0),
            (0.0, 0.0, QUARTER_TURN, QUARTER_TURN),
            (hand, 0.0, 0.0, 0.0),
        )
        links = tuple(
            DHLink(0.0, d, a, alpha, offset=offset, low=limits.low_rad, high=limits.high_rad)
            for (d, a, alpha, offset), limits in zip(rows, self.arm.limits, strict=True)
        )
        return Chain(links, name=self.name, joint_names=JOINT_NAMES)
