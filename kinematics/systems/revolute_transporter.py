"""The general revolute transporter: three revolute joints, up to four solutions.

Source: "Vectors and frames", chapter 2, section 2.5.2, figure 2.17 and equation 2.35. The links
stand upright in the zero position, and frames start parallel to the base frame. Lengths in mm,
angles in rad; the default lengths are examples, since the source gives none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar

from kinematics.chains import Chain
from kinematics.frames import LAST_ROW, Transform
from kinematics.links import DHLink
from kinematics.numbers import atan2, cos, sin, sqrt
from kinematics.systems.named_system import ON_AXIS, REACH_MM, NamedBranch, Quantity, Solved, Step
from kinematics.systems.transporters import QUARTER_TURN, UPRIGHT, Transporter
from kinematics.systems.triangle import broken_bound, brought_within, sides, triangle

POSTURES = MappingProxyType(
    {
        "base front, elbow up": (1.0, 1.0),
        "base front, elbow down": (1.0, -1.0),
        "base back, elbow up": (-1.0, -1.0),
        "base back, elbow down": (-1.0, 1.0),
    }
)


@dataclass(frozen=True, slots=True)
class RevoluteTransporter(Transporter):
    """A turning column L1, an upper arm L2 and a forearm L3."""

    l1_mm: float = 200.0
    l2_mm: float = 180.0
    l3_mm: float = 140.0

    name: ClassVar[str] = "revolute"
    title: ClassVar[str] = "General revolute transporter (three revolute joints)"
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = POSTURES
    derivation: ClassVar[tuple[Step, ...]] = (
        Step("arm's own plane", "h = S2 L2 + S23 L3", "how far the arm leans away from the axis"),
        Step("end point", "X = S1 h,  Y = -C1 h,  Z = L1 + C2 L2 + C23 L3", "equation 2.35"),
        Step("base", "h = +- sqrt(X^2 + Y^2),  theta1 = atan2(X / h, -Y / h)", "two solutions"),
        Step(
            "elbow",
            "C3 = (h^2 + (Z - L1)^2 - L2^2 - L3^2) / (2 L2 L3),  S3 = +- sqrt(1 - C3^2)",
            "cosine rule in the arm's plane: two solutions for each",
        ),
        Step("shoulder", "theta2 = atan2(h, Z - L1) - atan2(L3 S3, L2 + L3 C3)", "from upright"),
    )
    drawing: ClassVar[str] = r"""
      z      theta3
      |   .o-.  L3
      |L2/    `-.
      | /        `o end point
      o' theta2
      | L1
     _|_
    (___) theta1
    """

    def chain(self) -> Chain:
        """Return the link table: 90 degrees of offset bring the zero position upright."""
        links = (
            DHLink(d_mm=self.l1_mm, alpha_rad=QUARTER_TURN, offset=QUARTER_TURN),
            DHLink(a_mm=self.l2_mm, offset=QUARTER_TURN),
            DHLink(a_mm=self.l3_mm),
        )
        names = ("theta1", "theta2", "theta3")
        return Chain(links, tool=UPRIGHT, name=self.name, joint_names=names)

    def lengths(self) -> dict[str, float]:
        """Return L1, L2 and L3 in mm."""
        return {"L1": self.l1_mm, "L2": self.l2_mm, "L3": self.l3_mm}

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        first, second, third = joints
        both = second + third
        c1, s1, c23, s23 = cos(first), sin(first), cos(both), sin(both)
        lean = sin(second) * self.l2_mm + s23 * self.l3_mm
        up = self.l1_mm + cos(second) * self.l2_mm + c23 * self.l3_mm
        return (
            (c1, -(s1 * c23), s1 * s23, s1 * lean),
            (s1, c1 * c23, -(c1 * s23), -(c1 * lean)),
            (0.0, s23, c23, up),
            LAST_ROW,
        )

    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        (x, y, z), (side, bend) = goal, signs
        lean = side * sqrt(x * x + y * y)
        solved = triangle(z - self.l1_mm, lean, self.l2_mm, self.l3_mm, bend)
        joints = (atan2(side * x, -(side * y)), solved.first, solved.second)
        return joints, (Quantity("h", lean, "mm"), *solved.workings())

    def _ik(self, goal: tuple[float, ...], seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        out, up = math.hypot(goal[0], goal[1]), goal[2] - self.l1_mm
        distance = math.hypot(out, up)
        bound = broken_bound(distance, self.l2_mm, self.l3_mm)
        if bound is not None:
            raise self._out_of_reach(
                "the end point's distance from the shoulder", distance, bound, self._nearest(goal)
            )
        on_axis = out <= REACH_MM
        found = []
        for base, side in (("base front", 1.0), ("base back", -1.0)):
            if on_axis and side < 0.0:
                continue
            for branch in self._elbows(goal, side, distance, seed):
                named = replace(branch, name=f"{base}, {branch.name}")
                found.append(_with_free_base(named, seed[0]) if on_axis else named)
        return found

    def _elbows(
        self, goal: tuple[float, ...], side: float, distance: float, seed: tuple[float, ...]
    ) -> list[NamedBranch]:
        up, down = ("elbow up", "elbow down") if side > 0.0 else ("elbow down", "elbow up")
        found = []
        for bend in sides(distance, self.l2_mm, self.l3_mm, up, down):
            (first, second, third), workings = self._solution(goal, side, bend.sign)
            second = seed[1] if bend.first_free else second
            free = ("theta2",) if bend.first_free else ()
            joints = (first, second, third)
            found.append(NamedBranch(bend.name, joints, workings, free, bend.degenerate))
        return found

    def _nearest(self, goal: tuple[float, ...]) -> tuple[float, ...]:
        """Return the nearest end point that can be met, in the same vertical plane."""
        x, y, z = goal
        out = math.hypot(x, y)
        near_out, near_up = brought_within(out, z - self.l1_mm, self.l2_mm, self.l3_mm)
        if out <= REACH_MM:
            return 0.0, -near_out, near_up + self.l1_mm
        return x * near_out / out, y * near_out / out, near_up + self.l1_mm


def _with_free_base(branch: NamedBranch, base: float) -> NamedBranch:
    words = f"{ON_AXIS}; {branch.degenerate}" if branch.degenerate else ON_AXIS
    return replace(
        branch,
        name=branch.name.replace("base front", "base free"),
        joints=(base, *branch.joints[1:]),
        free=("theta1", *branch.free),
        degenerate=words,
    )
