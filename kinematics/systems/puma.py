"""The simplified Puma: six revolute joints, a spherical wrist, eight branches.

Source: McKerrow, chapter 4, section 16, which neglects l3, the elbow's small offset; link table
and joint ranges after Fu, Gonzalez and Lee (1987), chapter 2. Any lengths may be given, the
offsets of shoulder and elbow included. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

from kinematics.chains import Chain
from kinematics.errors import OutOfReach
from kinematics.frames import (
    LAST_ROW,
    Transform,
    compose,
    position_of,
    rotation_of,
    transform,
    translation,
)
from kinematics.links import DHLink
from kinematics.numbers import atan2, cos, sin
from kinematics.orientation_angles import RPY, solve_rpy
from kinematics.rotation_check import check_transform
from kinematics.systems.named_system import (
    REACH_MM,
    Miss,
    NamedBranch,
    Quantity,
    Solved,
    Step,
    System,
)
from kinematics.systems.puma_reach import nearest_wrist, reach_broken
from kinematics.systems.puma_tables import (
    BASE_EDGE,
    BASE_FREE,
    BRANCHES,
    DERIVATION,
    DRAWING,
    RANGES_DEG,
    WRIST_STRAIGHT,
    Range,
)
from kinematics.systems.spherical_wrist import STRAIGHT, Angles6, WristArm, inverse
from kinematics.systems.triangle import FOLDED, STRAIGHT_SINE, STRETCHED, root, triangle

QUARTER_TURN = math.pi / 2.0


@dataclass(frozen=True, slots=True)
class Puma(System):
    """A Puma of any lengths; by default those of the Puma 560 with its elbow offset neglected."""

    d1_mm: float = 0.0
    a1_mm: float = 0.0
    d2_mm: float = 149.09
    a2_mm: float = 431.8
    a3_mm: float = 0.0
    d4_mm: float = 433.07
    d6_mm: float = 56.25
    ranges_deg: tuple[Range, ...] = RANGES_DEG

    name: ClassVar[str] = "puma"
    title: ClassVar[str] = "Puma, simplified by neglecting l3 (six revolute joints)"
    source: ClassVar[str] = "McKerrow, chapter 4, section 16; Fu, Gonzalez and Lee, chapter 2"
    coordinates: ClassVar[tuple[str, ...]] = (
        "x_mm",
        "y_mm",
        "z_mm",
        "phi_rad",
        "theta_rad",
        "psi_rad",
    )
    signs: ClassVar[Mapping[str, tuple[float, ...]]] = BRANCHES
    derivation: ClassVar[tuple[Step, ...]] = DERIVATION
    drawing: ClassVar[str] = DRAWING

    def chain(self) -> Chain:
        """Return the link table of Fu, Gonzalez and Lee, the zero position theirs too."""
        rows = (
            (self.d1_mm, self.a1_mm, -QUARTER_TURN),
            (self.d2_mm, self.a2_mm, 0.0),
            (0.0, self.a3_mm, QUARTER_TURN),
            (self.d4_mm, 0.0, -QUARTER_TURN),
            (0.0, 0.0, QUARTER_TURN),
            (self.d6_mm, 0.0, 0.0),
        )
        links = tuple(
            DHLink(0.0, d, a, alpha, low=math.radians(low), high=math.radians(high))
            for (d, a, alpha), (low, high) in zip(rows, self.ranges_deg, strict=True)
        )
        return Chain(links, name=self.name, joint_names=tuple(f"theta{n}" for n in range(1, 7)))

    def lengths(self) -> dict[str, float]:
        """Return the lengths of the link table in mm."""
        return {
            "d1": self.d1_mm,
            "a1": self.a1_mm,
            "d2": self.d2_mm,
            "a2": self.a2_mm,
            "a3": self.a3_mm,
            "d4": self.d4_mm,
            "d6": self.d6_mm,
        }

    def wrist_arm(self) -> WristArm:
        """Return the lengths as `spherical_wrist.inverse` takes them, for loops on floats."""
        return WristArm.of(
            self.d1_mm,
            self.a1_mm,
            self.d2_mm,
            self.a2_mm,
            self.a3_mm,
            self.d4_mm,
            self.d6_mm,
        )

    def _fk(self, joints: tuple[float, ...]) -> Transform:
        first, second, third, fourth, fifth, sixth = joints
        both = second + third
        c1, s1, c, s = cos(first), sin(first), cos(both), sin(both)
        out = self.a1_mm + self.a2_mm * cos(second) + self.a3_mm * c + self.d4_mm * s
        up = self.d1_mm - self.a2_mm * sin(second) - self.a3_mm * s + self.d4_mm * c
        forearm = (
            (c1 * c, -s1, c1 * s, c1 * out - s1 * self.d2_mm),
            (s1 * c, c1, s1 * s, s1 * out + c1 * self.d2_mm),
            (-s, 0.0, c, up),
            LAST_ROW,
        )
        c4, s4, c5, s5, c6, s6 = (
            cos(fourth),
            sin(fourth),
            cos(fifth),
            sin(fifth),
            cos(sixth),
            sin(sixth),
        )
        wrist = (
            (c4 * c5 * c6 - s4 * s6, -(c4 * c5 * s6) - s4 * c6, c4 * s5, self.d6_mm * c4 * s5),
            (s4 * c5 * c6 + c4 * s6, c4 * c6 - s4 * c5 * s6, s4 * s5, self.d6_mm * s4 * s5),
            (-(s5 * c6), s5 * s6, c5, self.d6_mm * c5),
            LAST_ROW,
        )
        return compose(forearm, wrist)

    def frame_of(self, goal: Sequence[float]) -> Transform:
        """Return the hand's frame of a goal x, y, z, phi, theta, psi (sections 8 and 10)."""
        x, y, z, phi, theta, psi = goal
        return transform(RPY(phi, theta, psi).rotation(), (x, y, z))

    def goal_of(self, frame: Transform) -> tuple[float, ...]:
        """Return x, y, z in mm and phi, theta, psi in rad. Raises `NotARotation`."""
        angles = solve_rpy(rotation_of(frame)).first
        return *position_of(frame), angles.phi_rad, angles.theta_rad, angles.psi_rad

    def ik_frame(
        self, frame: Transform, seed: Sequence[float] | None = None
    ) -> tuple[tuple[NamedBranch, Miss], ...]:
        """Return every branch for a whole frame; six joints miss nothing but rounding.

        Raises `OutOfReach` and `NotARotation`.
        """
        near = self._seed(seed)
        found = self._finished(self._of_frame(check_transform(frame), near), near)
        return self._missed(found, frame)

    def _solution(self, goal: tuple[float, ...], *signs: float) -> Solved:
        return self._by_formulas(self.frame_of(goal), *signs)

    def _by_formulas(self, frame: Transform, *signs: float) -> Solved:
        """Solve one branch of a frame as the derivation does, on numbers of any kind."""
        side, bend, flip = signs
        (nx, ox, ax, px), (ny, oy, ay, py), (nz, oz, az, pz), _ = frame
        x, y, z = px - self.d6_mm * ax, py - self.d6_mm * ay, pz - self.d6_mm * az
        out = side * root(x * x + y * y - self.d2_mm * self.d2_mm)
        first = atan2(y, x) - atan2(self.d2_mm, out)
        reach = root(self.a3_mm * self.a3_mm + self.d4_mm * self.d4_mm)
        elbow = triangle(out - self.a1_mm, z - self.d1_mm, self.a2_mm, reach, -(side * bend))
        lean = atan2(self.d4_mm, self.a3_mm)
        both = lean - elbow.second - elbow.first
        c1, s1, c, s = cos(first), sin(first), cos(both), sin(both)
        n, o, a = c1 * nx + s1 * ny, c1 * ox + s1 * oy, c1 * ax + s1 * ay
        wx, wy, wz = c * a - s * az, c1 * ay - s1 * ax, s * a + c * az
        bent = flip * root(wx * wx + wy * wy)
        fourth = atan2(flip * wy, flip * wx)
        sixth = atan2(flip * (s * o + c * oz), -(flip * (s * n + c * nz)))
        joints = (first, -elbow.first, lean - elbow.second, fourth, atan2(bent, wz), sixth)
        workings = (
            Quantity("xw", x, "mm"),
            Quantity("yw", y, "mm"),
            Quantity("zw", z, "mm"),
            Quantity("rho", out, "mm"),
            *elbow.workings(),
            Quantity("S5", bent, ""),
        )
        return joints, workings

    def _ik(self, goal: tuple[float, ...], seed: tuple[float, ...]) -> Sequence[NamedBranch]:
        return self._of_frame(self.frame_of(goal), seed)

    def _of_frame(self, frame: Transform, seed: tuple[float, ...]) -> list[NamedBranch]:
        found = inverse(frame, self.wrist_arm(), (seed[0], seed[1], seed[3]))
        named = [
            self._named(branch, frame, joints)
            for branch, joints in zip(self.signs, found, strict=True)
            if joints is not None
        ]
        if not named:
            raise self._refusal(frame)
        return named

    def _named(self, branch: str, frame: Transform, joints: Angles6) -> NamedBranch:
        workings = self._by_formulas(frame, *self.signs[branch])[1]
        named = NamedBranch(branch, joints, workings)
        losses = []
        x, y, _ = self._wrist(frame)
        out = math.hypot(x, y)
        if out <= REACH_MM:
            losses.append(BASE_FREE)
            named = replace(named, free=("theta1",))
        elif abs(out - abs(self.d2_mm)) <= REACH_MM:
            losses.append(BASE_EDGE)
        bend = math.atan2(self.d4_mm, self.a3_mm) - joints[2]
        if abs(math.sin(bend)) <= STRAIGHT_SINE:
            losses.append(STRETCHED if math.cos(bend) > 0.0 else FOLDED)
            if math.hypot(self.a3_mm, self.d4_mm) + self.a2_mm * math.cos(bend) <= REACH_MM:
                named = replace(named, free=(*named.free, "theta2"))
        if abs(math.sin(joints[4])) <= STRAIGHT:
            losses.append(WRIST_STRAIGHT)
            named = replace(named, free=(*named.free, "theta4"))
        return replace(named, degenerate="; ".join(losses))

    def _wrist(self, frame: Transform) -> tuple[float, float, float]:
        """Return the wrist's centre: the hand's origin less d6 along the approach axis."""
        return position_of(compose(frame, translation(0.0, 0.0, -self.d6_mm)))

    def _refusal(self, frame: Transform) -> OutOfReach:
        x, y, z = self._wrist(frame)
        arm = self.wrist_arm()
        quantity, value, bound = reach_broken(arm, x, y, z)
        near_x, near_y, near_z = nearest_wrist(arm, x, y, z)
        moved = compose(translation(near_x - x, near_y - y, near_z - z), frame)
        return self._out_of_reach(quantity, value, bound, self.goal_of(moved))
