"""The four transporters: cartesian, cylindrical, spherical and general revolute, all solutions.

Source: "Vectors and frames", chapter 2, section 2.5.2, equations 2.28 to 2.35. The notes' frames
start parallel to the base frame, so each hand's frame here is the base frame in the zero position.
Lengths in mm, angles in rad; ranges and lengths are examples, since the source gives none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

from kinematics.chains import Chain
from kinematics.frames import LAST_ROW, Transform, position_of, transform
from kinematics.links import DHLink, JointKind
from kinematics.numbers import atan2, cos, sin, sqrt
from kinematics.systems.named_system import (
    ON_AXIS,
    REACH_MM,
    NamedBranch,
    Quantity,
    Solved,
    Step,
    System,
)
from kinematics.vectors import ZERO

QUARTER_TURN = math.pi / 2.0
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
    derivation: ClassVar[tuple[Step, ...]] = (
        Step("end point", "X = d1,  Y = d2,  Z = d3", "the joints are the coordinates"),
        Step("inverse", "d1 = X,  d2 = Y,  d3 = Z", "one solution"),
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
    derivation: ClassVar[tuple[Step, ...]] = (
        Step("end point", "X = r cos(theta),  Y = r sin(theta),  Z = l", "equations 2.28 to 2.30"),
        Step("slide", "r = +- sqrt(X^2 + Y^2)", "equation 2.31; the notes give the plus only"),
        Step("base", "theta = atan2(Y / r, X / r)", "equation 2.31; free where r = 0"),
        Step("lift", "l = Z", "equation 2.32"),
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
    derivation: ClassVar[tuple[Step, ...]] = (
        Step(
            "end point",
            "X = r cos(theta) cos(phi),  Y = r cos(theta) sin(phi),  Z = r sin(theta)",
            "equation 2.33",
        ),
        Step("slide", "r = +- sqrt(X^2 + Y^2 + Z^2)", "the notes give the plus only"),
        Step(
            "elevation",
            "cos(theta) = +- sqrt(X^2 + Y^2) / |r|,  sin(theta) = Z / r",
            "equation 2.34; the second is over the top, 180 degrees - theta",
        ),
        Step(
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
