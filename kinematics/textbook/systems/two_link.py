"""The five two-link manipulators of the notes: three direct solutions, the inverse, a workspace.

Source: McKerrow, chapter 4, sections 5 to 9; inverse solutions by section 11. `by_trigonometry`
writes the tip's coordinates down (section 5), `by_matrices` multiplies the A matrices as the notes
print them (sections 6 and 7), `by_vectors` adds the two link vectors after turning the second into
the base frame (section 9). All three run on numbers of any kind. The notes give neither lengths nor
ranges: the defaults are examples. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from kinematics.chains.chain import Chain
from kinematics.chains.links import DHLink, JointKind
from kinematics.frames.numbers import atan2, cos, sin, sqrt
from kinematics.frames.rotations import multiply, rot_x, rot_y, rot_z, rotate
from kinematics.frames.transforms import LAST_ROW, Transform, compose, position_of, translation
from kinematics.frames.vectors import Vector, add
from kinematics.textbook.systems.named import (
    ON_AXIS,
    QUARTER_TURN,
    REACH_MM,
    NamedBranch,
    NamedStep,
    Quantity,
    Solved,
    System,
)
from kinematics.textbook.systems.triangle import (
    ELBOWS,
    STRAIGHT_SINE,
    broken_bound,
    brought_within,
    sides,
    triangle,
)

Span = tuple[float, float]
"""Lowest and highest value of a prismatic joint, in mm."""


@dataclass(frozen=True, slots=True)
class Workspace:
    """Where a tip can be put: the shape, a sentence with its measures, and a test of goals."""

    shape: str
    sentence: str
    holds: Callable[[tuple[float, ...]], bool]


class TwoLink(System):
    """A manipulator of two links, its tip described in three ways."""

    __slots__ = ()

    @abstractmethod
    def by_trigonometry(self, first: float, second: float) -> Vector:
        """Return the tip (x, y, z) in mm from its coordinates written down."""

    @abstractmethod
    def a_matrices(self, first: float, second: float) -> tuple[Transform, Transform]:
        """Return the two A matrices as the notes print them."""

    @abstractmethod
    def by_vectors(self, first: float, second: float) -> Vector:
        """Return the tip as p01 + Rot1 p12, both vectors in the base frame."""

    @abstractmethod
    def orientation(self, first: float, second: float) -> Vector:
        """Return phi, theta, psi of RPY = Rot(z, phi) Rot(y, theta) Rot(x, psi) (section 8)."""

    @abstractmethod
    def workspace(self) -> Workspace:
        """Return where the tip can be put (the figures c), joint ranges included."""

    def by_matrices(self, first: float, second: float) -> Transform:
        """Return the hand's frame as the product of the A matrices."""
        return compose(*self.a_matrices(first, second))


def turned_link(theta: float, length: float) -> Transform:
    """Return the A matrix of a revolute joint whose link has a length and no twist."""
    c, s = cos(theta), sin(theta)
    return (c, -s, 0.0, length * c), (s, c, 0.0, length * s), (0.0, 0.0, 1.0, 0.0), LAST_ROW


def turned_column(theta: float, height: float) -> Transform:
    """Return the A matrix of a revolute joint with a distance and a twist of 90 degrees."""
    c, s = cos(theta), sin(theta)
    return (c, 0.0, s, 0.0), (s, 0.0, -c, 0.0), (0.0, 1.0, 0.0, height), LAST_ROW


def raised_column(height: float) -> Transform:
    """Return the A matrix of a prismatic joint with a twist of 90 degrees."""
    return (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, height), LAST_ROW


def within(value: float, span: Span) -> bool:
    """Return whether a length lies in a span, rounding allowed."""
    return span[0] - REACH_MM <= value <= span[1] + REACH_MM


# Types 4 and 5 (section 8): a lift that carries an arm or a slide.

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
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep("lift", "A1 = [1 0 0 0; 0 0 -1 0; 0 1 0 d1; 0 0 0 1]", "alpha1 = 90 degrees"),
        NamedStep("arm", "A2 = [C2 -S2 0 l2 C2; S2 C2 0 l2 S2; 0 0 1 0; 0 0 0 1]"),
        NamedStep("tip", "x = l2 C2,  y = 0,  z = d1 + l2 S2", "last column of A1 A2"),
        NamedStep("orientation", "phi = 0,  theta = -theta2,  psi = 90 degrees"),
        NamedStep("arm", "C2 = x / l2,  S2 = +- sqrt(1 - C2^2)", "two angles have the same cosine"),
        NamedStep("lift", "d1 = z - l2 S2", "the lift makes up for the arm's height"),
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
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep("lift", "A1 = [1 0 0 0; 0 0 -1 0; 0 1 0 d1; 0 0 0 1]", "alpha1 = 90 degrees"),
        NamedStep("slide", "A2 = Trans(0, 0, d2)", "along z1 = -y0"),
        NamedStep("tip", "x = 0,  y = -d2,  z = d1", "Trans(y, -d2) Trans(z, d1) Rot(x, 90)"),
        NamedStep("orientation", "phi = 0,  theta = 0,  psi = 90 degrees", "it never turns"),
        NamedStep("inverse", "d1 = z,  d2 = -y", "one solution"),
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


# Type 3 (section 7): a turning column that carries a slide.

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
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep(
            "column", "A1 = [C1 0 S1 0; S1 0 -C1 0; 0 1 0 d1; 0 0 0 1]", "alpha1 = 90 degrees"
        ),
        NamedStep("slide", "A2 = Trans(0, 0, d2)", "along z1, which lies in the horizontal plane"),
        NamedStep("tip", "x = d2 S1,  y = -d2 C1,  z = d1", "last column of A1 A2"),
        NamedStep("orientation", "phi = theta1,  theta = 0,  psi = 90 degrees"),
        NamedStep("slide", "d2 = +- sqrt(x^2 + y^2)", "S1^2 + C1^2 = 1"),
        NamedStep("base", "theta1 = atan2(x / d2, -y / d2)", "half a turn apart for the two signs"),
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


# Types 1 (sections 5, 7 and 8) and 2 (section 6): two revolute joints.

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
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep("first link", "p01 = (l1 C1, l1 S1)", "a link of length l1 at the angle theta1"),
        NamedStep("second link", "p12 = (l2 C12, l2 S12)", "in the base frame the angles add up"),
        NamedStep("tip", "x = l1 C1 + l2 C12,  y = l1 S1 + l2 S12", "p02 = p01 + p12"),
        NamedStep("orientation", "phi = theta1 + theta2", "RPY(phi, 0, 0) = Rot(z, phi)"),
        NamedStep(
            "elbow",
            "C2 = (x^2 + y^2 - l1^2 - l2^2) / (2 l1 l2),  S2 = -+ sqrt(1 - C2^2)",
            "cosine rule in the triangle of l1, l2 and the line to the tip: two solutions",
        ),
        NamedStep(
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
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep(
            "column", "A1 = [C1 0 S1 0; S1 0 -C1 0; 0 1 0 d1; 0 0 0 1]", "alpha1 = 90 degrees"
        ),
        NamedStep("arm", "A2 = [C2 -S2 0 l2 C2; S2 C2 0 l2 S2; 0 0 1 0; 0 0 0 1]"),
        NamedStep("tip", "x = l2 C1 C2,  y = l2 S1 C2,  z = d1 + l2 S2", "last column of A1 A2"),
        NamedStep("orientation", "phi = theta1,  theta = -theta2,  psi = 90 degrees"),
        NamedStep("constraint", "x^2 + y^2 + (z - d1)^2 = l2^2", "two joints reach a surface only"),
        NamedStep(
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
