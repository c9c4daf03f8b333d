"""The table of simulated devices: for each dialect, how its device is made, and its settings.

To add one: a module with a class on `SimBase` and a `TwinKind`, and a row at the end of this file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

from armdrive.errors import BadRequest
from armdrive.sim.device import Option, Options, SimDevice
from armdrive.sim.world.arm import World
from kinematics.errors import suggestion

if TYPE_CHECKING:
    from armdrive.config.arm import ArmConfig


@dataclass(frozen=True, slots=True)
class TwinKind:
    """One kind of simulated device.

    `make(config, world, options)` builds it as it stands when its power has come; a saved one is
    made the same way and then recalls what it knew. `device` is its class, which tells what it is
    able to do.
    """

    title: str
    device: type[SimDevice]
    make: Callable[[ArmConfig, World, Options], SimDevice]
    options: tuple[Option, ...] = ()


def _teachmover() -> TwinKind:
    from armdrive.sim.teachmover.kind import KIND

    return KIND


def _robko01() -> TwinKind:
    from armdrive.sim.robko01.kind import KIND

    return KIND


def _armdroid() -> TwinKind:
    from armdrive.sim.armdroid.kind import KIND

    return KIND


def _grbl() -> TwinKind:
    from armdrive.sim.grbl.kind import KIND

    return KIND


def _mks() -> TwinKind:
    from armdrive.sim.mks.kind import KIND

    return KIND


def _cia402() -> TwinKind:
    from armdrive.sim.cia402.kind import KIND

    return KIND


TWINS: Mapping[str, Callable[[], TwinKind]] = MappingProxyType(
    {
        "teachmover": _teachmover,
        "robko01": _robko01,
        "armdroid": _armdroid,
        "grbl": _grbl,
        "mks": _mks,
        "cia402": _cia402,
    }
)
"""Every dialect that has a simulated device, by its name; the device is imported when asked for."""


def twin_kind(dialect: str) -> TwinKind:
    """Return the kind of device that speaks a dialect; `BadRequest` suggests the nearest name."""
    if dialect in TWINS:
        return TWINS[dialect]()
    hint = suggestion(dialect, TWINS)
    raise BadRequest(
        f"no simulated device speaks {dialect!r}; those that do speak {', '.join(TWINS)}{hint}"
    )
