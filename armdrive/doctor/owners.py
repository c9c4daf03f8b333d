"""Who has a port, and which arm files it belongs to: asked of files and local sockets alone."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from armdrive import places
from armdrive.errors import ArmError
from armdrive.holder import ask_holder
from armdrive.transports.ports import device_of
from armdrive.transports.refusals import NoSuchPort


@dataclass(frozen=True, slots=True)
class Naming:
    """Which port an arm file names, by a USB serial number if it gives one, else by its name.

    `error` says why a file cannot be used.
    """

    arm: str
    port: str = ""
    usb_serial: str = ""
    error: str = ""

    def find(self) -> str:
        """Return the present name of the arm's port. Raises `NoSuchPort` as connecting would."""
        return device_of(self.usb_serial, self.port) if self.usb_serial else self.port


@dataclass(frozen=True, slots=True)
class Owner:
    """An arm file that a port belongs to, and by what: a name, or the number of its adapter."""

    arm: str
    usb_serial: str = ""

    def __str__(self) -> str:
        by = f" (by the USB serial number {self.usb_serial})" if self.usb_serial else ""
        return f"{self.arm}{by}"


def arm_files() -> tuple[Naming, ...]:
    """Return the ports that the arm files name, and the files that cannot be read."""
    return tuple(map(_naming, sorted(places.arm_files().glob("*.toml"))))


def _naming(path: Path) -> Naming:
    from armdrive.armfile import load_arm_file

    try:
        wire = load_arm_file(path).connection
    except ArmError as error:
        return Naming(path.stem, error=str(error))
    return Naming(path.stem, wire.port, wire.usb_serial)


def owners_of(port: str, namings: Iterable[Naming]) -> tuple[Owner, ...]:
    """Return the arm files that a port belongs to, under whichever of its names."""
    found = []
    for each in namings:
        with contextlib.suppress(NoSuchPort):
            name = each.find()
            if name and same_port(name, port):
                found.append(Owner(each.arm, each.usb_serial))
    return tuple(found)


def strangers_to(port: str, namings: Iterable[Naming]) -> tuple[Naming, ...]:
    """Return the arm files that have a port's name, but want an adapter that it is not."""
    namings = [each for each in namings if each.usb_serial and each.port]
    owners = [owner.arm for owner in owners_of(port, namings)]
    return tuple(each for each in namings if same_port(each.port, port) and each.arm not in owners)


def same_port(one: str, other: str) -> bool:
    """Tell whether two names lead to one port."""
    if "://" in one or "://" in other:
        return one == other
    return os.path.realpath(one) == os.path.realpath(other)


def held_by_armdrive(port: str, arms: Iterable[str] = ()) -> str:
    """Return the arm as which an armdrive program holds a port; empty where none does."""
    for name in (port, os.path.realpath(port), *arms):
        with contextlib.suppress(ArmError):
            told = ask_holder(name, "status")
            return str(told.get("arm") or name)
    return ""
