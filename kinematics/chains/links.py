"""Joints and links: revolute and prismatic, a link's four parameters and its A matrix, both ways.

Source: McKerrow, chapter 4, sections 1 (joints), 2 (types), 3 (general links) and 6 (A matrices);
Craig, chapter 3, for the other convention. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

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
    def has_limits(self) -> bool:
        """Whether the joint ends anywhere."""
        return self.low != -math.inf or self.high != math.inf

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

CLEAN_MM = 1e-9
"""A length this near to zero is zero: rounding of the axes' geometry."""

CLEAN_RAD = 1e-9
"""An angle this near to a whole number of quarter turns is one."""

MISFIT = 1e-6
"""How far (mm, and of the entries of the rotation) the parameters may miss the frame."""

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


# The eight link types: what the joints at a link's two ends make of its parameters.
#
# Source: McKerrow, chapter 4, section 2, in the standard (distal) convention: the link's own joint
# is at its near end, and the parameters describe the way to the joint at its far end.


@dataclass(frozen=True, slots=True)
class LinkType:
    """One of the eight types: its two joints, and which of its parameters are not zero.

    The near joint's variable is theta where that joint is revolute and d where it is prismatic.
    `has_length` says that the common normal of the axes has a length (a), `has_distance` that
    the origins are a constant distance d apart along the near axis; the twist is in rad.
    """

    number: int
    near: JointKind
    far: JointKind
    alpha_rad: float
    has_length: bool
    has_distance: bool
    sentence: str

    @property
    def variable(self) -> str:
        """Which link parameter the joint varies: theta or d."""
        return "theta" if self.near is JointKind.REVOLUTE else "d"

    def link(
        self,
        *,
        a_mm: float = 0.0,
        d_mm: float = 0.0,
        low: float = -math.inf,
        high: float = math.inf,
    ) -> DHLink:
        """Make a link of this type.

        `a_mm` and `d_mm` only where the type has them, `low` and `high` in the joint's unit.
        Raises `KinematicsError` for a length that the type does not have.
        """
        for name, given, has in (("a", a_mm, self.has_length), ("d", d_mm, self.has_distance)):
            if given != 0.0 and not has:
                raise KinematicsError(
                    f"a link of type {self.number} has no constant {name}, so {given} mm does not "
                    f"fit it: {self.sentence}"
                )
        return DHLink(
            d_mm=d_mm, a_mm=a_mm, alpha_rad=self.alpha_rad, kind=self.near, low=low, high=high
        )


_R, _P = JointKind.REVOLUTE, JointKind.PRISMATIC

_TYPES = (
    LinkType(
        1, _R, _R, 0.0, True, False,
        "two revolute joints with parallel axes, a link's length apart, without twist",
    ),
    LinkType(
        2, _R, _R, _QUARTER, True, False,
        "type 1 with the far joint twisted by 90° about the link's centre line",
    ),
    LinkType(
        3, _R, _R, _QUARTER, False, True,
        "two revolute joints whose axes intersect at a right angle, the near one along the link: "
        "the length is zero, and the joints are a distance apart along the near axis",
    ),
    LinkType(
        4, _R, _R, _QUARTER, False, False,
        "type 3 the other way round, the far axis along the link: the frames' origins coincide, "
        "so length and distance are both zero",
    ),
    LinkType(
        5, _P, _P, _QUARTER, False, False,
        "two prismatic joints at a right angle: the link only slides, along the near axis",
    ),
    LinkType(
        6, _R, _P, _QUARTER, False, True,
        "a revolute joint, then a prismatic one whose axis intersects it at a right angle: the "
        "variable is the angle instead of the distance",
    ),
    LinkType(
        7, _R, _P, 0.0, True, False,
        "a revolute joint with its axis orthogonal to the link, then a prismatic one parallel to "
        "it: the variable is the angle between the links",
    ),
    LinkType(
        8, _P, _R, _QUARTER, False, False,
        "a prismatic joint, then a revolute one whose axis intersects it at a right angle: the "
        "variable is the distance between the links",
    ),
)  # fmt: skip

LINK_TYPES: Mapping[int, LinkType] = MappingProxyType({one.number: one for one in _TYPES})
"""The eight types by number."""


def link_type(number: int) -> LinkType:
    """Return a link type by its number, 1 to 8. Raises `KinematicsError` for any other."""
    if number not in LINK_TYPES:
        raise KinematicsError(f"link types are numbered 1 to 8; there is no type {number!r}")
    return LINK_TYPES[number]
