"""Objects of a device as data: index, sub-index, name, type, access, unit, what it is at first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum

from firmware_protocol.canopen.cob import checked_node
from firmware_protocol.canopen.datatypes import DataType, Value
from firmware_protocol.canopen.sdo_messages import Place
from firmware_protocol.errors import BadField, LocalProtocolError, whole


class Access(Enum):
    """What may be done with an object, in the words of EDS files."""

    CONST = "const"
    RO = "ro"
    WO = "wo"
    RW = "rw"
    RWR = "rwr"
    """Read and written; in a PDO that the device transmits."""
    RWW = "rww"
    """Read and written; in a PDO that the device receives."""

    @property
    def readable(self) -> bool:
        """Whether it can be read over the bus."""
        return self is not Access.WO

    @property
    def writable(self) -> bool:
        """Whether it can be written over the bus."""
        return self not in (Access.CONST, Access.RO)


def one_line(field: str, value: object) -> str:
    """Return text that a line of an EDS file can hold, or raise `BadField`."""
    fits = isinstance(value, str) and value.isprintable() and value == value.strip()
    if not fits or not value or " ;" in str(value):
        raise BadField(field, value, "one line of text, without blanks around it and without ' ;'")
    return str(value)


@dataclass(frozen=True, slots=True)
class ObjectEntry:
    """One object, or one sub-index of a record.

    `unit` is in the drive's own words, since CiA 402 leaves position units to its factors.
    `adds_node`: the node's number is added to `default`, as COB-ids want it.
    """

    place: Place
    name: str
    type: DataType
    access: Access
    unit: str = ""
    default: Value | None = None
    mappable: bool = False
    adds_node: bool = False

    def __post_init__(self) -> None:
        one_line("name", self.name)
        if self.unit:
            one_line("unit", self.unit)
        if isinstance(self.default, str | bytes):
            self._check_text(self.default)
        if self.adds_node:
            whole("default", self.default, 0, 0xFFFF_FFFF)
        if self.default is not None:
            self.type.pack(self.default)

    def _check_text(self, default: str | bytes) -> None:
        if not default:
            raise BadField("default", default, "None where there is nothing")
        if isinstance(default, str):
            one_line("default", default)

    def initial(self, node: int) -> Value | None:
        """Return what the object is at first, on a node."""
        if self.adds_node and isinstance(self.default, int):
            return self.default + checked_node(node)
        return self.default


class Dictionary:
    """The objects of a device, in the order of their places. Raises `BadField` for two of one.

    `records` names the indices whose objects are sub-indices; one without is called like its first.
    """

    def __init__(
        self, entries: Iterable[ObjectEntry], records: Mapping[int, str] | None = None
    ) -> None:
        self._entries: dict[Place, ObjectEntry] = {}
        for entry in sorted(entries, key=lambda entry: (entry.place.index, entry.place.sub)):
            if entry.place in self._entries:
                raise BadField("place", str(entry.place), "of one object alone")
            self._entries[entry.place] = entry
        self._indices = frozenset(place.index for place in self._entries)
        self._records = {
            index: one_line("records", name)
            for index, name in (records or {}).items()
            if index in self._indices
        }
        for entry in self:
            if entry.place.sub:
                self._records.setdefault(entry.place.index, entry.name)

    def __iter__(self) -> Iterator[ObjectEntry]:
        return iter(self._entries.values())

    def __len__(self) -> int:
        return len(self._entries)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Dictionary):
            return NotImplemented
        return self._entries == other._entries and self._records == other._records

    __hash__ = None  # type: ignore[assignment]

    @property
    def indices(self) -> frozenset[int]:
        """The indices of all objects."""
        return self._indices

    @property
    def records(self) -> dict[int, str]:
        """The names of what has sub-indices."""
        return dict(self._records)

    def find(self, place: Place) -> ObjectEntry | None:
        """Return the object at a place; None where there is none."""
        return self._entries.get(place)

    def named(self, name: str) -> ObjectEntry:
        """Return the object of a name; raises `LocalProtocolError` unless there is just one."""
        found = [entry for entry in self if entry.name == name]
        if len(found) != 1:
            raise LocalProtocolError(f"{len(found)} objects are called {name!r}")
        return found[0]
