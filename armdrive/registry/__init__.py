"""The dialects: a row for each, which is what it states about itself.

No other file names a dialect: where it matters what a device can do, its row is asked. To add one,
write its subpackages and add its row to `_ROWS` (docs/background/adding-a-controller.md).

Every command of the command line reads this table, most of them for the names alone. What a
dialect needs to be driven, simulated or read from a file is imported when a row is asked for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from armdrive.dialects.armdroid import ENTRY as ARMDROID
from armdrive.dialects.cia402 import ENTRY as CIA402
from armdrive.dialects.dialect import Dialect, Language
from armdrive.dialects.grbl import ENTRY as GRBL
from armdrive.dialects.mks import ENTRY as MKS
from armdrive.dialects.robko01 import ENTRY as ROBKO01
from armdrive.dialects.teachmover import ENTRY as TEACHMOVER
from armdrive.errors import BadRequest, Refused
from kinematics.errors import suggestion

if TYPE_CHECKING:
    from armdrive.config.arm import ArmConfig
    from armdrive.dialects.pendant import PendantTools
    from armdrive.dialects.teachmover.pendant import PendantProgram
    from armdrive.sim.simulated_arm import SimDeviceKind
    from firmware_protocol.frames import Frame


# Simulated devices are imported when one is made: an arm on a real wire needs none.


def _teachmover() -> SimDeviceKind:
    from armdrive.sim.teachmover import KIND

    return KIND


def _robko01() -> SimDeviceKind:
    from armdrive.sim.robko01 import KIND

    return KIND


def _armdroid() -> SimDeviceKind:
    from armdrive.sim.armdroid import KIND

    return KIND


def _grbl() -> SimDeviceKind:
    from armdrive.sim.grbl import KIND

    return KIND


def _mks() -> SimDeviceKind:
    from armdrive.sim.mks import KIND

    return KIND


def _cia402() -> SimDeviceKind:
    from armdrive.sim.cia402 import KIND

    return KIND


_ROWS: tuple[tuple[Dialect, Callable[[], SimDeviceKind]], ...] = (
    (TEACHMOVER, _teachmover),
    (ROBKO01, _robko01),
    (ARMDROID, _armdroid),
    (GRBL, _grbl),
    (MKS, _mks),
    (CIA402, _cia402),
)
"""Each dialect: what it states about itself, and what returns how its simulated device is made."""

DIALECTS: Mapping[str, Dialect] = MappingProxyType({entry.name: entry for entry, _ in _ROWS})
"""What each dialect states about itself, by its name."""
_SIMULATED = MappingProxyType({entry.name: simulated for entry, simulated in _ROWS})

DEFAULT = TEACHMOVER.name
"""The dialect of an arm file that names none, and of the simulated arm where no arm is named."""


def dialect(name: str) -> Dialect:
    """Return a row of the table; raises `BadRequest` that suggests the nearest name."""
    try:
        return DIALECTS[name]
    except KeyError:
        hint = suggestion(name, DIALECTS)
        raise BadRequest(
            f"no dialect is named {name!r}; known are {', '.join(DIALECTS)}{hint}"
        ) from None


def simulated_kind(name: str) -> SimDeviceKind:
    """Return how the simulated device of a dialect is made; raises as `dialect` does."""
    return _SIMULATED[dialect(name).name]()


def pendant_of(config: ArmConfig) -> PendantTools[PendantProgram]:
    """Return how an arm's own program is read and written; raises `Refused` where it has none."""
    tools = dialect(config.connection.dialect).pendant
    if tools is None:
        raise Refused(f"the {config.title} keeps no program in a memory of its own")
    return tools


# What drives on a CAN bus speak.

LANGUAGES: Mapping[str, Language] = MappingProxyType(
    {row.language.name: row.language for row in DIALECTS.values() if row.language is not None}
)
"""Every language by its name."""
USUAL = next(iter(LANGUAGES.values()))
"""Taken where nobody says otherwise: that of the first row that is spoken on a bus."""


def language_of(name: str) -> Language:
    """Return the language of a dialect that is spoken on a bus, the usual one of any other."""
    return DIALECTS[name].language or USUAL


def likely(frames: Iterable[Frame]) -> Language:
    """Return the language in which the most of some frames can be read."""
    heard = tuple(frames)

    def foreign(language: Language) -> int:
        ear = language.ear()
        return sum(ear.hear(frame).foreign for frame in heard)

    return min(LANGUAGES.values(), key=foreign)
