"""The two-link manipulators of types 1 and 2: two revolute joints.

Source: McKerrow, chapter 4: type 1 sections 5, 7 and 8, type 2 section 6; inverse solutions by
section 11. Lengths in mm, angles in rad. The notes give no lengths: the defaults are examples.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from kinematics.chains import Chain
from kinematics.frames import LAST_ROW, Transform, position_of
from kinematics.links import DHLink
from kinematics.numbers import atan2, cos, sin, sqrt
from kinematics.rotations import multiply, rot_x, rot_z, rotate
from kinematics.systems.named_system import ON_AXIS, REACH_MM, NamedBranch, Quantity, Solved, Step
from kinematics.systems.triangle import ELBOWS, broken_bound, brought_within, sides, triangle
from kinematics.systems.two_link import TwoLink, Workspace, turned_column, turned_link
from kinematics.vectors import Vector, add

QUARTER_TURN = math.pi / 2.0
BASES = MappingProxyType({"base front": (1.0,), "base back": (-1.0,)})


@dataclass(frozen=True, slots=True)
class TwoLinkType1(TwoLink):
    """Two parallel revolute joints: the arm of a plane, or a SCARA seen from above."""

    l1_mm: float = 200.0
    l2_mm: float = 150.0

    name: ClassVar[str] = "two-link-1"
    title: ClassVar[str] = "Type 1 two-link manipulator (parallel revolute joints)"
    source: ClassVar[str] = "McKerrow, chapter 4, sections 5, 7, 8, 11 and 12"
    coordinates: ClassVar[tuple[str, ...]] = ("x_mm", "y_mm")
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = ELBOWS
    derivation: ClassVar[tuple[Step, ...]] = (
        Step("first link", "p01 = (l1 C1, l1 S1)", "a link of length l1 at the angle theta1"),
        Step("second link", "p12 = (l2 C12, l2 S12)", "in the base frame the angles add up"),
        Step("tip", "x = l1 C1 + l2 C12,  y = l1 S1 + l2 S12", "p02 = p01 + p12"),
        Step("orientation", "phi = theta1 + theta2", "RPY(phi, 0, 0) = Rot(z, phi)"),
        Step(
            "elbow",
            "C2 = (x^2 + y^2 - l1^2 - l2^2) / (2 l1 l2),  S2 = -+ sqrt(1 - C2^2)",
            "cosine rule in the triangle of l1, l2 and the line to the tip: two solutions",
        ),
        Step(
            "shoulder",
            "theta1 = atan2(y, x) - atan2(l2 S2, l1 + l2 C2)",
            "direction of the tip less the angle between that line and the first link",
        ),
    )
    drawing: ClassVar[str] = r"""
      y
      |            o tip
      |          ./
      |        ./ l2
      |  l1  _o ) theta2
      |  _--'
      (o'_)_theta1__ x
    """

    def chain(self) -> Chain:
        """Return the link table: theta1, l1 and theta2, l2, no twists and no distances."""
        links = (DHLink(a_mm=self.l1_mm), DHLink(a_mm=self.l2_mm))
        return Chain(links, name=self.name, joint_names=("theta1", "theta2"))

    def lengths(self) -> dict[str, float]:
        """Return l1 and l2 in mm."""
        return {"l1": self.l1_mm, "l2": self.l2_mm}

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        x, y, z = self.by_trigonometry(*joints)
        c12, s12 = cos(joints[0] + joints[1]), sin(joints[0] + joints[1])
        return (c12, -s12, 0.0, x), (s12, c12, 0.0, y), (0.0, 0.0, 1.0, z), LAST_ROW

    def by_trigonometry(self, first: float, second: float) -> Vector:
        """Return the tip: x = l1 C1 + l2 C12, y = l1 S1 + l2 S12 (section 5)."""
        both = first + second
        return (
            self.l1_mm * cos(first) + self.l2_mm * cos(both),
            self.l1_mm * sin(first) + self.l2_mm * sin(both),
            0.0,
        )

    def a_matrices(self, first: float, second: float) -> tuple[Transform, Transform]:
        """Return A1 and A2 (section 7)."""
        return turned_link(first, self.l1_mm), turned_link(second, self.l2_mm)

    def by_vectors(self, first: float, second: float) -> Vector:
        """Return p01 + Rot1 Rot2 p22, each link a vector along its own x axis (section 9)."""
        turned = rot_z(first)
        p01 = rotate(turned, (self.l1_mm, 0.0, 0.0))
        p12 = rotate(multiply(turned, rot_z(second)), (self.l2_mm, 0.0, 0.0))
        return add(p01, p12)

    def orientation(self, first: float, second: float) -> Vector:
        """Return phi = theta1 + theta2 and no other turn."""
        return first + second, 0.0, 0.0

    def goal_of(self, frame: Transform) -> tuple[float, ...]:
        """Return the tip's x and y in mm."""
        return position_of(frame)[:2]

    def workspace(self) -> Workspace:
        """Return the ring that the tip covers (figure c)."""
        longest, shortest = self.l1_mm + self.l2_mm, abs(self.l1_mm - self.l2_mm)
        return Workspace(
            "ring",
            f"the plane z = 0 from {shortest:g} mm to {longest:g} mm from the first joint",
            lambda goal: broken_bound(math.hypot(*goal), self.l1_mm, self.l2_mm) is None,
        )

    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        (x, y), (side,) = goal, signs
        solved = triangle(x, y, self.l1_mm, self.l2_mm, side)
        return (solved.first, solved.second), solved.workings()

    def _ik(self, goal: tuple[float, ...], seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        x, y = goal
        distance = math.hypot(x, y)
        bound = broken_bound(distance, self.l1_mm, self.l2_mm)
        if bound is not None:
            instead = brought_within(x, y, self.l1_mm, self.l2_mm)
            raise self._out_of_reach("the tip's distance from the base", distance, bound, instead)
        found = []
        for side in sides(distance, self.l1_mm, self.l2_mm, "elbow down", "elbow up"):
            (first, second), workings = self._solution(goal, side.sign)
            first = seed[0] if side.first_free else first
            free = ("theta1",) if side.first_free else ()
            found.append(NamedBranch(side.name, (first, second), workings, free, side.degenerate))
        return found


@dataclass(frozen=True, slots=True)
class TwoLinkType2(TwoLink):
    """A vertical revolute joint and a horizontal one: a gun turret, the tip on a sphere."""

    d1_mm: float = 200.0
    l2_mm: float = 150.0

    name: ClassVar[str] = "two-link-2"
    title: ClassVar[str] = "Type 2 two-link manipulator (perpendicular revolute joints)"
    source: ClassVar[str] = "McKerrow, chapter 4, section 6"
    coordinates: ClassVar[tuple[str, ...]] = ("x_mm", "y_mm", "z_mm")
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = BASES
    derivation: ClassVar[tuple[Step, ...]] = (
        Step("column", "A1 = [C1 0 S1 0; S1 0 -C1 0; 0 1 0 d1; 0 0 0 1]", "alpha1 = 90 degrees"),
        Step("arm", "A2 = [C2 -S2 0 l2 C2; S2 C2 0 l2 S2; 0 0 1 0; 0 0 0 1]"),
        Step("tip", "x = l2 C1 C2,  y = l2 S1 C2,  z = d1 + l2 S2", "last column of A1 A2"),
        Step("orientation", "phi = theta1,  theta = -theta2,  psi = 90 degrees"),
        Step("constraint", "x^2 + y^2 + (z - d1)^2 = l2^2", "two joints reach a surface only"),
        Step(
            "inverse",
            "theta1 = atan2(y, x),  theta2 = atan2(z - d1, sqrt(x^2 + y^2))",
            "or over the top: theta1 + 180 degrees, 180 degrees - theta2",
        ),
    )
    drawing: ClassVar[str] = r"""
      z
      |        .o tip
      |   l2 .-'
      |   .-' ) theta2
      o--'------
      |
      | d1
     _|_
    (___) theta1      x ->
    """

    def chain(self) -> Chain:
        """Return the link table: theta1, d1, a twist of 90 degrees, and theta2, l2."""
        links = (DHLink(d_mm=self.d1_mm, alpha_rad=QUARTER_TURN), DHLink(a_mm=self.l2_mm))
        return Chain(links, name=self.name, joint_names=("theta1", "theta2"))

    def lengths(self) -> dict[str, float]:
        """Return d1 and l2 in mm."""
        return {"d1": self.d1_mm, "l2": self.l2_mm}

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        c1, s1, c2, s2 = cos(joints[0]), sin(joints[0]), cos(joints[1]), sin(joints[1])
        x, y, z = self.by_trigonometry(*joints)
        return (
            (c1 * c2, -c1 * s2, s1, x),
            (s1 * c2, -s1 * s2, -c1, y),
            (s2, c2, 0.0, z),
            LAST_ROW,
        )

    def by_trigonometry(self, first: float, second: float) -> Vector:
        """Return the tip: x = l2 C1 C2, y = l2 S1 C2, z = d1 + l2 S2."""
        out = self.l2_mm * cos(second)
        return out * cos(first), out * sin(first), self.d1_mm + self.l2_mm * sin(second)

    def a_matrices(self, first: float, second: float) -> tuple[Transform, Transform]:
        """Return A1 and A2 (the example of section 6)."""
        return turned_column(first, self.d1_mm), turned_link(second, self.l2_mm)

    def by_vectors(self, first: float, second: float) -> Vector:
        """Return p01, the column, plus Rot(z, theta1) Rot(x, 90) Rot(z, theta2) times the arm."""
        turned = multiply(rot_z(first), rot_x(QUARTER_TURN), rot_z(second))
        return add((0.0, 0.0, self.d1_mm), rotate(turned, (self.l2_mm, 0.0, 0.0)))

    def orientation(self, first: float, second: float) -> Vector:
        """Return phi = theta1, theta = -theta2, psi = 90 degrees."""
        return first, -second, QUARTER_TURN

    def goal_of(self, frame: Transform) -> tuple[float, ...]:
        """Return the tip's x, y and z in mm."""
        return position_of(frame)

    def workspace(self) -> Workspace:
        """Return the sphere that the tip covers (figure c)."""
        return Workspace(
            "sphere",
            f"the surface of the sphere of {self.l2_mm:g} mm around (0, 0, {self.d1_mm:g})",
            lambda goal: abs(self._span(goal) - self.l2_mm) <= REACH_MM,
        )

    def _span(self, goal: tuple[float, ...]) -> float:
        return math.hypot(goal[0], goal[1], goal[2] - self.d1_mm)

    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        x, y, z = goal
        (side,) = signs
        out, up = side * sqrt(x * x + y * y), z - self.d1_mm
        workings = (Quantity("C2 l2", out, "mm"), Quantity("S2 l2", up, "mm"))
        return (atan2(side * y, side * x), atan2(up, out)), workings

    def _ik(self, goal: tuple[float, ...], seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        span = self._span(goal)
        if abs(span - self.l2_mm) > REACH_MM:
            raise self._out_of_reach(
                "the tip's distance from the shoulder", span, self.l2_mm, self._onto(goal, span)
            )
        if math.hypot(goal[0], goal[1]) > REACH_MM:
            return [self.solution(goal, branch) for branch in self.signs]
        (_, second), workings = self._solution(goal, 1.0)
        return [NamedBranch("base free", (seed[0], second), workings, ("theta1",), ON_AXIS)]

    def _onto(self, goal: tuple[float, ...], span: float) -> Vector:
        """Return the point of the sphere nearest to a goal; of its centre, the zero position."""
        if span <= REACH_MM:
            return self.l2_mm, 0.0, self.d1_mm
        scale = self.l2_mm / span
        return goal[0] * scale, goal[1] * scale, self.d1_mm + (goal[2] - self.d1_mm) * scale
