"""The systems of the lecture notes by name: models with figure, link table, FK and every IK branch.

`system("puma")` returns one, `SYSTEMS` has those of the notes, and `sized` makes others of the same
build. A built-in arm is a system too, with its own joint angles. A name always means the same arm
and the same joint angles: where the notes count the angles differently, the arm has another name.
Lengths in mm, angles in rad.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from types import MappingProxyType

from kinematics.errors import UnknownSystem
from kinematics.presets import PRESETS, preset
from kinematics.textbook.systems.mini_movers import ALPHA_2, MINI_MOVER, with_arm
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

# Every system of the notes with its default lengths.
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

# Every name that `system` knows: the systems of the notes, then the other built-in arms.
MODEL_NAMES = tuple(dict.fromkeys((*SYSTEMS, *PRESETS)))


def system(name: str) -> System:
    """Return the system of this name, or the built-in arm as a system.

    Raises `UnknownSystem`, which suggests the nearest name.
    """
    if isinstance(name, str) and name in SYSTEMS:
        return SYSTEMS[name]
    if isinstance(name, str) and name in PRESETS:
        return _built_in(name)
    raise UnknownSystem(name, MODEL_NAMES)


@cache
def _built_in(name: str) -> System:
    """Return a built-in arm as a system of the Mini-mover's build."""
    known = preset(name)
    made = with_arm(MINI_MOVER, known.arm)
    return replace(made, name=name, called=known.title, of_notes=MINI_MOVER.name)
