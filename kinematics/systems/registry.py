"""The named systems of the textbook, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from kinematics.errors import UnknownSystem
from kinematics.near_words import nearest_word
from kinematics.systems.alpha2 import Alpha2
from kinematics.systems.minimover import MiniMover
from kinematics.systems.named_system import System
from kinematics.systems.puma import Puma
from kinematics.systems.revolute_transporter import RevoluteTransporter
from kinematics.systems.three_link import ThreeLink
from kinematics.systems.transporters import (
    CartesianTransporter,
    CylindricalTransporter,
    SphericalTransporter,
)
from kinematics.systems.two_link_lifting import TwoLinkType4, TwoLinkType5
from kinematics.systems.two_link_sliding import TwoLinkType3
from kinematics.systems.two_link_turning import TwoLinkType1, TwoLinkType2

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
