"""The drivers of controllers: one subpackage per dialect, with its registry entry, a `Dialect`.

Entries are light, because every command reads all of them. The driver and the tools of a dialect
are imported on demand. What several drivers share:

    controller   the interface of a driver, its stop bounds, and the delays that all allow for
    exchange     scripts: send a message, wait for its answer
    recognition  probes, their risk and order, and how answers identify the device
    words        messages in words
    speed_table  speed settings of a device and their step rates
    bus/         what drives on a CAN bus share
"""

from __future__ import annotations

import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from armdrive.abilities import Abilities, Torque

if TYPE_CHECKING:
    from armdrive.config.arm import ArmConfig
    from armdrive.dialects.bus.tools import BusTools
    from armdrive.dialects.bus.words import FrameDescriber
    from armdrive.dialects.controller import Controller
    from armdrive.dialects.recognition import Recognition
    from armdrive.dialects.words import Describer
    from firmware_protocol.frames import Unpacker


def on_demand(place: str) -> Callable[[], Any]:
    """Return a function that imports what stands at a place, `package.module:NAME`."""
    return partial(pkgutil.resolve_name, place)


@dataclass(frozen=True, slots=True, eq=False)
class Driver:
    """What drives an arm.

    `settings` is the class of the arm file's section with the dialect's name. `controller` creates
    the controller from the dialect's abilities and an arm. `frames` creates the decoder of a bus's
    frames, and `frame_ids` returns the ids of those that the controller receives, by its settings.
    """

    settings: type[Any]
    controller: Callable[[Abilities, ArmConfig], Controller]
    frames: Callable[[], Unpacker] | None = None
    frame_ids: Callable[[Any], tuple[int, ...]] = lambda _settings: ()


@dataclass(frozen=True, slots=True, eq=False)
class DeviceTools:
    """What finds a device, sets it up and describes its traffic; driving an arm needs none of it.

    `talk` describes messages in words. `recognition` is None for a dialect on a bus, which is
    surveyed instead: `bus` surveys its drives and sets them up, and `describer` creates one that
    describes single frames. `pendant` is the class of programs in an arm's own memory.
    """

    talk: Describer
    recognition: Recognition | None = None
    bus: BusTools | None = None
    describer: Callable[[], FrameDescriber] | None = None
    pendant: type[Any] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Language:
    """The protocol of drives on a CAN bus; `silence` says what a bus without traffic means."""

    name: str
    title: str
    tools: Callable[[], DeviceTools]
    silence: str

    def describer(self) -> FrameDescriber:
        """Create a describer of single frames."""
        create = self.tools().describer
        if create is None:
            raise LookupError(f"no describer of {self.title}")
        return create()


@dataclass(frozen=True, slots=True, eq=False)
class Dialect:
    """One dialect; `preset` is the arm that uses it by default.

    `raise_dtr` is the default for opening its port: a board with native USB is mute without it.
    `language` means that it is spoken on a CAN bus: its port is an adapter, and `baud` the bit rate
    of the bus.
    """

    name: str
    title: str
    preset: str
    baud: int
    torque: Torque
    abilities: Abilities
    driver: Callable[[], Driver]
    tools: Callable[[], DeviceTools]
    raise_dtr: bool = False
    quick_stop: str = "The motors' power switch stops faster; the arm then sags."
    language: Language | None = None

    @property
    def bus(self) -> BusTools | None:
        """How the drives on a bus are surveyed and set up; None without a bus."""
        return self.tools().bus if self.can else None

    @property
    def pendant(self) -> type[Any] | None:
        """The programs that the arm keeps in its own memory; None if it has no such memory."""
        return self.tools().pendant if self.abilities.program_rows else None

    @property
    def can(self) -> bool:
        """Whether it is spoken on a CAN bus."""
        return self.language is not None

    def settings(self) -> type[Any]:
        """Return the class of the dialect's own section in an arm file."""
        return self.driver().settings

    def controller(self, config: ArmConfig) -> Controller:
        """Create the controller of an arm. Raises `ArmError` if its settings do not fit."""
        return self.driver().controller(self.abilities, config)

    def abilities_with(self, config: ArmConfig) -> Abilities:
        """Return what the device can do with an arm's settings. Raises as `controller` does."""
        return self.controller(config).abilities
