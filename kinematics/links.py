"""Joints and links: revolute and prismatic, a link's four parameters, its A matrix.

Source: McKerrow, chapter 4, sections 1 (joints), 3 (general links) and 6 (A matrices); Craig,
chapter 3, for the other convention. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from kinematics.errors import KinematicsError, finite
from kinematics.frames import LAST_ROW, Transform
from kinematics.numbers import cos, cos_sin, is_own_kind, sin


class JointKind(Enum):
    """What a joint lets its link do: turn about the axis, or slide along it (section 1)."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"

    @property
    def unit(self) -> str:
        """The unit of the joint's variable: rad or mm."""
        return "rad" if self is JointKind.REVOLUTE else "mm"


class Convention(Enum):
    """Where a link's frame sits, and with it the order of the four moves of an A matrix.

    STANDARD (distal): frame n is at the joint that follows link n, and
    A = Rot(z, theta) Trans(0, 0, d) Trans(a, 0, 0) Rot(x, alpha).
    CRAIG (modified, proximal): frame n is at the joint that moves link n, the row holds a and
    alpha of the link before, and A = Rot(x, alpha) Trans(a, 0, 0) Rot(z, theta) Trans(0, 0, d).
    """

    STANDARD = "standard"
    CRAIG = "craig"


@dataclass(frozen=True, slots=True)
class DHLink:
    """A row of a link table: angle between the links, distance, length and twist.

    `theta_rad` and `d_mm` are those of the zero position: the joint's value is added to the one
    that varies, and so is `offset`, which is how far the table's zero lies from the joint's own
    (theta = theta_rad + value + offset for a revolute joint, d = d_mm + value + offset for a
    prismatic one). `offset`, `low` and `high` are in the unit of the joint, rad or mm; `low` and
    `high` bound the value. Parameters may be numbers of any kind (see `numbers`); plain ones
    that are not finite raise `BadNumber`, limits in the wrong order `KinematicsError`.
    """

    theta_rad: float = 0.0
    d_mm: float = 0.0
    a_mm: float = 0.0
    alpha_rad: float = 0.0
    kind: JointKind = JointKind.REVOLUTE
    offset: float = 0.0
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        for name in ("theta_rad", "d_mm", "a_mm", "alpha_rad", "offset"):
            object.__setattr__(self, name, _number(name, getattr(self, name)))
        for name in ("low", "high"):
            value = getattr(self, name)
            if value not in (-math.inf, math.inf):
                object.__setattr__(self, name, _number(name, value))
        if self.low > self.high:
            raise KinematicsError(
                f"a joint's low limit ({self.low:g} {self.kind.unit}) must not lie above its "
                f"high limit ({self.high:g} {self.kind.unit})"
            )

    @property
    def has_limits(self) -> bool:
        """Whether the joint ends anywhere."""
        return self.low != -math.inf or self.high != math.inf

    def parameters(self, value: float) -> tuple[float, float, float, float]:
        """Return theta, d, a and alpha with the joint at a value (rad or mm)."""
        if self.kind is JointKind.REVOLUTE:
            return self.theta_rad + value + self.offset, self.d_mm, self.a_mm, self.alpha_rad
        return self.theta_rad, self.d_mm + value + self.offset, self.a_mm, self.alpha_rad

    def matrix(self, value: float, convention: Convention = Convention.STANDARD) -> Transform:
        """Return the A matrix: this link's frame in the one before it."""
        return a_matrix(*self.parameters(value), convention)


def a_matrix(
    theta_rad: float,
    d_mm: float,
    a_mm: float,
    alpha_rad: float,
    convention: Convention = Convention.STANDARD,
) -> Transform:
    """Return the A matrix of four link parameters (section 6; Craig, equation 3.6).

    Works on any kind of number.
    """
    ct, st = cos(theta_rad), sin(theta_rad)
    ca, sa = cos_sin(alpha_rad)
    if convention is Convention.STANDARD:
        return (
            (ct, -st * ca, st * sa, a_mm * ct),
            (st, ct * ca, -ct * sa, a_mm * st),
            (0.0, sa, ca, d_mm),
            LAST_ROW,
        )
    return (
        (ct, -st, 0.0, a_mm),
        (st * ca, ct * ca, -sa, -sa * d_mm),
        (st * sa, ct * sa, ca, ca * d_mm),
        LAST_ROW,
    )


def _number(name: str, value: float) -> float:
    """Return a plain number checked, a number of another kind as it is."""
    return value if is_own_kind(value) else finite(name, value)
