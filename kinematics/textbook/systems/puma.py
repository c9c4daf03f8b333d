"""The simplified Puma: six revolute joints, a spherical wrist, eight branches.

Source: McKerrow, chapter 4, section 16, which neglects l3, the elbow's small offset; link table
and joint ranges after Fu, Gonzalez and Lee (1987), chapter 2. Any lengths may be given, the
offsets of shoulder and elbow included. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType
from typing import ClassVar

from kinematics.chains.chain import Chain
from kinematics.chains.links import DHLink
from kinematics.errors import OutOfReach
from kinematics.frames.numbers import atan2, cos, sin
from kinematics.frames.orientations import RPY, solve_rpy
from kinematics.frames.transforms import (
    LAST_ROW,
    Transform,
    check_transform,
    compose,
    position_of,
    rotation_of,
    transform,
    translation,
)
from kinematics.textbook.systems.named import (
    QUARTER_TURN,
    REACH_MM,
    Miss,
    NamedBranch,
    NamedStep,
    Quantity,
    Solved,
    System,
)
from kinematics.textbook.systems.triangle import (
    FOLDED,
    STRAIGHT_SINE,
    STRETCHED,
    broken_bound,
    brought_within,
    root,
    triangle,
)
from kinematics.textbook.systems.wrist import STRAIGHT, Angles6, WristArm, inverse

# Where the wrist's centre of an arm with a spherical wrist can be, and what keeps it elsewhere.
# Joint limits aside: this is what the lengths alone allow.


def reach_broken(arm: WristArm, x: float, y: float, z: float) -> tuple[str, float, float]:
    """Return what a wrist's centre out of reach breaks: the quantity, its value, its bound."""
    radius, lateral = math.hypot(x, y), abs(arm.lateral)
    if radius < lateral:
        return "the wrist's distance from the base axis", radius, lateral
    out = math.sqrt(radius * radius - lateral * lateral)
    up = z - arm.height
    distance = min(
        (math.hypot(side - arm.shoulder_offset, up) for side in (out, -out)),
        key=lambda value: abs(value - (broken_bound(value, arm.upper, arm.reach) or value)),
    )
    bound = broken_bound(distance, arm.upper, arm.reach)
    return "the wrist's distance from the shoulder", distance, distance if bound is None else bound


def nearest_wrist(arm: WristArm, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a wrist's centre within reach near to this one, in the same direction of the base."""
    radius = math.hypot(x, y)
    out = math.sqrt(max(radius * radius - arm.lateral * arm.lateral, 0.0))
    up = z - arm.height
    near_out, near_up = min(
        _candidates(arm, out, up), key=lambda point: math.hypot(point[0] - out, point[1] - up)
    )
    wide = math.hypot(near_out, arm.lateral)
    along = (x / radius, y / radius) if radius > 0.0 else (1.0, 0.0)
    return along[0] * wide, along[1] * wide, near_up + arm.height


def _candidates(arm: WristArm, out: float, up: float) -> Iterator[tuple[float, float]]:
    """Yield points (outwards, upwards of the shoulder's height) that front or back reach."""
    longest = arm.upper + arm.reach
    for side in (1.0, -1.0):
        offset = side * arm.shoulder_offset
        near_out, near_up = brought_within(out - offset, up, arm.upper, arm.reach)
        if near_out + offset >= 0.0:
            yield near_out + offset, near_up
        if longest + offset >= 0.0:
            yield longest + offset, 0.0


# The Puma's tables: figure, derivation, branches, joint ranges, and what postures lose.

BRANCHES = MappingProxyType(
    {
        f"base {base}, elbow {elbow}, wrist {wrist}": (side, bend, flip)
        for (base, side), (elbow, bend), (wrist, flip) in product(
            (("front", 1.0), ("back", -1.0)),
            (("up", 1.0), ("down", -1.0)),
            (("plain", 1.0), ("flipped", -1.0)),
        )
    }
)
"""The eight branches in the order of `spherical_wrist.inverse`."""

WRIST_STRAIGHT = "joint 5 is straight: only joints 4 and 6 together turn the hand"
BASE_EDGE = "the wrist is as near to the base axis as it goes: front and back are one"
BASE_FREE = "the wrist is on the base axis: the base is free"

Range = tuple[float, float]
RANGES_DEG: tuple[Range, ...] = (
    (-160.0, 160.0),
    (-225.0, 45.0),
    (-45.0, 225.0),
    (-110.0, 170.0),
    (-100.0, 100.0),
    (-266.0, 266.0),
)

DRAWING = r"""
                 a2           z up, x outwards, in the arm's own plane
      shoulder o======o elbow
               |      |        joint 1 turns the whole about z,
            d1 |   d4 |        joints 2 and 3 are normal to the plane,
              _|_     |        joints 4, 5 and 6 meet in the wrist;
             (___)    o wrist  the plane stands d2 beside the base axis
                   d6 |
                      v hand
"""

DERIVATION = (
    NamedStep(
        "wrist",
        "pw = p - d6 a",
        "the last three axes meet there, so that only joints 1, 2 and 3 place it",
    ),
    NamedStep(
        "arm's own plane",
        "rho = a2 C2 + d4 S23,  h = d1 - a2 S2 + d4 C23",
        "outwards and upwards, with l3 neglected (a3 = 0)",
    ),
    NamedStep("wrist in the base frame", "xw = C1 rho - S1 d2,  yw = S1 rho + C1 d2,  zw = h"),
    NamedStep(
        "base",
        "rho = +- sqrt(xw^2 + yw^2 - d2^2),  theta1 = atan2(yw, xw) - atan2(d2, rho)",
        "front and back: two solutions",
    ),
    NamedStep(
        "elbow triangle",
        "cos(bend) = (rho^2 + (zw - d1)^2 - a2^2 - d4^2) / (2 a2 d4)",
        "cosine rule in the triangle of a2, d4 and the line from shoulder to wrist; "
        "theta3 = 90 degrees - bend, of either sign: elbow up and down",
    ),
    NamedStep(
        "shoulder",
        "theta2 = lift - direction",
        "direction of the wrist from the shoulder, lift of the upper arm above that line",
    ),
    NamedStep(
        "hand seen from the forearm",
        "R36 = R03^t R06 = Rot(z, theta4) Rot(y, theta5) Rot(z, theta6)",
        "what is left for the wrist are the Euler angles z-y-z (section 10)",
    ),
    NamedStep(
        "wrist joints",
        "theta4 = atan2(+-ay', +-ax'),  theta5 = atan2(+-sqrt(ax'^2 + ay'^2), az'),  "
        "theta6 = atan2(+-oz', -+nz')",
        "n', o', a' are the columns of R36: plain and flipped; with theta5 = 0 or 180 degrees "
        "only the sum or the difference of theta4 and theta6 is determined",
    ),
)


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
    derivation: ClassVar[tuple[NamedStep, ...]] = DERIVATION
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
