"""The objects of a simulated CiA 402 drive: its EDS, its PDOs, and places beyond STANDARD."""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping, Sequence
from collections.abc import Mapping as Table
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.resources import files

from firmware_protocol.canopen import (
    NOT_VALID,
    AbortCode,
    Dictionary,
    Mapped,
    ObjectStore,
    Place,
    read_eds,
)
from firmware_protocol.canopen import Mapping as PdoMapping
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.frames import DATA_MAX, STANDARD_ID_MAX

EDS = "cia402.eds"
COMMUNICATION = range(0x1000, 0x2000)
"""Indices of what a reset of the communication brings back."""
PDO_PARAMETERS = range(0x1400, 0x1C00)

DEVICE_NAME = Place(0x1008)
ERROR_COUNT, LAST_ERROR = Place(0x1003, 0), Place(0x1003, 1)
SERIAL_NUMBER = Place(0x1018, 4)
POSITION_DEMAND = Place(0x6062)
POSITION_WINDOW = Place(0x6067)
VELOCITY = Place(0x606C)
HOME_OFFSET = Place(0x607C)
LEAST_POSITION, MOST_POSITION = Place(0x607D, 1), Place(0x607D, 2)
MOST_MOTOR_SPEED = Place(0x6080)
ENCODER_INCREMENTS = Place(0x608F, 1)
HOMING_METHOD = Place(0x6098)
HOMING_SPEED, HOMING_CREEP = Place(0x6099, 1), Place(0x6099, 2)
HOMING_ACCELERATION = Place(0x609A)
PERIOD, PERIOD_POWER = Place(0x60C2, 1), Place(0x60C2, 2)
DIGITAL_INPUTS = Place(0x60FD)


@cache
def eds_text() -> str:
    """Return the EDS file of the drives, for whoever wants to know them."""
    return (files("armdrive.sim.cia402") / EDS).read_text(encoding="ascii")


@cache
def dictionary() -> Dictionary:
    """Return all that a drive has."""
    return read_eds(eds_text())


def without(missing: frozenset[int], changed: Mapping[Place, int]) -> Dictionary:
    """Return the objects of a drive that lacks some, others not being as the EDS says."""
    whole = dictionary()
    entries = [
        replace(entry, default=changed.get(entry.place, entry.default))
        for entry in whole
        if entry.place.index not in missing
    ]
    return Dictionary(entries, whole.records)


# --- The PDOs that the objects describe ----------------------------------------------------------

COUNT = 4
RECEIVED, TRANSMITTED = (0x1400, 0x1600), (0x1800, 0x1A00)
"""Where communication and mapping of a direction begin."""
SYNCHRONOUS_MOST = 240
AT_CHANGE = 0
"""The transmission type of what is sent at the SYNC behind a change."""
ENTRIES_MOST = 8
_COB, _TRANSMISSION, _INHIBIT, _EVENT = 1, 2, 3, 5
_REMOTE_ALONE = range(241, 254)
_INHIBIT_S, _EVENT_S = 1e-4, 1e-3


@dataclass(slots=True)
class SimPdo:
    """One that exists, and where it stands."""

    can_id: int
    mapping: PdoMapping
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
    _codec: struct.Struct = field(init=False)

    def __post_init__(self) -> None:
        self.places = tuple(entry.place for entry in self.mapping.entries)
        self.size = self.mapping.size
        self._codec = struct.Struct("<" + "".join(map(_code, self.mapping.entries)))

    def pack(self, values: Sequence[int]) -> bytes:
        """Return the data of it."""
        return self._codec.pack(*values)

    def unpack(self, data: bytes) -> tuple[int, ...]:
        """Return the values of data that is long enough."""
        return self._codec.unpack_from(data)

    @property
    def synchronous(self) -> bool:
        """Whether it goes by SYNC."""
        return self.transmission <= SYNCHRONOUS_MOST


class Pdos:
    """Those that exist, by the id of their frames."""

    def __init__(self, store: ObjectStore, dictionary: Dictionary) -> None:
        self._store = store
        self._dictionary = dictionary
        self.received: Table[int, SimPdo] = {}
        self.transmitted: tuple[SimPdo, ...] = ()
        self.rebuild()

    def rebuild(self) -> None:
        """Read the objects anew."""
        received = [self._read(*RECEIVED, number) for number in range(COUNT)]
        sent = [self._read(*TRANSMITTED, number) for number in range(COUNT)]
        self.received = {pdo.can_id: pdo for pdo in received if pdo is not None}
        self.transmitted = tuple(pdo for pdo in sent if pdo is not None)

    def refusal(self, place: Place, value: int) -> AbortCode | None:
        """Return why an object of these may not become a value; None where it may."""
        number = place.index & 0x1FF
        communication = place.index - number in (RECEIVED[0], TRANSMITTED[0])
        if communication:
            return _refused_communication(place.sub, value)
        base = RECEIVED[0] if place.index < TRANSMITTED[0] else TRANSMITTED[0]
        if not self._value(Place(base + number, _COB)) & NOT_VALID:
            return AbortCode.DEVICE_STATE
        if not place.sub:
            return self._refused_count(place.index, value)
        if self._value(Place(place.index, 0)):
            return AbortCode.DEVICE_STATE
        return self._refused_entry(value, received=base == RECEIVED[0])

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

    def _read(self, communication: int, mapping: int, number: int) -> SimPdo | None:
        cob = self._value(Place(communication + number, _COB))
        count = self._value(Place(mapping + number, 0))
        if not cob or cob & NOT_VALID or not count:
            return None
        words = [self._value(Place(mapping + number, sub)) for sub in range(1, count + 1)]
        try:
            mapped = PdoMapping(tuple(Mapped.of(word, self._dictionary) for word in words))
        except (BadField, RemoteProtocolError):  # as shipped it maps what this drive lacks
            return None
        return SimPdo(
            cob & STANDARD_ID_MAX,
            mapped,
            self._value(Place(communication + number, _TRANSMISSION)),
            self._value(Place(communication + number, _INHIBIT)) * _INHIBIT_S,
            self._value(Place(communication + number, _EVENT)) * _EVENT_S,
        )

    def _value(self, place: Place) -> int:
        known = self._dictionary.find(place) is not None
        return int((self._store.value(place) if known else None) or 0)


def _code(entry: Mapped) -> str:
    """Return what `struct` calls a whole number; drives map no others."""
    code = {1: "b", 2: "h", 4: "i", 8: "q"}[entry.size]
    return code if entry.type.signed else code.upper()


def _refused_communication(sub: int, value: int) -> AbortCode | None:
    if sub == _TRANSMISSION and value in _REMOTE_ALONE:
        return AbortCode.VALUE
    if sub == _COB and not value & STANDARD_ID_MAX > 0:
        return AbortCode.VALUE
    return None
