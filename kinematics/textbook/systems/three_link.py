"""The planar three-link arm, in Craig's convention.

Source: Craig, chapter 3 (frames attached at the near end of each link) and chapter 4 (its
inverse); goal: the tip and the direction of the last link. Lengths in mm, angles in rad. The
source gives no lengths: the defaults are examples.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink
from kinematics.frames.numbers import atan2, cos, sin
from kinematics.frames.transforms import LAST_ROW, Transform, position_of, translation
from kinematics.textbook.systems.named import NamedBranch, NamedStep, Solved, System
from kinematics.textbook.systems.triangle import (
    ELBOWS,
    broken_bound,
    brought_within,
    sides,
    triangle,
)


@dataclass(frozen=True, slots=True)
class ThreeLink(System):
    """Three parallel revolute joints; frame 3 stands at the third joint, the tip l3 further."""

    l1_mm: float = 200.0
    l2_mm: float = 150.0
    l3_mm: float = 80.0

    name: ClassVar[str] = "three-link"
    title: ClassVar[str] = "Planar three-link arm (parallel revolute joints)"
    source: ClassVar[str] = "Craig, chapters 3 and 4"
    coordinates: ClassVar[tuple[str, ...]] = ("x_mm", "y_mm", "phi_rad")
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = ELBOWS
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep("direction", "phi = theta1 + theta2 + theta3", "parallel axes add up"),
        NamedStep(
            "tip",
            "x = l1 C1 + l2 C12 + l3 C123,  y = l1 S1 + l2 S12 + l3 S123",
            "frame 3 stands at the third joint, the tip is l3 along its x axis",
        ),
        NamedStep(
            "third joint", "xw = x - l3 cos(phi),  yw = y - l3 sin(phi)", "the last link is given"
        ),
        NamedStep(
            "second angle",
            "C2 = (xw^2 + yw^2 - l1^2 - l2^2) / (2 l1 l2),  S2 = -+ sqrt(1 - C2^2)",
            "cosine rule: two solutions",
        ),
        NamedStep("first angle", "theta1 = atan2(yw, xw) - atan2(l2 S2, l1 + l2 C2)"),
        NamedStep("third angle", "theta3 = phi - theta1 - theta2"),
    )
    drawing: ClassVar[str] = r"""
      y              l3
      |        o---------> tip, phi
      |      ./ theta3
      |    ./ l2
      | l1_o theta2
      |_-'
      o_)_theta1____________ x
    """

    def chain(self) -> Chain:
        """Return the link table in Craig's convention, the last link's length as the tool."""
        links = (DHLink(), DHLink(a_mm=self.l1_mm), DHLink(a_mm=self.l2_mm))
        return Chain(
            links,
            Convention.CRAIG,
            tool=translation(self.l3_mm, 0.0, 0.0),
            name=self.name,
            joint_names=("theta1", "theta2", "theta3"),
        )

    def lengths(self) -> dict[str, float]:
        """Return l1, l2 and l3 in mm."""
        return {"l1": self.l1_mm, "l2": self.l2_mm, "l3": self.l3_mm}

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        first, second, third = joints
        both = first + second
        phi = both + third
        c, s = cos(phi), sin(phi)
        x = self.l1_mm * cos(first) + self.l2_mm * cos(both) + self.l3_mm * c
        y = self.l1_mm * sin(first) + self.l2_mm * sin(both) + self.l3_mm * s
        return (c, -s, 0.0, x), (s, c, 0.0, y), (0.0, 0.0, 1.0, 0.0), LAST_ROW

    def goal_of(self, frame: Transform) -> tuple[float, ...]:
        """Return the tip's x and y in mm and the direction of the frame's x axis in rad."""
        x, y, _ = position_of(frame)
        return x, y, atan2(frame[1][0], frame[0][0])

    def _third_joint(self, goal: tuple[float, ...]) -> tuple[float, float]:
        x, y, phi = goal
        return x - self.l3_mm * cos(phi), y - self.l3_mm * sin(phi)

    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        (x, y), (side,) = self._third_joint(goal), signs
        solved = triangle(x, y, self.l1_mm, self.l2_mm, side)
        third = goal[2] - solved.first - solved.second
        return (solved.first, solved.second, third), solved.workings()

    def _ik(self, goal: tuple[float, ...], seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        x, y = self._third_joint(goal)
        distance = math.hypot(x, y)
        bound = broken_bound(distance, self.l1_mm, self.l2_mm)
        if bound is not None:
            raise self._out_of_reach(
                "the third joint's distance from the base", distance, bound, self._nearest(goal)
            )
        found = []
        for side in sides(distance, self.l1_mm, self.l2_mm, "elbow down", "elbow up"):
            (first, second, third), workings = self._solution(goal, side.sign)
            if side.first_free:
                first, third = seed[0], third + first - seed[0]
            free = ("theta1",) if side.first_free else ()
            joints = (first, second, third)
            found.append(NamedBranch(side.name, joints, workings, free, side.degenerate))
        return found

    def _nearest(self, goal: tuple[float, ...]) -> tuple[float, ...]:
        """Return the nearest goal in the same direction that can be met."""
        x, y = self._third_joint(goal)
        in_x, in_y = brought_within(x, y, self.l1_mm, self.l2_mm)
        return goal[0] + in_x - x, goal[1] + in_y - y, goal[2]
