"""The two-link manipulators of types 4 and 5: a lift that carries an arm or a slide.

Source: McKerrow, chapter 4, section 8; inverse solutions by section 11. Lengths in mm, angles in
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
from kinematics.rotations import rot_x, rot_y, rotate
from kinematics.systems.named_system import (
    REACH_MM,
    NamedBranch,
    Quantity,
    Solved,
    Step,
)
from kinematics.systems.triangle import STRAIGHT_SINE
from kinematics.systems.two_link import (
    Span,
    TwoLink,
    Workspace,
    raised_column,
    turned_link,
    within,
)
from kinematics.vectors import Vector, add

QUARTER_TURN = math.pi / 2.0
SIDES = MappingProxyType({"arm up": (1.0,), "arm down": (-1.0,)})
ONLY = MappingProxyType({"only solution": ()})


@dataclass(frozen=True, slots=True)
class TwoLinkType4(TwoLink):
    """A vertical prismatic joint that carries a horizontal revolute one: an arm on a lift."""

    l2_mm: float = 150.0
    d1_range_mm: Span = (0.0, 300.0)

    name: ClassVar[str] = "two-link-4"
    title: ClassVar[str] = "Type 4 two-link manipulator (prismatic and intersecting revolute joint)"
    source: ClassVar[str] = "McKerrow, chapter 4, section 8"
    coordinates: ClassVar[tuple[str, ...]] = ("x_mm", "z_mm")
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = SIDES
    derivation: ClassVar[tuple[Step, ...]] = (
        Step("lift", "A1 = [1 0 0 0; 0 0 -1 0; 0 1 0 d1; 0 0 0 1]", "alpha1 = 90 degrees"),
        Step("arm", "A2 = [C2 -S2 0 l2 C2; S2 C2 0 l2 S2; 0 0 1 0; 0 0 0 1]"),
        Step("tip", "x = l2 C2,  y = 0,  z = d1 + l2 S2", "last column of A1 A2"),
        Step("orientation", "phi = 0,  theta = -theta2,  psi = 90 degrees"),
        Step("arm", "C2 = x / l2,  S2 = +- sqrt(1 - C2^2)", "two angles have the same cosine"),
        Step("lift", "d1 = z - l2 S2", "the lift makes up for the arm's height"),
    )
    drawing: ClassVar[str] = r"""
      z
      |      .o tip
      |  l2.-'
      | .-' ) theta2
     [=]-------- x
      |
      | d1
      |
    """

    def chain(self) -> Chain:
        """Return the link table: d1, a twist of 90 degrees, and theta2, l2."""
        low, high = self.d1_range_mm
        links = (
            DHLink(alpha_rad=QUARTER_TURN, kind=JointKind.PRISMATIC, low=low, high=high),
            DHLink(a_mm=self.l2_mm),
        )
        return Chain(links, name=self.name, joint_names=("d1", "theta2"))

    def lengths(self) -> dict[str, float]:
        """Return l2 in mm."""
        return {"l2": self.l2_mm}

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        c2, s2 = cos(joints[1]), sin(joints[1])
        x, y, z = self.by_trigonometry(*joints)
        return (c2, -s2, 0.0, x), (0.0, 0.0, -1.0, y), (s2, c2, 0.0, z), LAST_ROW

    def by_trigonometry(self, first: float, second: float) -> Vector:
        """Return the tip: x = l2 C2, y = 0, z = d1 + l2 S2."""
        return self.l2_mm * cos(second), 0.0, first + self.l2_mm * sin(second)

    def a_matrices(self, first: float, second: float) -> tuple[Transform, Transform]:
        """Return A1 and A2 (section 8)."""
        return raised_column(first), turned_link(second, self.l2_mm)

    def by_vectors(self, first: float, second: float) -> Vector:
        """Return p01, the lift, plus Rot(y, -theta2) times the arm."""
        return add((0.0, 0.0, first), rotate(rot_y(-second), (self.l2_mm, 0.0, 0.0)))

    def orientation(self, _first: float, second: float) -> Vector:
        """Return phi = 0, theta = -theta2, psi = 90 degrees."""
        return 0.0, -second, QUARTER_TURN

    def goal_of(self, frame: Transform) -> tuple[float, ...]:
        """Return the tip's x and z in mm; y is always 0."""
        x, _, z = position_of(frame)
        return x, z

    def workspace(self) -> Workspace:
        """Return the strip that the tip covers (figure c), round at its ends."""
        low, high = self.d1_range_mm
        return Workspace(
            "strip",
            f"the plane y = 0: circles of {self.l2_mm:g} mm around (0, {low:g}) to (0, {high:g})",
            self._holds,
        )

    def _holds(self, goal: tuple[float, ...]) -> bool:
        x, z = goal
        if abs(x) > self.l2_mm + REACH_MM:
            return False
        height = math.sqrt(max(self.l2_mm * self.l2_mm - x * x, 0.0))
        return any(within(z - rise, self.d1_range_mm) for rise in (height, -height))

    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        x, z = goal
        (side,) = signs
        rise = side * sqrt(self._left(x))
        second = atan2(rise, x)
        return (z - rise, second), (Quantity("l2 C2", x, "mm"), Quantity("l2 S2", rise, "mm"))

    def _left(self, x: float) -> float:
        """Return (l2 S2)^2, held at 0 where rounding takes a float below."""
        left = self.l2_mm * self.l2_mm - x * x
        return max(left, 0.0) if isinstance(left, float) else left

    def _ik(self, goal: tuple[float, ...], _seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        x, z = goal
        if abs(x) > self.l2_mm + REACH_MM:
            nearest = (math.copysign(self.l2_mm, x), z)
            raise self._out_of_reach(
                "the tip's distance from the lift", abs(x), self.l2_mm, nearest
            )
        if self._left(x) > (STRAIGHT_SINE * self.l2_mm) ** 2:
            return [self.solution(goal, branch) for branch in self.signs]
        words = "the arm is level: both postures are one, and the tip cannot move outwards"
        return [NamedBranch("arm level", *self._solution(goal, 1.0), degenerate=words)]


@dataclass(frozen=True, slots=True)
class TwoLinkType5(TwoLink):
    """Two perpendicular prismatic joints: a plotter on its edge."""

    d1_range_mm: Span = (0.0, 300.0)
    d2_range_mm: Span = (0.0, 300.0)

    name: ClassVar[str] = "two-link-5"
    title: ClassVar[str] = "Type 5 two-link manipulator (perpendicular prismatic joints)"
    source: ClassVar[str] = "McKerrow, chapter 4, section 8"
    coordinates: ClassVar[tuple[str, ...]] = ("y_mm", "z_mm")
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = ONLY
    derivation: ClassVar[tuple[Step, ...]] = (
        Step("lift", "A1 = [1 0 0 0; 0 0 -1 0; 0 1 0 d1; 0 0 0 1]", "alpha1 = 90 degrees"),
        Step("slide", "A2 = Trans(0, 0, d2)", "along z1 = -y0"),
        Step("tip", "x = 0,  y = -d2,  z = d1", "Trans(y, -d2) Trans(z, d1) Rot(x, 90)"),
        Step("orientation", "phi = 0,  theta = 0,  psi = 90 degrees", "it never turns"),
        Step("inverse", "d1 = z,  d2 = -y", "one solution"),
    )
    drawing: ClassVar[str] = r"""
      z
      |      d2
     [=]==========--o tip      <- y
      |
      | d1
      |
    """

    def chain(self) -> Chain:
        """Return the link table: d1 with a twist of 90 degrees, and d2."""
        (low1, high1), (low2, high2) = self.d1_range_mm, self.d2_range_mm
        slides = JointKind.PRISMATIC
        links = (
            DHLink(alpha_rad=QUARTER_TURN, kind=slides, low=low1, high=high1),
            DHLink(kind=slides, low=low2, high=high2),
        )
        return Chain(links, name=self.name, joint_names=("d1", "d2"))

    def lengths(self) -> dict[str, float]:
        """Return no length: both distances vary."""
        return {}

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        x, y, z = self.by_trigonometry(*joints)
        return (1.0, 0.0, 0.0, x), (0.0, 0.0, -1.0, y), (0.0, 1.0, 0.0, z), LAST_ROW

    def by_trigonometry(self, first: float, second: float) -> Vector:
        """Return the tip: x = 0, y = -d2, z = d1."""
        return 0.0, -second, first

    def a_matrices(self, first: float, second: float) -> tuple[Transform, Transform]:
        """Return A1 and A2 (section 8)."""
        return raised_column(first), translation(0.0, 0.0, second)

    def by_vectors(self, first: float, second: float) -> Vector:
        """Return p01, the lift, plus Rot(x, 90) times the slide."""
        return add((0.0, 0.0, first), rotate(rot_x(QUARTER_TURN), (0.0, 0.0, second)))

    def orientation(self, _first: float, _second: float) -> Vector:
        """Return psi = 90 degrees and no other turn."""
        return 0.0, 0.0, QUARTER_TURN

    def goal_of(self, frame: Transform) -> tuple[float, ...]:
        """Return the tip's y and z in mm; x is always 0."""
        return position_of(frame)[1:]

    def workspace(self) -> Workspace:
        """Return the rectangle that the tip covers (figure c)."""
        (low1, high1), (low2, high2) = self.d1_range_mm, self.d2_range_mm
        return Workspace(
            "rectangle",
            f"the plane x = 0: y from {-high2:g} to {-low2:g} mm, z from {low1:g} to {high1:g} mm",
            lambda goal: within(-goal[0], (low2, high2)) and within(goal[1], (low1, high1)),
        )

    def _solution(self, goal: tuple[float, ...], *_signs: float) -> Solved:
        y, z = goal
        return (z, -y), ()

    def _ik(self, goal: tuple[float, ...], _seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        return [self.solution(goal, "only solution")]
