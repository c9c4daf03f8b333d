"""PDOs: their mapping, their set-up by a master, and their handling in a device.

A PDO carries the mapped objects one after the other, low byte first.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, TypeAlias

from firmware_protocol.canopen.objects import DataType, Dictionary, Place
from firmware_protocol.canopen.sdo import AbortCode
from firmware_protocol.canopen.services import Service, cob_id
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.fields import message
from firmware_protocol.frames import DATA_MAX, STANDARD_ID_MAX, Frame

# The `struct` codes of the types that a PDO can carry.
_CODES = {
    DataType.I8: "b",
    DataType.U8: "B",
    DataType.I16: "h",
    DataType.U16: "H",
    DataType.I32: "i",
    DataType.U32: "I",
}


@message()
class Mapped:
    """An object in a PDO: a whole number."""

    place: Place
    type: DataType

    def __post_init__(self) -> None:
        if self.type not in _CODES:
            raise BadField("type", self.type, "a whole number")

    @property
    def size(self) -> int:
        """Number of bytes."""
        return self.type.size or 0

    @property
    def word(self) -> int:
        """The entry in a mapping parameter: index, sub-index, bits."""
        return self.place.index << 16 | self.place.sub << 8 | 8 * self.size

    @classmethod
    def of(cls, word: int, dictionary: Dictionary) -> Mapped:
        """Decode a device's mapping entry. Raises `RemoteProtocolError`.

        The entry contains only the length, so the type comes from the dictionary.
        """
        place = Place(word >> 16, word >> 8 & 0xFF)
        entry = dictionary.find(place)
        if entry is None:
            raise RemoteProtocolError(f"{place} is mapped, and is no object of the dictionary")
        if entry.type not in _CODES or 8 * (entry.type.size or 0) != word & 0xFF:
            raise RemoteProtocolError(
                f"{place} is mapped with {word & 0xFF} bits; it is {entry.type.name}"
            )
        return cls(place, entry.type)


@dataclass(frozen=True, slots=True)
class Mapping:
    """The objects of a PDO, in order: at least one object, at most eight bytes."""

    entries: tuple[Mapped, ...]
    size: int = field(init=False, repr=False, compare=False)
    """Number of bytes in the PDO."""
    _codec: struct.Struct = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        codec = struct.Struct("<" + "".join(_CODES[entry.type] for entry in self.entries))
        if not 0 < codec.size <= DATA_MAX:
            raise BadField("entries", self.entries, f"objects of 1 to {DATA_MAX} bytes together")
        object.__setattr__(self, "size", codec.size)
        object.__setattr__(self, "_codec", codec)

    @property
    def places(self) -> tuple[Place, ...]:
        """The objects' places, in order."""
        return tuple(entry.place for entry in self.entries)

    @classmethod
    def of_objects(cls, dictionary: Dictionary, *places: Place) -> Mapping:
        """Map objects of a dictionary. Raises `BadField` for an object that cannot be mapped."""
        found = [dictionary.find(place) for place in places]
        for place, entry in zip(places, found, strict=True):
            if entry is None or not entry.mappable:
                raise BadField("places", str(place), "an object that can be mapped")
        return cls(tuple(Mapped(entry.place, entry.type) for entry in found if entry is not None))

    def pack(self, values: Sequence[int]) -> bytes:
        """Return a PDO's data for one value per entry. Raises `BadField`."""
        try:
            return self._codec.pack(*values)
        except struct.error:  # once more one by one, to name the invalid one
            pairs = zip(self.entries, values, strict=True)
            return b"".join(entry.type.pack(value) for entry, value in pairs)

    def unpack(self, data: bytes) -> tuple[Any, ...]:
        """Return a PDO's values. Raises `RemoteProtocolError` if it is too short.

        Bytes after the last entry are ignored, as CiA 301 requires.
        """
        if len(data) < self.size:
            raise RemoteProtocolError(f"length {len(data)} where the PDO has {self.size}")
        return self._codec.unpack_from(data)


# Setting up a device's PDO: a list of SDO writes, in the order that devices insist on.
#
#     disable (bit 31 of the COB-ID), entry count 0, entries, entry count, transmission, enable
#
# The writes are valid only in pre-operational. Until the last write succeeds, the PDO does not
# exist: after an incomplete list the drive ignores the PDO instead of misreading it.
# Source: CiA 301, PDO communication and mapping parameters.

