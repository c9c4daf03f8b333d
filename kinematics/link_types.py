"""The eight link types: what the joints at a link's two ends make of its parameters.

Source: McKerrow, chapter 4, section 2, in the standard (distal) convention: the link's own joint
is at its near end, and the parameters describe the way to the joint at its far end.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from kinematics.errors import KinematicsError
from kinematics.links import DHLink, JointKind

_QUARTER = math.pi / 2


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
