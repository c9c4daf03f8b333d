"""The Puma's tables: figure, derivation, branches, joint ranges, and what postures lose.

Source: McKerrow, chapter 4, section 16; joint ranges after Fu, Gonzalez and Lee (1987), chapter 2.
"""

from __future__ import annotations

from itertools import product
from types import MappingProxyType

from kinematics.systems.named_system import Step

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
    Step(
        "wrist",
        "pw = p - d6 a",
        "the last three axes meet there, so that only joints 1, 2 and 3 place it",
    ),
    Step(
        "arm's own plane",
        "rho = a2 C2 + d4 S23,  h = d1 - a2 S2 + d4 C23",
        "outwards and upwards, with l3 neglected (a3 = 0)",
    ),
    Step("wrist in the base frame", "xw = C1 rho - S1 d2,  yw = S1 rho + C1 d2,  zw = h"),
    Step(
        "base",
        "rho = +- sqrt(xw^2 + yw^2 - d2^2),  theta1 = atan2(yw, xw) - atan2(d2, rho)",
        "front and back: two solutions",
    ),
    Step(
        "elbow triangle",
        "cos(bend) = (rho^2 + (zw - d1)^2 - a2^2 - d4^2) / (2 a2 d4)",
        "cosine rule in the triangle of a2, d4 and the line from shoulder to wrist; "
        "theta3 = 90 degrees - bend, of either sign: elbow up and down",
    ),
    Step(
        "shoulder",
        "theta2 = lift - direction",
        "direction of the wrist from the shoulder, lift of the upper arm above that line",
    ),
    Step(
        "hand seen from the forearm",
        "R36 = R03^t R06 = Rot(z, theta4) Rot(y, theta5) Rot(z, theta6)",
        "what is left for the wrist are the Euler angles z-y-z (section 10)",
    ),
    Step(
        "wrist joints",
        "theta4 = atan2(+-ay', +-ax'),  theta5 = atan2(+-sqrt(ax'^2 + ay'^2), az'),  "
        "theta6 = atan2(+-oz', -+nz')",
        "n', o', a' are the columns of R36: plain and flipped; with theta5 = 0 or 180 degrees "
        "only the sum or the difference of theta4 and theta6 is determined",
    ),
)
