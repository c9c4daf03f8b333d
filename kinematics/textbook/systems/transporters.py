"""The four transporters: cartesian, cylindrical, spherical and general revolute, all solutions.

Source: "Vectors and frames", chapter 2, section 2.5.2, equations 2.28 to 2.35. The notes' frames
start parallel to the base frame, so each hand's frame here is the base frame in the zero position.
Lengths in mm, angles in rad; ranges and lengths are examples, since the source gives none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar

from kinematics.chains.chain import Chain
from kinematics.chains.links import DHLink, JointKind
from kinematics.frames.numbers import atan2, cos, sin, sqrt
from kinematics.frames.transforms import LAST_ROW, Transform, position_of, transform
from kinematics.frames.vectors import ZERO
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
from kinematics.textbook.systems.triangle import broken_bound, brought_within, sides, triangle

Span = tuple[float, float]

ONLY = MappingProxyType({"only solution": ()})
REACHES = MappingProxyType({"reaching forward": (1.0,), "reaching backward": (-1.0,)})
AIMS = MappingProxyType(
    {
        "reaching forward": (1.0, 1.0),
        "reaching forward, over the top": (1.0, -1.0),
        "reaching backward": (-1.0, 1.0),
        "reaching backward, over the top": (-1.0, -1.0),
    }
)

X_UP = transform(((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), ZERO)
"""A frame whose x, y and z point along the reference's y, z and x: a first joint along x."""

X_LAST = transform(((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)), ZERO)
"""A frame whose x, y and z point along the reference's z, x and y: a last joint along x."""


UPRIGHT = transform(((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0)), ZERO)
"""A frame whose x, y and z point along the reference's z, against its y, and along its x."""


class Transporter(System):
    """What the transporters share: the goal is the end point, as they position and do not turn."""

    __slots__ = ()

    source: ClassVar[str] = "Vectors and frames, chapter 2, section 2.5.2"
    coordinates: ClassVar[tuple[str, ...]] = ("x_mm", "y_mm", "z_mm")

    def goal_of(self, frame: Transform) -> tuple[float, ...]:
        """Return the end point's x, y and z in mm."""
        return position_of(frame)

    def lengths(self) -> dict[str, float]:
        """Return no constant length."""
        return {}


