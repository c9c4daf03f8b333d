"""The dialects: a row for each, of what it states about itself and of its simulated device.

No other file names a dialect: where it matters what a device can do, its row is asked. To add one,
write its subpackages and add its row to `_ROWS` (docs/adding-a-controller.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from armdrive.config.arm import ArmConfig, DialectSections, config_of_preset, load, parse
from armdrive.config.check import problems_of
from armdrive.config.sections import Connection
from armdrive.dialects.armdroid.entry import ENTRY as ARMDROID
from armdrive.dialects.cia402.entry import ENTRY as CIA402
from armdrive.dialects.dialect import Dialect, Language
from armdrive.dialects.grbl.entry import ENTRY as GRBL
from armdrive.dialects.mks.entry import ENTRY as MKS
from armdrive.dialects.pendant import PendantTools
from armdrive.dialects.recognition import Recogniser
from armdrive.dialects.robko01.entry import ENTRY as ROBKO01
from armdrive.dialects.teachmover.entry import ENTRY as TEACHMOVER

# The TeachMover's is the one such program so far: other code takes the name from the registry.
from armdrive.dialects.teachmover.pendant import PendantProgram as PendantProgram
from armdrive.errors import BadRequest, Refused
from firmware_protocol.frames import Frame
from kinematics.errors import suggestion

if TYPE_CHECKING:
    from armdrive.sim.device import SimDevice, SimDeviceKind, Value
    from armdrive.sim.simulated_arm import SimulatedArm
    from armdrive.sim.world.table import Stand, TableBlock


# Simulated devices are imported when one is made: an arm on a real wire needs none.


def _teachmover() -> SimDeviceKind:
    from armdrive.sim.teachmover.kind import KIND

    return KIND


def _robko01() -> SimDeviceKind:
    from armdrive.sim.robko01.kind import KIND

    return KIND


def _armdroid() -> SimDeviceKind:
    from armdrive.sim.armdroid.kind import KIND

    return KIND


def _grbl() -> SimDeviceKind:
    from armdrive.sim.grbl.kind import KIND

    return KIND


def _mks() -> SimDeviceKind:
    from armdrive.sim.mks.kind import KIND

    return KIND


def _cia402() -> SimDeviceKind:
    from armdrive.sim.cia402.kind import KIND

    return KIND


@dataclass(frozen=True, slots=True)
class RegistryRow:
    """One dialect: what it states about itself, and how its simulated device is made."""

    entry: Dialect
    simulated: Callable[[], SimDeviceKind]


_ROWS = (
    RegistryRow(TEACHMOVER, _teachmover),
    RegistryRow(ROBKO01, _robko01),
    RegistryRow(ARMDROID, _armdroid),
    RegistryRow(GRBL, _grbl),
    RegistryRow(MKS, _mks),
    RegistryRow(CIA402, _cia402),
)

DIALECTS: Mapping[str, Dialect] = MappingProxyType({row.entry.name: row.entry for row in _ROWS})
"""What each dialect states about itself, by its name."""
_SIMULATED = MappingProxyType({row.entry.name: row.simulated for row in _ROWS})

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


def pendant_of(config: ArmConfig) -> PendantTools[PendantProgram]:
    """Return how an arm's own program is read and written; raises `Refused` where it has none."""
    tools = dialect(config.connection.dialect).pendant
    if tools is None:
        raise Refused(f"the {config.title} keeps no program in a memory of its own")
    return tools


# Arms: an arm file is read with the sections of the dialects that are known here.


def sections() -> DialectSections:
    """Return the dialects that an arm file may name."""
    return DialectSections(DEFAULT, dialect)


def load_arm(path: Path) -> ArmConfig:
    """Read an arm file. Raises `ArmFileError` that names the file, the key and the mend."""
    return load(path, sections())


def parse_arm(table: Mapping[str, Any], *, name: str, folder: Path = Path()) -> ArmConfig:
    """Turn a parsed TOML document into an arm; a model file is looked for from `folder`."""
    return parse(table, sections(), name=name, folder=folder)


def arm_problems(table: dict[str, Any], name: str, folder: Path) -> list[str]:
    """Return a sentence for everything that is wrong with an arm file, as it is found."""
    return problems_of(table, sections(), name, folder)


def preset_arm(key: str, *, name: str, connection: Connection) -> ArmConfig:
    """Return an arm as it leaves the factory, on the given wire."""
    return config_of_preset(key, dialect(connection.dialect), name=name, connection=connection)


# Simulated devices.


def simulated_kind(name: str) -> SimDeviceKind:
    """Return how the simulated device of a dialect is made; raises as `dialect` does."""
    return _SIMULATED[dialect(name).name]()


def simulate(
    config: ArmConfig,
    saved: object = None,
    *,
    blocks: Iterable[TableBlock] = (),
    play: int | Sequence[int] | None = None,
    stand: Stand | None = None,
    **options: Value,
) -> SimulatedArm:
    """Build the simulated counterpart of an arm, as `simulated_arm` says."""
    from armdrive.sim.simulated_arm import simulated_arm

    kind = simulated_kind(config.connection.dialect)
    saved = _with_dialect(saved)
    return simulated_arm(config, kind, saved, blocks=blocks, play=play, stand=stand, **options)


def simulate_device(
    config: ArmConfig,
    saved: object = None,
    *,
    play: int | Sequence[int] | None = None,
    settings: Mapping[str, Value] | None = None,
) -> SimDevice:
    """Build the simulated device of an arm alone, for a process of its own."""
    from armdrive.sim.simulated_arm import simulated_device

    kind = simulated_kind(config.connection.dialect)
    return simulated_device(config, kind, _with_dialect(saved), play=play, settings=settings)


def _with_dialect(saved: object) -> object:
    """Return a saved world with its dialect: those of the first versions do not name it."""
    return {"dialect": DEFAULT, **saved} if isinstance(saved, Mapping) else saved


@cache
def recogniser() -> Recogniser:
    """Return what recognises the devices of every dialect that is not spoken on a bus."""
    found = {name: row.driver().recognition for name, row in DIALECTS.items()}
    return Recogniser(MappingProxyType({name: each for name, each in found.items() if each}))


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
