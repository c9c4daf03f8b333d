"""What a dialect states about itself: one `Dialect` each, the `ENTRY` of its subpackage.

An entry is light, since every command of the command line reads all of them. What drives an arm,
and what looks at its device, are imported when they are asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from armdrive.abilities import Abilities, Torque

if TYPE_CHECKING:
    from armdrive.config.arm import ArmConfig
    from armdrive.dialects.bus.tools import BusTools
    from armdrive.dialects.bus.words import Ear
    from armdrive.dialects.controller import Controller
    from armdrive.dialects.pendant import PendantTools
    from armdrive.dialects.recognition import Recognition
    from armdrive.dialects.words import Describer
    from firmware_protocol.frames import Unpacker


@dataclass(frozen=True, slots=True, eq=False)
class Driver:
    """What drives an arm.

    `settings` is the class of what an arm file says in the section of the dialect's name.
    `controller` makes the driver's end from what the dialect is able to do and an arm. `frames`
    makes what reads the frames of a bus out of the bytes of its link.
    """

    settings: type[Any]
    controller: Callable[[Abilities, ArmConfig], Controller]
    frames: Callable[[], Unpacker] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class DeviceTools:
    """What finds a device, sets it up and reads what it says; driving an arm needs none of it.

    `talk` puts what passes into words. `recognition` is None where the dialect is spoken on a bus,
    which is surveyed instead: `bus` surveys its drives and sets them up, and `ear` makes what hears
    what they say. `pendant` reads and writes the program of an arm that keeps one in a memory of
    its own.
    """

    talk: Describer
    recognition: Recognition | None = None
    bus: BusTools | None = None
    ear: Callable[[], Ear] | None = None
    pendant: PendantTools[Any] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Language:
    """What the drives on a CAN bus speak; `silence` says what it means that nothing passes."""

    name: str
    title: str
    tools: Callable[[], DeviceTools]
    silence: str

    def ear(self) -> Ear:
        """Make what hears it."""
        made = self.tools().ear
        if made is None:
            raise LookupError(f"nothing hears {self.title}")
        return made()


@dataclass(frozen=True, slots=True, eq=False)
class Dialect:
    """One dialect: `preset` is the arm that speaks it where no arm file says otherwise.

    `raise_dtr` is how its port is opened by default: a board with native USB is mute without it.
    `language` says that it is spoken on a CAN bus: its port is an adapter's, and `baud` the bus's
    bit rate.
    """

    name: str
    title: str
    preset: str
    baud: int
    raise_dtr: bool
    quick_stop: str
    torque: Torque
    abilities: Abilities
    driver: Callable[[], Driver]
    tools: Callable[[], DeviceTools]
    language: Language | None = None

    @property
    def bus(self) -> BusTools | None:
        """How the drives on a bus are surveyed and set up; None where there is no bus."""
        return self.tools().bus if self.can else None

    @property
    def pendant(self) -> PendantTools[Any] | None:
        """How the arm's own program is read and written; None where it keeps none."""
        return self.tools().pendant if self.abilities.pendant else None

    @property
    def can(self) -> bool:
        """Whether it is spoken on a CAN bus."""
        return self.language is not None

    def settings(self) -> type[Any]:
        """Return the class of the dialect's own section in an arm file."""
        return self.driver().settings

    def controller(self, config: ArmConfig) -> Controller:
        """Make the driver's end for an arm. Raises `ArmError` where its settings do not fit it."""
        return self.driver().controller(self.abilities, config)

    def abilities_with(self, config: ArmConfig) -> Abilities:
        """Return what the device can do with an arm's settings. Raises as `controller` does."""
        return self.controller(config).abilities