# Bits of the COB-ID: the PDO does not exist; remote frames do not trigger it.
NOT_VALID, NO_REMOTE = 1 << 31, 1 << 30
# Transmission type: on every SYNC.
EVERY_SYNC = 1
# Transmission types: on events; a received PDO takes effect at once.
ON_EVENT = (254, 255)


class Direction(Enum):
    """Whether the device receives or transmits a PDO."""

    RECEIVED = "RPDO"
    TRANSMITTED = "TPDO"


# The first indices of the communication and of the mapping parameters.
PARAMETERS = {Direction.RECEIVED: (0x1400, 0x1600), Direction.TRANSMITTED: (0x1800, 0x1A00)}
# The indices of all PDO parameters.
PDO_PARAMETERS = range(0x1400, 0x1C00)
# The PDOs with predefined COB-IDs.
PDO_SERVICES = {
    Direction.RECEIVED: (Service.RPDO1, Service.RPDO2, Service.RPDO3, Service.RPDO4),
    Direction.TRANSMITTED: (Service.TPDO1, Service.TPDO2, Service.TPDO3, Service.TPDO4),
}
_COB, _TRANSMISSION = 1, 2  # sub-indices


@message()
class Write:
    """A write to one object. If it is a constant, `equals` are values that serve as well."""

    place: Place
    type: DataType
    value: int
    equals: tuple[int, ...] = ()

    @property
    def data(self) -> bytes:
        """The bytes to write."""
        return self.type.pack(self.value)


def switched_off(direction: Direction, number: int, node: int) -> Write:
    """Return the write that disables one of the first four PDOs of a direction."""
    cob = cob_id(PDO_SERVICES[direction][number - 1], node) | NOT_VALID
    return Write(Place(PARAMETERS[direction][0] + number - 1, _COB), DataType.U32, cob)


def first_pdo(direction: Direction, node: int, mapping: Mapping) -> tuple[Write, ...]:
    """Return the writes that set up a device's first PDO of a direction, for every SYNC.

    The device's times stay as they are. If the transmission type of a received PDO is constant, it
    may take effect on events too.
    """
    communication, mapped = PARAMETERS[direction]
    at_once = ON_EVENT if direction is Direction.RECEIVED else ()
    cob = cob_id(PDO_SERVICES[direction][0], node)
    return (
        switched_off(direction, 1, node),
        Write(Place(mapped, 0), DataType.U8, 0),
        *(
            Write(Place(mapped, sub), DataType.U32, entry.word)
            for sub, entry in enumerate(mapping.entries, 1)
        ),
        Write(Place(mapped, 0), DataType.U8, len(mapping.entries)),
        Write(Place(communication, _TRANSMISSION), DataType.U8, EVERY_SYNC, at_once),
        Write(Place(communication, _COB), DataType.U32, cob),
    )


# The device's end of PDOs: the configuration in its objects, sending, and receiving.
#
# No clock and no I/O: the owner transmits the frames. The device transmits a PDO at every SYNC or
# never: no program of ours asks for one on events, or at every second SYNC.
# Source: CiA 301, PDO communication and mapping parameters.

SYNCHRONOUS_MOST = 240
ENTRIES_MOST = 8
_REMOTE_ALONE = range(241, 254)


@dataclass(slots=True)
class DevicePdo:
    """A configured PDO and its state."""

    can_id: int
    mapping: Mapping
    transmission: int
    data: bytes = b""
    """Received data that waits for a SYNC."""

    @property
    def synchronous(self) -> bool:
        """Whether the PDO is sent, or takes effect, on a SYNC."""
        return self.transmission <= SYNCHRONOUS_MOST


# Returns an object's value at a given time.
Reader: TypeAlias = Callable[[float], int]


