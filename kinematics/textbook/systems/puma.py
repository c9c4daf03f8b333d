"""The simplified Puma: six revolute joints, a spherical wrist, eight branches.

Source: McKerrow, chapter 4, section 16, which neglects l3, the elbow's small offset; link table
and joint ranges after Fu, Gonzalez and Lee (1987), chapter 2. Any lengths may be given, the
offsets of shoulder and elbow included. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from itertools import product
from types import MappingProxyType

from kinematics.chains.chain import Chain
from kinematics.chains.links import DHLink
from kinematics.frames.numbers import atan2, cos, sin
from kinematics.frames.orientations import RPY
from kinematics.frames.rotations import columns, rotate, transpose
from kinematics.textbook.systems.named import (
    QUARTER_TURN,
    NamedSingularity,
    Quantity,
    Solved,
    System,
    Values,
    frame_coordinates,
)
from kinematics.textbook.systems.triangle import elbow_singularities, root, to_half_turn, triangle

WRIST_STRAIGHT = "joint 5 is straight: only joints 4 and 6 together turn the hand"
BASE_EDGE = "the wrist is as near to the base axis as it goes: front and back are one"
BASE_FREE = "the wrist is on the base axis: the base is free"

RANGES_DEG = ((-160, 160), (-225, 45), (-45, 225), (-110, 170), (-100, 100), (-266, 266))


def _table(d1: float, a1: float, d2: float, a2: float, a3: float, d4: float, d6: float) -> Chain:
    """Return the link table of Fu, Gonzalez and Lee, the zero position theirs too."""
    rows = (
        (d1, a1, -QUARTER_TURN),
        (d2, a2, 0.0),
        (0.0, a3, QUARTER_TURN),
        (d4, 0.0, -QUARTER_TURN),
        (0.0, 0.0, QUARTER_TURN),
        (d6, 0.0, 0.0),
    )
    links = tuple(DHLink(0.0, d, a, alpha) for d, a, alpha in rows)
    return Chain(links, joint_names=tuple(f"theta{number}" for number in range(1, 7)))


def _formulas(one: System, goal: Values, side: float, bend: float, flip: float) -> Solved:
    (d1, a1, d2, a2, a3, d4, d6), (px, py, pz, *angles) = one.sizes, goal
    hand = columns(RPY(*angles).rotation())  # n, o and a
    ax, ay, az = hand[2]
    x, y, z = px - d6 * ax, py - d6 * ay, pz - d6 * az
    out = side * root(x * x + y * y - d2 * d2)
    first = atan2(y, x) - atan2(d2, out)
    elbow = triangle(out - a1, z - d1, a2, root(a3 * a3 + d4 * d4), -(side * bend))
    lean = atan2(d4, a3)
    both = lean - elbow.second - elbow.first
    c1, s1, c, s = cos(first), sin(first), cos(both), sin(both)
    forearm = (c1 * c, -s1, c1 * s), (s1 * c, c1, s1 * s), (-s, 0.0, c)
    (nx, ny, _), (ox, oy, _), (wx, wy, wz) = (rotate(transpose(forearm), one) for one in hand)
    bent = flip * root(wx * wx + wy * wy)
    fourth = atan2(flip * wy, flip * wx)
    c4, s4 = cos(fourth), sin(fourth)
    sixth = atan2(c4 * ny - s4 * nx, c4 * oy - s4 * ox)
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


def _singularities(one: System, joints: Values) -> list[NamedSingularity]:
    (_, a1, d2, a2, a3, d4, _), (_, second, third, _, fifth, _) = one.sizes, joints
    both = second + third
    out = a1 + a2 * math.cos(second)
    out += a3 * math.cos(both) + d4 * math.sin(both)
    return [
        *elbow_singularities(third - math.atan2(d4, a3), a2, math.hypot(a3, d4)),
        NamedSingularity(WRIST_STRAIGHT, to_half_turn(fifth), None),
        NamedSingularity(BASE_EDGE if d2 else BASE_FREE, None, abs(out)),
    ]


# A Puma of any lengths; by default those of the Puma 560 with its elbow offset neglected.
PUMA = System(
    name="puma",
    coordinates=("x_mm", "y_mm", "z_mm", "phi_rad", "theta_rad", "psi_rad"),
    signs=MappingProxyType(
        {
            f"base {base}, elbow {elbow}, wrist {wrist}": (side, bend, flip)
            for (base, side), (elbow, bend), (wrist, flip) in product(
                (("front", 1.0), ("back", -1.0)),
                (("up", 1.0), ("down", -1.0)),
                (("plain", 1.0), ("flipped", -1.0)),
            )
        }
    ),
    length_names=("d1", "a1", "d2", "a2", "a3", "d4", "d6"),
    sizes=(0.0, 0.0, 149.09, 431.8, 0.0, 433.07, 56.25),
    ranges=tuple((math.radians(low), math.radians(high)) for low, high in RANGES_DEG),
    table=_table,
    formulas=_formulas,
    coordinates_of=lambda _, frame: frame_coordinates(frame),
    singularities=_singularities,
)