@dataclass(frozen=True, slots=True)
class CartesianTransporter(Transporter):
    """Three prismatic joints along x, y and z (figure 2.14)."""

    ranges_mm: tuple[Span, Span, Span] = ((0.0, 500.0), (0.0, 500.0), (0.0, 500.0))

    name: ClassVar[str] = "cartesian"
    title: ClassVar[str] = "Cartesian transporter (three prismatic joints)"
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = ONLY
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep("end point", "X = d1,  Y = d2,  Z = d3", "the joints are the coordinates"),
        NamedStep("inverse", "d1 = X,  d2 = Y,  d3 = Z", "one solution"),
    )
    drawing: ClassVar[str] = r"""
      z       o end point
      |       | d3
      | d2  [=]
      |   ./
     [=]-'------ x
         d1
    """

    def chain(self) -> Chain:
        """Return the link table: twice 90 degrees of angle and twist, which permute the axes."""
        (low1, high1), (low2, high2), (low3, high3) = self.ranges_mm
        slides = JointKind.PRISMATIC
        links = (
            DHLink(QUARTER_TURN, alpha_rad=QUARTER_TURN, kind=slides, low=low1, high=high1),
            DHLink(QUARTER_TURN, alpha_rad=QUARTER_TURN, kind=slides, low=low2, high=high2),
            DHLink(kind=slides, low=low3, high=high3),
        )
        return Chain(links, base=X_UP, name=self.name, joint_names=("d1", "d2", "d3"))

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        x, y, z = joints
        return (1.0, 0.0, 0.0, x), (0.0, 1.0, 0.0, y), (0.0, 0.0, 1.0, z), LAST_ROW

    def _solution(self, goal: tuple[float, ...], *_signs: float) -> Solved:
        return goal, ()

    def _ik(self, goal: tuple[float, ...], _seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        return [self.solution(goal, "only solution")]


@dataclass(frozen=True, slots=True)
class CylindricalTransporter(Transporter):
    """A revolute joint, a lift and a radial slide (figure 2.15, equations 2.28 to 2.32)."""

    l_range_mm: Span = (0.0, 500.0)
    r_range_mm: Span = (0.0, 500.0)

    name: ClassVar[str] = "cylindrical"
    title: ClassVar[str] = "Cylindrical transporter (one revolute, two prismatic joints)"
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = REACHES
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep(
            "end point", "X = r cos(theta),  Y = r sin(theta),  Z = l", "equations 2.28 to 2.30"
        ),
        NamedStep("slide", "r = +- sqrt(X^2 + Y^2)", "equation 2.31; the notes give the plus only"),
        NamedStep("base", "theta = atan2(Y / r, X / r)", "equation 2.31; free where r = 0"),
        NamedStep("lift", "l = Z", "equation 2.32"),
    )
    drawing: ClassVar[str] = r"""
      z    r
     [=]=======--o end point
      |
      | l
     [=]
     _|_
    (___) theta
    """

    def chain(self) -> Chain:
        """Return the link table: theta, l and r, with 90 degrees of angle and twist before r."""
        (low2, high2), (low3, high3) = self.l_range_mm, self.r_range_mm
        slides = JointKind.PRISMATIC
        links = (
            DHLink(),
            DHLink(QUARTER_TURN, alpha_rad=QUARTER_TURN, kind=slides, low=low2, high=high2),
            DHLink(kind=slides, low=low3, high=high3),
        )
        return Chain(links, tool=X_LAST, name=self.name, joint_names=("theta", "l", "r"))

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        theta, up, out = joints
        c, s = cos(theta), sin(theta)
        return (c, -s, 0.0, out * c), (s, c, 0.0, out * s), (0.0, 0.0, 1.0, up), LAST_ROW

    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        (x, y, z), (side,) = goal, signs
        out = side * sqrt(x * x + y * y)
        return (atan2(side * y, side * x), z, out), (Quantity("r", out, "mm"),)

    def _ik(self, goal: tuple[float, ...], seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        if math.hypot(goal[0], goal[1]) > REACH_MM:
            return [self.solution(goal, branch) for branch in self.signs]
        return [NamedBranch("base free", (seed[0], goal[2], 0.0), (), ("theta",), ON_AXIS)]


@dataclass(frozen=True, slots=True)
class SphericalTransporter(Transporter):
    """Azimuth, elevation and a slide from the origin (figure 2.16, equations 2.33 and 2.34)."""

    r_range_mm: Span = (0.0, 500.0)

    name: ClassVar[str] = "spherical"
    title: ClassVar[str] = "Spherical transporter (two revolute joints, one prismatic)"
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = AIMS
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep(
            "end point",
            "X = r cos(theta) cos(phi),  Y = r cos(theta) sin(phi),  Z = r sin(theta)",
            "equation 2.33",
        ),
        NamedStep("slide", "r = +- sqrt(X^2 + Y^2 + Z^2)", "the notes give the plus only"),
        NamedStep(
            "elevation",
            "cos(theta) = +- sqrt(X^2 + Y^2) / |r|,  sin(theta) = Z / r",
            "equation 2.34; the second is over the top, 180 degrees - theta",
        ),
        NamedStep(
            "azimuth",
            "cos(phi) = X / (r cos(theta)),  sin(phi) = Y / (r cos(theta))",
            "after equation 2.34, which leaves out r; free where cos(theta) = 0",
        ),
    )
    drawing: ClassVar[str] = r"""
      z        .o end point
      |    r .-'
      |  _.-'
      (=)  ) theta
     _|_-------- x, y
    (___) phi
    """

    def chain(self) -> Chain:
        """Return the link table: phi and theta with twists of 90 degrees, and r."""
        low, high = self.r_range_mm
        links = (
            DHLink(alpha_rad=QUARTER_TURN),
            DHLink(alpha_rad=QUARTER_TURN, offset=QUARTER_TURN),
            DHLink(kind=JointKind.PRISMATIC, low=low, high=high),
        )
        return Chain(links, tool=UPRIGHT, name=self.name, joint_names=("phi", "theta", "r"))

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        phi, theta, r = joints
        cp, sp, ct, st = cos(phi), sin(phi), cos(theta), sin(theta)
        out = r * ct
        return (
            (cp * ct, -sp, -(cp * st), out * cp),
            (sp * ct, cp, -(sp * st), out * sp),
            (st, 0.0, ct, r * st),
            LAST_ROW,
        )

    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        (x, y, z), (reach, top) = goal, signs
        r = reach * sqrt(x * x + y * y + z * z)
        out = top * sqrt(x * x + y * y)
        side = reach * top
        workings = (Quantity("r", r, "mm"), Quantity("|r| cos(theta)", out, "mm"))
        return (atan2(side * y, side * x), atan2(reach * z, out), r), workings

    def _ik(self, goal: tuple[float, ...], seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        if math.hypot(*goal) <= REACH_MM:
            free, words = ("phi", "theta"), "the end point is at the origin: both angles are free"
            return [NamedBranch("all free", (seed[0], seed[1], 0.0), (), free, words)]
        if math.hypot(goal[0], goal[1]) > REACH_MM:
            return [self.solution(goal, branch) for branch in self.signs]
        found = []
        for branch in ("reaching forward", "reaching backward"):
            (_, theta, r), workings = self._solution(goal, *self.signs[branch])
            joints = (seed[0], theta, r)
            found.append(NamedBranch(branch, joints, workings, ("phi",), ON_AXIS))
        return found


# The general revolute transporter: three revolute joints, up to four solutions (section 2.5.2,
# figure 2.17 and equation 2.35). The links stand upright in the zero position.

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
    derivation: ClassVar[tuple[NamedStep, ...]] = (
        NamedStep(
            "arm's own plane", "h = S2 L2 + S23 L3", "how far the arm leans away from the axis"
        ),
        NamedStep("end point", "X = S1 h,  Y = -C1 h,  Z = L1 + C2 L2 + C23 L3", "equation 2.35"),
        NamedStep(
            "base", "h = +- sqrt(X^2 + Y^2),  theta1 = atan2(X / h, -Y / h)", "two solutions"
        ),
        NamedStep(
            "elbow",
            "C3 = (h^2 + (Z - L1)^2 - L2^2 - L3^2) / (2 L2 L3),  S3 = +- sqrt(1 - C3^2)",
            "cosine rule in the arm's plane: two solutions for each",
        ),
        NamedStep(
            "shoulder", "theta2 = atan2(h, Z - L1) - atan2(L3 S3, L2 + L3 C3)", "from upright"
        ),
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
