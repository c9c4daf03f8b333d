"""The systems of the lecture notes by name: models with figure, link table, FK and every IK branch.

`system("puma")` gives one, `SYSTEMS` all of them, and `sized` others of the same build. Lengths in
mm, angles in rad.
"""

from collections.abc import Mapping
from types import MappingProxyType

from kinematics.errors import UnknownSystem, nearest_word
from kinematics.textbook.systems.mini_movers import ALPHA_2, MINI_MOVER
from kinematics.textbook.systems.named import System
from kinematics.textbook.systems.puma import PUMA
from kinematics.textbook.systems.transporters import CARTESIAN, CYLINDRICAL, REVOLUTE, SPHERICAL
from kinematics.textbook.systems.two_link import (
    THREE_LINK,
    TWO_LINK_1,
    TWO_LINK_2,
    TWO_LINK_3,
    TWO_LINK_4,
    TWO_LINK_5,
)

SYSTEMS: Mapping[str, System] = MappingProxyType(
    {
        one.name: one
        for one in (
            TWO_LINK_1,
            TWO_LINK_2,
            TWO_LINK_3,
            TWO_LINK_4,
            TWO_LINK_5,
            THREE_LINK,
            CARTESIAN,
            CYLINDRICAL,
            SPHERICAL,
            REVOLUTE,
            MINI_MOVER,
            ALPHA_2,
            PUMA,
        )
    }
)
"""Every system with its default lengths."""


def system(name: str) -> System:
    """Return the system of this name, or raise `UnknownSystem` that suggests the nearest one."""
    found = SYSTEMS.get(name)
    if found is None:
        near = nearest_word(str(name).lower(), SYSTEMS, likeness=0.4)
        raise UnknownSystem(name, SYSTEMS, near)
    return found
