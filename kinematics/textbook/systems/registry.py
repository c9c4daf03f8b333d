"""The named systems of the textbook, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from kinematics.errors import UnknownSystem, nearest_word
from kinematics.textbook.systems.mini_movers import Alpha2, MiniMover
from kinematics.textbook.systems.named import System
from kinematics.textbook.systems.puma import Puma
from kinematics.textbook.systems.three_link import ThreeLink
from kinematics.textbook.systems.transporters import (
    CartesianTransporter,
    CylindricalTransporter,
    RevoluteTransporter,
    SphericalTransporter,
)
from kinematics.textbook.systems.two_link import (
    TwoLinkType1,
    TwoLinkType2,
    TwoLinkType3,
    TwoLinkType4,
    TwoLinkType5,
)

SYSTEMS: Mapping[str, System] = MappingProxyType(
    {
        one.name: one
        for one in (
            TwoLinkType1(),
            TwoLinkType2(),
            TwoLinkType3(),
            TwoLinkType4(),
            TwoLinkType5(),
            ThreeLink(),
            CartesianTransporter(),
            CylindricalTransporter(),
            SphericalTransporter(),
            RevoluteTransporter(),
            MiniMover(),
            Alpha2(),
            Puma(),
        )
    }
)
"""Every system with its default lengths; the classes make others of the same build."""


def system(name: str) -> System:
    """Return the system of this name, or raise `UnknownSystem` that suggests the nearest one."""
    found = SYSTEMS.get(name)
    if found is None:
        near = nearest_word(str(name).lower(), SYSTEMS, likeness=0.4)
        raise UnknownSystem(name, SYSTEMS, near)
    return found
