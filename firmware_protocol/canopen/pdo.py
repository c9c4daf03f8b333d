"""What a PDO carries: a mapping of objects, packed one behind the other, the low byte first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from firmware_protocol.canopen.datatypes import DataType, Value
from firmware_protocol.canopen.objects import Dictionary
from firmware_protocol.canopen.sdo_messages import Place
from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.frames import DATA_MAX


@dataclass(frozen=True, slots=True)
class Mapped:
    """An object in a PDO. It is one of whole bytes here: no BOOLEAN, nothing of varying length."""

    place: Place
    type: DataType

    def __post_init__(self) -> None:
        bits = self.type.bits if isinstance(self.type, DataType) else None
        if bits is None or bits % 8:
            raise BadField("type", self.type, "a type of whole bytes and of fixed length")

    @property
    def size(self) -> int:
        """How many bytes it has."""
        return self.type.size or 0

    @property
    def word(self) -> int:
        """The entry of a mapping parameter: index, sub-index, bits."""
        return self.place.index << 16 | self.place.sub << 8 | 8 * self.size

    @classmethod
    def of(cls, word: int, dictionary: Dictionary) -> Mapped:
        """Read an entry that a device told; raises `RemoteProtocolError`.

        The entry tells the length alone, so the dictionary has to tell the type.
        """
        whole("word", word, 0, 0xFFFF_FFFF)
        place = Place(word >> 16, word >> 8 & 0xFF)
        entry = dictionary.find(place)
        if entry is None:
            raise RemoteProtocolError(f"{place} is mapped, and is no object of the dictionary")
        if entry.type.bits != word & 0xFF or entry.type.bits == 1:
            raise RemoteProtocolError(
                f"{place} is mapped with {word & 0xFF} bits; it is {entry.type.name}"
            )
        return cls(place, entry.type)


@dataclass(frozen=True, slots=True)
class Mapping:
    """The objects of a PDO, in order: at least one, and at most eight bytes."""

    entries: tuple[Mapped, ...]
    size: int = field(init=False, repr=False, compare=False)
    """How many bytes the PDO has."""
    _parts: tuple[tuple[DataType, slice], ...] = field(init=False, repr=False, compare=False)
    """The type of each entry and where its bytes are: worked out once, and not with every PDO."""

    def __post_init__(self) -> None:
        known = isinstance(self.entries, tuple)
        parts, at = [], 0
        for entry in self.entries if known else ():
            parts.append((entry.type, slice(at, at + entry.size)))
            at += entry.size
        if not 0 < at <= DATA_MAX:
            raise BadField("entries", self.entries, f"objects of 1 to {DATA_MAX} bytes together")
        object.__setattr__(self, "size", at)
        object.__setattr__(self, "_parts", tuple(parts))

    @classmethod
    def of_objects(cls, dictionary: Dictionary, *places: Place) -> Mapping:
        """Map objects of a dictionary. Raises `BadField` for one that cannot be."""
        found = [dictionary.find(place) for place in places]
        for place, entry in zip(places, found, strict=True):
            if entry is None or not entry.mappable:
                raise BadField("places", str(place), "an object that can be mapped")
        return cls(tuple(Mapped(entry.place, entry.type) for entry in found if entry is not None))

    def pack(self, values: Sequence[Value]) -> bytes:
        """Return the data of one PDO, of a value for each entry. Raises `BadField`."""
        if len(values) != len(self.entries):
            raise BadField("values", values, f"{len(self.entries)} of them")
        pairs = zip(self._parts, values, strict=True)
        return b"".join([kind.pack(value) for (kind, _), value in pairs])

    def unpack(self, data: bytes) -> tuple[Value, ...]:
        """Return the values of one PDO; raises `RemoteProtocolError` where it is too short.

        What is behind the last entry is left out, as CiA 301 wants it.
        """
        if len(data) < self.size:
            raise RemoteProtocolError(f"{len(data)} bytes where the PDO has {self.size}")
        return tuple([kind.unpack(data[where]) for kind, where in self._parts])
