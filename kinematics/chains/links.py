"""Joints and links: revolute and prismatic, a link's four parameters and its A matrix, both ways.

Source: McKerrow, chapter 4, sections 1 (joints), 3 (general links) and 6 (A matrices);
Craig, chapter 3, for the other convention. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from kinematics.errors import KinematicsError, check_fields
from kinematics.frames.numbers import cos_sin, number
from kinematics.frames.transforms import LAST_ROW, Transform, position_of
from kinematics.frames.vectors import distance


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
        check_fields(self, number, "theta_rad", "d_mm", "a_mm", "alpha_rad", "offset")
        ends = [one for one in ("low", "high") if getattr(self, one) not in (-math.inf, math.inf)]
        check_fields(self, number, *ends)
        if self.low > self.high:
            raise KinematicsError(
                f"a joint's low limit ({self.low:g} {self.kind.unit}) must not lie above its "
                f"high limit ({self.high:g} {self.kind.unit})"
            )

    @property
    def bounded(self) -> bool:
        """Whether the joint ends on both sides."""
        return math.isfinite(self.low) and math.isfinite(self.high)

    def parameters(self, value: float) -> tuple[float, float, float, float]:
        """Return theta, d, a, alpha at a value of the joint in rad or mm; raises `BadNumber`."""
        value = number("a joint's value", value)
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

    Works on any kind of number; raises `BadNumber` for a plain one that is not finite.
    """
    theta_rad, alpha_rad = number("theta_rad", theta_rad), number("alpha_rad", alpha_rad)
    d_mm, a_mm = number("d_mm", d_mm), number("a_mm", a_mm)
    (ct, st), (ca, sa) = cos_sin(theta_rad), cos_sin(alpha_rad)
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


# From a frame in another frame back to the four link parameters, where there are such.
#
# Source: McKerrow, chapter 4, section 6, solved for its parameters; Craig, chapter 3. Four numbers
# cannot say where any frame is: frames that were not assigned by the rules are refused.

# A length this near to zero is zero: rounding of the axes' geometry.
CLEAN_MM = 1e-9

# An angle this near to a whole number of quarter turns is one.
CLEAN_RAD = 1e-9

# How far (mm, and of the entries of the rotation) the parameters may miss the frame.
MISFIT = 1e-6

_QUARTER = math.pi / 2


def link_parameters(
    frame: Transform, convention: Convention = Convention.STANDARD
) -> tuple[float, float, float, float] | None:
    """Return theta, d, a and alpha of a frame in the one before it; None if it has none."""
    (xx, xy, _, px), (yx, _, yz, py), (_, zy, zz, pz), _ = frame
    if convention is Convention.STANDARD:
        theta, alpha = math.atan2(yx, xx), math.atan2(zy, zz)
        length, along = px * math.cos(theta) + py * math.sin(theta), pz
    else:
        theta, alpha = math.atan2(-xy, xx), math.atan2(-yz, zz)
        length, along = px, pz * math.cos(alpha) - py * math.sin(alpha)
    if not all(map(math.isfinite, (theta, along, length, alpha))):
        return None
    found = _angle(theta), _length(along), _length(length), _angle(alpha)
    again = a_matrix(*found, convention)
    off = max(abs(again[i][j] - frame[i][j]) for i in range(3) for j in range(3))
    if off > MISFIT or distance(position_of(again), position_of(frame)) > MISFIT:
        return None
    return found


def assigned_parameters(
    number: int, frame: Transform, convention: Convention
) -> tuple[float, float, float, float]:
    """Return the parameters of link `number`, or raise `KinematicsError`, which names it."""
    found = link_parameters(frame, convention)
    if found is None:
        raise KinematicsError(
            f"link {number}: no four parameters of the {convention.value} convention lead to its "
            "frame; its axes are too nearly parallel to tell how they lie"
        )
    return found


def _length(value: float) -> float:
    return 0.0 if abs(value) < CLEAN_MM else value


def _angle(value: float) -> float:
    quarters = round(value / _QUARTER)
    if abs(value - quarters * _QUARTER) >= CLEAN_RAD:
        return value
    return math.pi if quarters == -2 else quarters * _QUARTER
