"""The objects of a simulated CiA 402 drive: its EDS, and their values."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import replace
from functools import cache
from importlib.resources import files

from armdrive.sim.world.saved import unfit
from firmware_protocol.canopen import (
    SERIAL_NUMBER,
    Access,
    Dictionary,
    ObjectStore,
    Place,
    read_eds,
)
from firmware_protocol.errors import ProtocolError

EDS = "cia402.eds"
# The indices that a reset of the communication restores.
COMMUNICATION = range(0x1000, 0x2000)


@cache
def eds_text() -> str:
    """Return the EDS file of the drives."""
    return (files("armdrive.sim.cia402") / EDS).read_text(encoding="ascii")


@cache
def dictionary() -> Dictionary:
    """Return all objects of a drive."""
    return read_eds(eds_text())


def varied(
    missing: Container[int], changed: Mapping[Place, int], constant: Container[Place]
) -> Dictionary:
    """Return the objects of a drive: some missing, with other defaults, or constant."""
    entries = [
        replace(
            entry,
            default=changed.get(entry.place, entry.default),
            access=Access.CONST if entry.place in constant else entry.access,
        )
        for entry in dictionary()
        if entry.place.index not in missing
    ]
    return Dictionary(entries)


class DriveObjects:
    """The values of one drive's objects; `serial` is its serial number, if its EDS has one."""

    def __init__(self, dictionary: Dictionary, node: int, serial: int) -> None:
        self.dictionary = dictionary
        self._serial = serial
        self.renew(node)

    def renew(self, node: int) -> None:
        """Reset all objects to their defaults, for a node with this number."""
        self.node = node
        self.store = ObjectStore(self.dictionary, node)
        self.keep(SERIAL_NUMBER, self._serial)

    def renew_communication(self, node: int) -> None:
        """Reset the objects below 2000 to their defaults."""
        before = self.store
        self.renew(node)
        for entry in self.dictionary:
            value = before.value(entry.place)
            if value is not None and entry.place.index not in COMMUNICATION:
                self.store.set(entry.place, value)

    def number_of(self, place: Place, default: int = 0) -> int:
        """Return an object's number; the default if it has none or does not exist."""
        return self.store.number(place, default)

    def keep(self, place: Place, value: int) -> None:
        """Set an object's number, if the drive has that object."""
        if entry := self.dictionary.find(place):
            self.store.put(entry, value)

    def changed(self, apart: Container[Place]) -> dict[str, str]:
        """Return the values that differ from the defaults, encoded as on the bus, to be saved."""
        changed: dict[str, str] = {}
        for entry in self.dictionary:
            place, value = entry.place, self.store.value(entry.place)
            if place not in apart and value is not None and value != entry.initial(self.node):
                changed[f"{place.index:04X}:{place.sub:02X}"] = entry.type.pack(value).hex()
        return changed

    def recall(self, saved: Mapping[str, str]) -> None:
        """Restore what `changed` returned. Raises `StateFileError`."""
        for key, text in saved.items():
            try:
                index, sub = (int(part, 16) for part in key.split(":"))
                place = Place(index, sub)
                entry = self.dictionary.find(place)
                value = None if entry is None else entry.type.unpack(bytes.fromhex(text))
            except (ProtocolError, ValueError):
                value = None
            if value is None:
                raise unfit(f"a saved drive's object {key:.20} cannot be {text!r:.60}")
            self.store.set(place, value)
