"""PDOs: what they carry, how a master sets them up, and when a device sends and obeys them.

One carries a mapping of objects, packed one behind the other, the low byte first.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeAlias

from firmware_protocol.canopen.cob import Service, checked_node, cob_id
from firmware_protocol.canopen.objects import DataType, Dictionary, Place, Value
from firmware_protocol.canopen.sdo import AbortCode
from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.frames import DATA_MAX, STANDARD_ID_MAX, Frame


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


# How a PDO of a device is set up: the list of SDO writes, in the order that devices insist on.
#
#     disable (bit 31 of its COB-ID), no entries, the entries, how many, when it is sent, enable
#
# It may be written in the state pre-operational alone. Until the last write has been taken, the PDO
# does not exist: a list that breaks off leaves the drive deaf to it, not misled by it.
# Source: CiA 301, PDO communication and mapping parameters.

PDO_MAX = 512
"""How many PDOs of a direction a device can have; the first four have COB-IDs of their own."""
NOT_VALID, NO_REMOTE = 1 << 31, 1 << 30
"""Bits of the COB-ID: the PDO does not exist; it is not sent upon a remote frame."""
EVERY_SYNC, ON_EVENT = 1, 255
"""Transmission types: with every SYNC; when the device profile says so."""

_RESERVED = range(241, 252)


class Direction(Enum):
    """Whether the device receives or transmits it."""

    RECEIVED = "RPDO"
    TRANSMITTED = "TPDO"


PARAMETERS = {Direction.RECEIVED: (0x1400, 0x1600), Direction.TRANSMITTED: (0x1800, 0x1A00)}
"""Where the objects of communication and of mapping begin."""
PDO_PARAMETERS = range(0x1400, 0x1C00)
"""Indices of all of them."""
PDO_SERVICES = {
    Direction.RECEIVED: (Service.RPDO1, Service.RPDO2, Service.RPDO3, Service.RPDO4),
    Direction.TRANSMITTED: (Service.TPDO1, Service.TPDO2, Service.TPDO3, Service.TPDO4),
}
"""Those that have COB-IDs of their own."""
_COB, _TRANSMISSION, _INHIBIT, _EVENT = 1, 2, 3, 5  # sub-indices


@dataclass(frozen=True, slots=True)
class Write:
    """One object to be written, with what."""

    place: Place
    type: DataType
    value: int

    @property
    def data(self) -> bytes:
        """The bytes to download."""
        return self.type.pack(self.value)


def switched_off(direction: Direction, number: int, node: int) -> Write:
    """Return what has one of the first four PDOs of a direction not exist."""
    cob = cob_id(PDO_SERVICES[direction][number - 1], node) | NOT_VALID
    return Write(Place(PARAMETERS[direction][0] + number - 1, _COB), DataType.U32, cob)


@dataclass(frozen=True, slots=True)
class PdoSetup:
    """A PDO as it is to be. `number` counts from 1.

    `transmission` is 0 to 240 (at every so many-th SYNC; 0 at the next after a change) or 252 to
    255. `inhibit_100us` is the least time between two, `event_ms` the longest (of a received PDO:
    after which its absence is an error); None leaves the device's own. `can_id` defaults to the
    one that CiA 301 gives to the first four.
    """

    direction: Direction
    number: int
    node: int
    mapping: Mapping
    transmission: int = EVERY_SYNC
    inhibit_100us: int | None = None
    event_ms: int | None = None
    can_id: int | None = None
    no_remote: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.direction, Direction):
            raise BadField("direction", self.direction, "a Direction")
        whole("number", self.number, 1, PDO_MAX)
        checked_node(self.node)
        whole("transmission", self.transmission, 0, 255)
        if self.transmission in _RESERVED:
            raise BadField("transmission", self.transmission, "0 to 240 or 252 to 255")
        for name in ("inhibit_100us", "event_ms"):
            if getattr(self, name) is not None:
                whole(name, getattr(self, name), 0, 0xFFFF)
        if self.inhibit_100us is not None and self.direction is Direction.RECEIVED:
            raise BadField("inhibit_100us", self.inhibit_100us, "None, where the device receives")
        if self.can_id is None and self.number > len(PDO_SERVICES[self.direction]):
            raise BadField("can_id", self.can_id, "given, for a PDO behind the fourth")
        if self.can_id is not None:
            whole("can_id", self.can_id, 1, STANDARD_ID_MAX)

    @property
    def frame_id(self) -> int:
        """The id of its frames."""
        if self.can_id is not None:
            return self.can_id
        return cob_id(PDO_SERVICES[self.direction][self.number - 1], self.node)

    @property
    def writes(self) -> tuple[Write, ...]:
        """What is written, in this order."""
        communication, mapping = (base + self.number - 1 for base in PARAMETERS[self.direction])
        cob = self.frame_id | NO_REMOTE * self.no_remote
        entries = self.mapping.entries
        return (
            Write(Place(communication, _COB), DataType.U32, cob | NOT_VALID),
            Write(Place(mapping, 0), DataType.U8, 0),
            *(
                Write(Place(mapping, sub), DataType.U32, entry.word)
                for sub, entry in enumerate(entries, 1)
            ),
            Write(Place(mapping, 0), DataType.U8, len(entries)),
            Write(Place(communication, _TRANSMISSION), DataType.U8, self.transmission),
            *self._times(communication),
            Write(Place(communication, _COB), DataType.U32, cob),
        )

    def _times(self, communication: int) -> tuple[Write, ...]:
        times = ((_INHIBIT, self.inhibit_100us), (_EVENT, self.event_ms))
        return tuple(
            Write(Place(communication, sub), DataType.U16, value)
            for sub, value in times
            if value is not None
        )


# A device's end of PDOs: what its objects make of them, when each is sent and acted on.
#
# No clock and no wire: its owner hands times in, in seconds, and frames out.
# Source: CiA 301, PDO communication and mapping parameters.

SYNCHRONOUS_MOST = 240
AT_CHANGE = 0
"""The transmission type of what is sent at the SYNC behind a change."""
ENTRIES_MOST = 8
_REMOTE_ALONE = range(241, 254)
_INHIBIT_S, _EVENT_S = 1e-4, 1e-3


@dataclass(slots=True)
class DevicePdo:
    """One that exists, and where it stands."""

    can_id: int
    mapping: Mapping
    transmission: int
    inhibit_s: float = 0.0
    event_s: float = 0.0
    places: tuple[Place, ...] = field(init=False)
    beats: int = 0
    """How many SYNCs have passed since it was sent."""
    data: bytes = b""
    """What came, and waits for the SYNC; or what was sent last."""
    due_s: float = math.inf
    """When its event timer has it sent."""
    free_s: float = -math.inf
    """When it may be sent again."""
    size: int = field(init=False)
    synchronous: bool = field(init=False)
    """Whether it goes by SYNC."""
    _codec: struct.Struct = field(init=False)

    def __post_init__(self) -> None:
        self.places = tuple(entry.place for entry in self.mapping.entries)
        self.size = self.mapping.size
        self.synchronous = self.transmission <= SYNCHRONOUS_MOST
        self._codec = struct.Struct("<" + "".join(map(_code, self.mapping.entries)))

    def pack(self, values: Sequence[int]) -> bytes:
        """Return the data of it."""
        return self._codec.pack(*values)

    def unpack(self, data: bytes) -> list[tuple[Place, int]]:
        """Return the objects and their values of data that is long enough."""
        return [*zip(self.places, self._codec.unpack_from(data), strict=True)]


Reader: TypeAlias = Callable[[float], int]
"""Returns what an object is at a moment."""
_Transmitted: TypeAlias = tuple[DevicePdo, list[Reader]]


class DevicePdos:
    """The PDOs that exist. `value` is what an object holds; `reader` finds out how to read it.

    `say` brings a frame to the bus; `act` is handed what a PDO has brought, once that is acted on.
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
        self._by_sync: list[_Transmitted] = []
        self._by_event: list[_Transmitted] = []
        self.rebuild()

    @property
    def received(self) -> Collection[int]:
        """The ids of the frames that carry them to the drive."""
        return self._received.keys()

    def rebuild(self) -> None:
        """Read the objects again."""
        self._received = {pdo.can_id: pdo for pdo in self._described(Direction.RECEIVED)}
        self._by_sync, self._by_event = [], []
        for pdo in self._described(Direction.TRANSMITTED):
            readers = [self._reader(place) for place in pdo.places]
            (self._by_sync if pdo.synchronous else self._by_event).append((pdo, readers))

    # When they are sent, and acted on.

    @property
    def due_s(self) -> float:
        """When the next one is to be sent by its timer."""
        return min((pdo.due_s for pdo, _ in self._by_event), default=math.inf)

    def sync(self, now_s: float) -> None:
        """Tell how the drive stands at this moment, and only then do what came before it."""
        for pdo, readers in self._by_sync:
            self._send_in_turn(pdo, pdo.pack([read(now_s) for read in readers]), now_s)
        for pdo in self._received.values():
            if pdo.synchronous and pdo.data:
                data, pdo.data = pdo.data, b""
                self._act(pdo.unpack(data), now_s)

    def take(self, frame: Frame, now_s: float) -> bool:
        """Take what a frame brings, now or at the next SYNC; False where it is too short."""
        pdo = self._received[frame.can_id]
        if len(frame.data) < pdo.size:
            return False
        if pdo.synchronous:
            pdo.data = frame.data
        else:
            self._act(pdo.unpack(frame.data), now_s)
        return True

    def tell_changes(self, now_s: float) -> None:
        """Send those that go by themselves, where something has changed or their time has come."""
        for pdo, readers in self._by_event:
            data = pdo.pack([read(now_s) for read in readers])
            if pdo.free_s <= now_s and (data != pdo.data or pdo.due_s <= now_s):
                self._send(pdo, data, now_s)
            elif data != pdo.data:
                pdo.due_s = min(pdo.due_s, pdo.free_s)

    def _send_in_turn(self, pdo: DevicePdo, data: bytes, now_s: float) -> None:
        pdo.beats += 1
        if pdo.transmission == AT_CHANGE and data == pdo.data:
            return
        if pdo.beats >= pdo.transmission:
            pdo.beats = 0
            self._send(pdo, data, now_s)

    def _send(self, pdo: DevicePdo, data: bytes, now_s: float) -> None:
        self._say(Frame(pdo.can_id, data))
        pdo.data = data
        pdo.free_s = now_s + pdo.inhibit_s
        if not pdo.synchronous:
            pdo.due_s = max(now_s + pdo.event_s, pdo.free_s) if pdo.event_s else math.inf

    # What may be written into the objects that describe them.

    def refusal(self, place: Place, value: int) -> AbortCode | None:
        """Return why an object of these may not become a value; None where it may."""
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
        """Give those of a direction that the objects describe, and that this drive can have."""
        for number in range(len(PDO_SERVICES[direction])):
            communication, mapping = (base + number for base in PARAMETERS[direction])
            cob, transmission, inhibit, event = (
                self._value(Place(communication, sub))
                for sub in (_COB, _TRANSMISSION, _INHIBIT, _EVENT)
            )
            count = self._value(Place(mapping, 0))
            if not cob or cob & NOT_VALID or not count:
                continue
            words = [self._value(Place(mapping, sub)) for sub in range(1, count + 1)]
            try:
                mapped = Mapping(tuple(Mapped.of(word, self._dictionary) for word in words))
            except (BadField, RemoteProtocolError):  # as shipped it maps what this drive lacks
                continue
            can_id = cob & STANDARD_ID_MAX
            yield DevicePdo(can_id, mapped, transmission, inhibit * _INHIBIT_S, event * _EVENT_S)


def _code(entry: Mapped) -> str:
    """Return what `struct` calls a whole number; drives map no others."""
    code = {1: "b", 2: "h", 4: "i", 8: "q"}[entry.size]
    return code if entry.type.signed else code.upper()


def _refused_communication(sub: int, value: int) -> AbortCode | None:
    remote = sub == _TRANSMISSION and value in _REMOTE_ALONE
    nameless = sub == _COB and not value & STANDARD_ID_MAX
    return AbortCode.VALUE if remote or nameless else None
