"""The Alpha II in its lecture's own terms: link table and joint angles with their own signs.

Source: T. Asokan, Introduction to Robotics, lecture 2.7: alpha = -90, 0, 0, -90, 0 degrees,
d1 = 215, a2 = a3 = 177.8, d5 = 129.5 mm. Its axes 2, 3 and 4 point the other way than the
Mini-mover's, so that angles count downwards, and theta4 is -90 degrees with the hand straight on.
Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from kinematics.chains import Chain
from kinematics.five_axis import FiveAxisArm
from kinematics.links import DHLink
from kinematics.presets import preset
from kinematics.systems.mini_build import ELBOW_TRIANGLE, MiniBuild
from kinematics.systems.named_system import Step

QUARTER_TURN = math.pi / 2.0
NAMES = ("base", "shoulder", "elbow", "tool_pitch", "tool_roll")


def _alpha2() -> FiveAxisArm:
    return preset("alpha2").arm


@dataclass(frozen=True, slots=True)
class Alpha2(MiniBuild):
    """The Alpha II, or any arm of its build, in the angles of the lecture's link table."""

    arm: FiveAxisArm = field(default_factory=_alpha2)

    name: ClassVar[str] = "alpha2"
    title: ClassVar[str] = "Alpha II (five revolute joints)"
    source: ClassVar[str] = "Asokan, Introduction to Robotics, lecture 2.7"
    derivation: ClassVar[tuple[Step, ...]] = (
        Step(
            "frames",
            "z0 up the base, z1, z2, z3 along the parallel axes, z4 and z5 along the hand",
            "frames 3 and 4 share the wrist, where z3 and z4 meet; frame 5 is at the tip",
        ),
        Step(
            "link table",
            "alpha = -90, 0, 0, -90, 0 degrees;  d1 = 215, a2 = a3 = 177.8, d5 = 129.5 mm",
            "z1 = z0 turned by -90 degrees about x1, z4 = z3 turned by -90 degrees about x4",
        ),
        Step("home", "theta4 = -90 degrees", "x4 points up and z4 along the hand, straight on"),
        Step("base", "theta1 = atan2(y, x)", "or half a turn on"),
        Step(
            "wrist",
            "r0 = sqrt(x^2 + y^2) - d5 cos(P),  z0 = z - d1 - d5 sin(P)",
            "P is the hand's pitch above the horizontal",
        ),
        Step("elbow triangle", *ELBOW_TRIANGLE),
        Step(
            "shoulder and elbow",
            "theta2 = -(direction +- lift),  theta3 = +- bend",
            "upper signs for elbow up; both count downwards",
        ),
        Step("tool pitch", "theta4 = -P - theta2 - theta3 - 90 degrees"),
        Step("tool roll", "theta5 = R"),
    )
    drawing: ClassVar[str] = r"""
      z0       elbow    wrist
      |   a2     o========o------> z4, z5
      |        .'    a3     d5   tip
      |      .'
      o====='  shoulder (z1, z2, z3 point into the page)
      | d1
     _|_
    (___) theta1       x0 ->
    """

    def relative(self, joints: tuple[float, ...]) -> tuple[float, ...]:
        """Return the lecture's angles as relative ones with up positive."""
        base, shoulder, elbow, pitch, roll = joints
        return base, -shoulder, -elbow, -pitch - QUARTER_TURN, roll

    def own(self, angles: tuple[float, ...]) -> tuple[float, ...]:
        """Return relative angles, up positive, as the lecture's."""
        base, shoulder, elbow, wrist, roll = angles
        return base, -shoulder, -elbow, -wrist - QUARTER_TURN, roll

    def chain(self) -> Chain:
        """Return the lecture's link table, limits turned to its signs."""
        height, upper, fore, hand = self.arm.lengths
        rows = (
            (height, 0.0, -QUARTER_TURN),
            (0.0, upper, 0.0),
            (0.0, fore, 0.0),
            (0.0, 0.0, -QUARTER_TURN),
            (hand, 0.0, 0.0),
        )
        lows = self.own(tuple(limits.low_rad for limits in self.arm.limits))
        highs = self.own(tuple(limits.high_rad for limits in self.arm.limits))
        links = tuple(
            DHLink(0.0, d, a, alpha, low=min(low, high), high=max(low, high))
            for (d, a, alpha), low, high in zip(rows, lows, highs, strict=True)
        )
        return Chain(links, name=self.name, joint_names=NAMES)
