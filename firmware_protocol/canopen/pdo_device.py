"""A device's end of PDOs: what its objects make of them, when each is sent and acted on.

No clock and no wire: its owner hands times in, in seconds, and frames out.
Source: CiA 301, PDO communication and mapping parameters.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field

from firmware_protocol.canopen.objects import Dictionary
from firmware_protocol.canopen.pdo import Mapped, Mapping
from firmware_protocol.canopen.pdo_setup import NOT_VALID
from firmware_protocol.canopen.sdo_codes import AbortCode
from firmware_protocol.canopen.sdo_messages import Place
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.frames import DATA_MAX, STANDARD_ID_MAX, Frame

PDO_PARAMETERS = range(0x1400, 0x1C00)
"""Indices of the objects that describe them."""
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
    _codec: struct.Struct = field(init=False)

    def __post_init__(self) -> None:
        self.places = tuple(entry.place for entry in self.mapping.entries)
        self.size = self.mapping.size
        self._codec = struct.Struct("<" + "".join(map(_code, self.mapping.entries)))

    def pack(self, values: Sequence[int]) -> bytes:
        """Return the data of it."""
        return self._codec.pack(*values)

    def unpack(self, data: bytes) -> list[tuple[Place, int]]:
        """Return the objects and their values of data that is long enough."""
        return [*zip(self.places, self._codec.unpack_from(data), strict=True)]

    @property
    def synchronous(self) -> bool:
        """Whether it goes by SYNC."""
        return self.transmission <= SYNCHRONOUS_MOST


class DevicePdos:
    """Those that exist. `value` is what an object holds; `read` what it is at a moment.

    `say` brings a frame to the bus; `act` is handed what a PDO has brought, once that is acted on.
    """

    def __init__(
        self,
        dictionary: Dictionary,
        value: Callable[[Place], int],
        read: Callable[[Place, float], int],
        act: Callable[[Sequence[tuple[Place, int]], float], None],
        say: Callable[[Frame], None],
    ) -> None:
        self._dictionary, self._value = dictionary, value
        self._read, self._act, self._say = read, act, say
        self._received: dict[int, DevicePdo] = {}
        self._transmitted: tuple[DevicePdo, ...] = ()
        self.rebuild()

    @property
    def received(self) -> Collection[int]:
        """The ids of the frames that carry them to the drive."""
        return self._received.keys()

    def rebuild(self) -> None:
        """Read the objects again."""
        received = [self._described(*RECEIVED, number) for number in range(COUNT)]
        sent = [self._described(*TRANSMITTED, number) for number in range(COUNT)]
        self._received = {pdo.can_id: pdo for pdo in received if pdo is not None}
        self._transmitted = tuple(pdo for pdo in sent if pdo is not None)

    # When they are sent, and acted on.

    @property
    def due_s(self) -> float:
        """When the next one is to be sent by its timer."""
        return min((pdo.due_s for pdo in self._transmitted), default=math.inf)

    def sync(self, now_s: float) -> None:
        """Tell how the drive stands at this moment, and only then do what came before it."""
        for pdo in self._transmitted:
            if pdo.synchronous:
                self._send_in_turn(pdo, now_s)
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
        for pdo in self._transmitted:
            if not pdo.synchronous:
                data = self._packed(pdo, now_s)
                if pdo.free_s <= now_s and (data != pdo.data or pdo.due_s <= now_s):
                    self._send(pdo, data, now_s)
                elif data != pdo.data:
                    pdo.due_s = min(pdo.due_s, pdo.free_s)

    def _send_in_turn(self, pdo: DevicePdo, now_s: float) -> None:
        data = self._packed(pdo, now_s)
        pdo.beats += 1
        if pdo.transmission == AT_CHANGE and data == pdo.data:
            return
        if pdo.beats >= pdo.transmission:
            pdo.beats = 0
            self._send(pdo, data, now_s)

    def _packed(self, pdo: DevicePdo, now_s: float) -> bytes:
        return pdo.pack([self._read(place, now_s) for place in pdo.places])

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

    def _described(self, communication: int, mapping: int, number: int) -> DevicePdo | None:
        cob = self._value(Place(communication + number, _COB))
        count = self._value(Place(mapping + number, 0))
        if not cob or cob & NOT_VALID or not count:
            return None
        words = [self._value(Place(mapping + number, sub)) for sub in range(1, count + 1)]
        try:
            mapped = Mapping(tuple(Mapped.of(word, self._dictionary) for word in words))
        except (BadField, RemoteProtocolError):  # as shipped it maps what this drive lacks
            return None
        return DevicePdo(
            cob & STANDARD_ID_MAX,
            mapped,
            self._value(Place(communication + number, _TRANSMISSION)),
            self._value(Place(communication + number, _INHIBIT)) * _INHIBIT_S,
            self._value(Place(communication + number, _EVENT)) * _EVENT_S,
        )


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
