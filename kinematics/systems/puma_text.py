"""The Puma's figure in text and the steps of its derivation (McKerrow, chapter 4, section 16)."""

from __future__ import annotations

from kinematics.systems.named_system import Step

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