class DevicePdos:
    """The configured PDOs. `value` returns an object's value; `reader` returns its reader.

    `say` transmits a frame; `act` receives the contents of a PDO when they take effect.
    """

    def __init__(
        self,
        dictionary: Dictionary,
        value: Callable[[Place], int],
        reader: Callable[[Place], Reader],
        act: Callable[[Sequence[tuple[Place, int]], float], None],
        say: Callable[[Frame], None],
    ) -> None:
        self._dictionary, self._value = dictionary, value
        self._reader, self._act, self._say = reader, act, say
        self._received: dict[int, DevicePdo] = {}
        self._transmitted: list[tuple[DevicePdo, list[Reader]]] = []
        self.rebuild()

    @property
    def received(self) -> Collection[int]:
        """The CAN ids of the received PDOs."""
        return self._received.keys()

    def rebuild(self) -> None:
        """Read the configuration from the objects again."""
        self._received = {pdo.can_id: pdo for pdo in self._described(Direction.RECEIVED)}
        self._transmitted = [
            (pdo, [self._reader(place) for place in pdo.mapping.places])
            for pdo in self._described(Direction.TRANSMITTED)
            if pdo.synchronous
        ]

    def sync(self, now_s: float) -> None:
        """Send the drive's present values, then apply the PDOs received before this SYNC."""
        # In this order: what is sent was true at the SYNC, before any new target counts.
        for pdo, readers in self._transmitted:
            data = pdo.mapping.pack([read(now_s) for read in readers])
            self._say(Frame(pdo.can_id, data))
        for pdo in self._received.values():
            if pdo.synchronous and pdo.data:
                data, pdo.data = pdo.data, b""
                self._apply(pdo, data, now_s)

    def take(self, frame: Frame, now_s: float) -> bool:
        """Apply a received PDO, now or on the next SYNC; return False if it is too short."""
        pdo = self._received[frame.can_id]
        if len(frame.data) < pdo.mapping.size:
            return False
        if pdo.synchronous:
            pdo.data = frame.data
        else:
            self._apply(pdo, frame.data, now_s)
        return True

    def _apply(self, pdo: DevicePdo, data: bytes, now_s: float) -> None:
        values = pdo.mapping.unpack(data)
        self._act([*zip(pdo.mapping.places, values, strict=True)], now_s)

    # Checks for writes to the PDO parameters.

    def refusal(self, place: Place, value: int) -> AbortCode | None:
        """Return the abort code for writing a value to a PDO parameter; None if it is valid."""
        number = place.index & 0x1FF
        received = place.index < PARAMETERS[Direction.TRANSMITTED][0]
        base, _ = PARAMETERS[Direction.RECEIVED if received else Direction.TRANSMITTED]
        if place.index - number == base:
            return _refused_communication(place.sub, value)
        if not self._value(Place(base + number, _COB)) & NOT_VALID:
            return AbortCode.DEVICE_STATE
        if not place.sub:
            return self._refused_count(place.index, value)
        if self._value(Place(place.index, 0)):
            return AbortCode.DEVICE_STATE
        return self._refused_entry(value, received=received)

    def _refused_count(self, index: int, count: int) -> AbortCode | None:
        if count > ENTRIES_MOST:
            return AbortCode.PDO_TOO_LONG
        words = [self._value(Place(index, sub)) for sub in range(1, count + 1)]
        if not all(words):
            return AbortCode.NOT_MAPPABLE
        bits = sum(word & 0xFF for word in words)
        return AbortCode.PDO_TOO_LONG if bits > 8 * DATA_MAX else None

    def _refused_entry(self, word: int, *, received: bool) -> AbortCode | None:
        try:
            place = Mapped.of(word, self._dictionary).place
        except (BadField, RemoteProtocolError):
            return AbortCode.NO_OBJECT if word else None
        entry = self._dictionary.find(place)
        fits = entry is not None and entry.mappable
        if fits and entry is not None:
            fits = entry.access.writable if received else entry.access.readable
        return None if fits else AbortCode.NOT_MAPPABLE

    def _described(self, direction: Direction) -> Iterator[DevicePdo]:
        """Yield the valid PDOs of a direction, as configured in the objects."""
        for number in range(len(PDO_SERVICES[direction])):
            communication, mapping = (base + number for base in PARAMETERS[direction])
            cob = self._value(Place(communication, _COB))
            transmission = self._value(Place(communication, _TRANSMISSION))
            count = self._value(Place(mapping, 0))
            if not cob or cob & NOT_VALID or not count:
                continue
            words = [self._value(Place(mapping, sub)) for sub in range(1, count + 1)]
            try:
                mapped = Mapping(tuple(Mapped.of(word, self._dictionary) for word in words))
            except (BadField, RemoteProtocolError):  # maps objects that this drive lacks
                continue
            yield DevicePdo(cob & STANDARD_ID_MAX, mapped, transmission)


def _refused_communication(sub: int, value: int) -> AbortCode | None:
    remote = sub == _TRANSMISSION and value in _REMOTE_ALONE
    nameless = sub == _COB and not value & STANDARD_ID_MAX
    return AbortCode.VALUE if remote or nameless else None
