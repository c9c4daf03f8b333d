"""The table of dialects: one row for each, with what the dialect states about itself.

No other file names a dialect; code that depends on a device's abilities asks its row. To add a
dialect, write its subpackages and add its row to `_ROWS` (docs/background/adding-a-controller.md).

Every command reads this table, usually for the names alone. The code that drives or simulates a
dialect, or reads its section of a file, is imported when its row is asked for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

from armdrive.dialects import Dialect, Language, on_demand
from armdrive.dialects.armdroid import ENTRY as ARMDROID
from armdrive.dialects.cia402 import ENTRY as CIA402
from armdrive.dialects.grbl import ENTRY as GRBL
from armdrive.dialects.mks import ENTRY as MKS
from armdrive.dialects.robko01 import ENTRY as ROBKO01
from armdrive.dialects.teachmover import ENTRY as TEACHMOVER
from armdrive.errors import BadRequest, Refused
from kinematics.errors import suggestion

if TYPE_CHECKING:
    from armdrive.config.arm import ArmConfig
    from armdrive.dialects.teachmover.pendant import PendantProgram
    from armdrive.sim.device import Value
    from armdrive.sim.simulated_arm import SimDeviceKind, SimulatedArm
    from armdrive.sim.world.table import Stand, TableBlock
    from firmware_protocol.frames import Frame


# Each dialect's statement about itself, and its simulated device: a real arm imports none.
_ROWS: tuple[tuple[Dialect, Callable[[], SimDeviceKind]], ...] = (
    (TEACHMOVER, on_demand("armdrive.sim.teachmover:KIND")),
    (ROBKO01, on_demand("armdrive.sim.robko01:KIND")),
    (ARMDROID, on_demand("armdrive.sim.armdroid:KIND")),
    (GRBL, on_demand("armdrive.sim.grbl:KIND")),
    (MKS, on_demand("armdrive.sim.mks:KIND")),
    (CIA402, on_demand("armdrive.sim.cia402:KIND")),
)

# What each dialect states about itself, by its name.
DIALECTS: Mapping[str, Dialect] = MappingProxyType({entry.name: entry for entry, _ in _ROWS})
_SIMULATED = MappingProxyType({entry.name: simulated for entry, simulated in _ROWS})

# The dialect of an arm file that names none, and of the simulated arm where no arm is named.
DEFAULT = TEACHMOVER.name


def dialect(name: str) -> Dialect:
    """Return a row of the table. Raises `BadRequest`, which suggests the nearest name."""
    try:
        return DIALECTS[name]
    except KeyError:
        hint = suggestion(name, DIALECTS)
        raise BadRequest(
            f"no dialect is named {name!r}; known are {', '.join(DIALECTS)}{hint}"
        ) from None


def simulated_kind(name: str) -> SimDeviceKind:
    """Return the kind of a dialect's simulated device. Raises as `dialect` does."""
    return _SIMULATED[dialect(name).name]()


def pendant_of(config: ArmConfig) -> type[PendantProgram]:
    """Return the class of an arm's own programs. Raises `Refused` if the arm keeps none."""
    programs: type[PendantProgram] | None = dialect(config.connection.dialect).pendant
    if programs is None:
        raise Refused(f"the {config.title} keeps no program in a memory of its own")
    return programs


# The languages of drives on a CAN bus.

# Every language by its name.
LANGUAGES: Mapping[str, Language] = MappingProxyType(
    {row.language.name: row.language for row in DIALECTS.values() if row.language is not None}
)
# The default language on a bus: that of the first such row.
USUAL = next(iter(LANGUAGES.values()))


def language_of(name: str) -> Language:
    """Return the language of a dialect on a bus; the default one for any other dialect."""
    return DIALECTS[name].language or USUAL


def likely(frames: Iterable[Frame]) -> Language:
    """Return the language in which most of these frames can be read."""
    seen = tuple(frames)

    def foreign(language: Language) -> int:
        describer = language.describer()
        return sum(describer.describe(frame).foreign for frame in seen)

    return min(LANGUAGES.values(), key=foreign)


def simulate(
    config: ArmConfig,
    saved: object = None,
    *,
    blocks: Iterable[TableBlock] = (),
    play: int | Sequence[int] | None = None,
    stand: Stand | None = None,
    **options: Value,
) -> SimulatedArm:
    """Build the simulated counterpart of an arm, as `SimDeviceKind.simulate` says."""
    kind = simulated_kind(config.connection.dialect)
    return kind.simulate(config, saved, blocks=blocks, play=play, stand=stand, settings=options)
