"""The two-link manipulator of type 3: a turning column that carries a slide.

Source: McKerrow, chapter 4, section 7; inverse solution by section 11. Lengths in mm, angles in
rad. The notes give neither lengths nor ranges: the defaults are examples.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from kinematics.chains import Chain
from kinematics.frames import LAST_ROW, Transform, position_of, translation
from kinematics.links import DHLink, JointKind
from kinematics.numbers import atan2, cos, sin, sqrt
from kinematics.rotations import rot_x, rot_z, rotate
from kinematics.systems.named_system import (
    ON_AXIS,
    REACH_MM,
    NamedBranch,
    Quantity,
    Solved,
    Step,
)
from kinematics.systems.two_link import (
    Span,
    TwoLink,
    Workspace,
    turned_column,
    within,
)
from kinematics.vectors import Vector, add

QUARTER_TURN = math.pi / 2.0
STRETCHES = MappingProxyType({"reaching forward": (1.0,), "reaching backward": (-1.0,)})


@dataclass(frozen=True, slots=True)
class TwoLinkType3(TwoLink):
    """A vertical revolute joint that carries a horizontal prismatic one: polar coordinates."""

    d1_mm: float = 200.0
    d2_range_mm: Span = (0.0, 300.0)

    name: ClassVar[str] = "two-link-3"
    title: ClassVar[str] = "Type 3 two-link manipulator (revolute and intersecting prismatic joint)"
    source: ClassVar[str] = "McKerrow, chapter 4, section 7"
    coordinates: ClassVar[tuple[str, ...]] = ("x_mm", "y_mm")
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = STRETCHES
    derivation: ClassVar[tuple[Step, ...]] = (
        Step("column", "A1 = [C1 0 S1 0; S1 0 -C1 0; 0 1 0 d1; 0 0 0 1]", "alpha1 = 90 degrees"),
        Step("slide", "A2 = Trans(0, 0, d2)", "along z1, which lies in the horizontal plane"),
        Step("tip", "x = d2 S1,  y = -d2 C1,  z = d1", "last column of A1 A2"),
        Step("orientation", "phi = theta1,  theta = 0,  psi = 90 degrees"),
        Step("slide", "d2 = +- sqrt(x^2 + y^2)", "S1^2 + C1^2 = 1"),
        Step("base", "theta1 = atan2(x / d2, -y / d2)", "half a turn apart for the two signs"),
    )
    drawing: ClassVar[str] = r"""
      z
      |
      |       d2
      [=]========---o tip
      |
      | d1
     _|_
    (___) theta1
    """

    def chain(self) -> Chain:
        """Return the link table: theta1, d1, a twist of 90 degrees, and d2."""
        low, high = self.d2_range_mm
        links = (
            DHLink(d_mm=self.d1_mm, alpha_rad=QUARTER_TURN),
            DHLink(kind=JointKind.PRISMATIC, low=low, high=high),
        )
        return Chain(links, name=self.name, joint_names=("theta1", "d2"))

    def lengths(self) -> dict[str, float]:
        """Return d1 in mm."""
        return {"d1": self.d1_mm}

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        c1, s1 = cos(joints[0]), sin(joints[0])
        x, y, z = self.by_trigonometry(*joints)
        return (c1, 0.0, s1, x), (s1, 0.0, -c1, y), (0.0, 1.0, 0.0, z), LAST_ROW

    def by_trigonometry(self, first: float, second: float) -> Vector:
        """Return the tip: x = d2 S1, y = -d2 C1, z = d1."""
        return second * sin(first), -(second * cos(first)), self.d1_mm

    def a_matrices(self, first: float, second: float) -> tuple[Transform, Transform]:
        """Return A1 and A2 (section 7)."""
        return turned_column(first, self.d1_mm), translation(0.0, 0.0, second)

    def by_vectors(self, first: float, second: float) -> Vector:
        """Return p01, the column, plus Rot(z, theta1) Rot(x, 90) times the slide."""
        slide = rotate(rot_x(QUARTER_TURN), (0.0, 0.0, second))
        return add((0.0, 0.0, self.d1_mm), rotate(rot_z(first), slide))

    def orientation(self, first: float, _second: float) -> Vector:
        """Return phi = theta1, theta = 0, psi = 90 degrees."""
        return first, 0.0, QUARTER_TURN

    def goal_of(self, frame: Transform) -> tuple[float, ...]:
        """Return the tip's x and y in mm; z is always d1."""
        return position_of(frame)[:2]

    def workspace(self) -> Workspace:
        """Return the disc or ring that the tip covers (figure c)."""
        low, high = self.d2_range_mm
        nearest = 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))
        furthest = max(abs(low), abs(high))
        return Workspace(
            "disc" if nearest == 0.0 else "ring",
            f"the plane z = {self.d1_mm:g} mm from {nearest:g} mm to {furthest:g} mm from the axis",
            lambda goal: within(math.hypot(*goal), (nearest, furthest)),
        )

    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        x, y = goal
        (side,) = signs
        slide = side * sqrt(x * x + y * y)
        return (atan2(side * x, -(side * y)), slide), (Quantity("d2", slide, "mm"),)

    def _ik(self, goal: tuple[float, ...], seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        if math.hypot(*goal) > REACH_MM:
            return [self.solution(goal, branch) for branch in self.signs]
        return [NamedBranch("base free", (seed[0], 0.0), (), ("theta1",), ON_AXIS)]
