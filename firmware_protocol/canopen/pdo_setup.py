"""How a PDO of a device is set up: the list of SDO writes, in the order that devices insist on.

    disable (bit 31 of its COB-ID), no entries, the entries, how many, when it is sent, enable

It may be written in the state pre-operational alone. Until the last write has been taken, the PDO
does not exist: a list that breaks off leaves the drive deaf to it, not misled by it.
Source: CiA 301, PDO communication and mapping parameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from firmware_protocol.canopen.cob import Service, checked_node, cob_id
from firmware_protocol.canopen.datatypes import DataType
from firmware_protocol.canopen.pdo import Mapping
from firmware_protocol.canopen.sdo_messages import Place
from firmware_protocol.errors import BadField, whole
from firmware_protocol.frames import STANDARD_ID_MAX

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


_PARAMETERS = {Direction.RECEIVED: (0x1400, 0x1600), Direction.TRANSMITTED: (0x1800, 0x1A00)}
_IDS = {
    Direction.RECEIVED: (Service.RPDO1, Service.RPDO2, Service.RPDO3, Service.RPDO4),
    Direction.TRANSMITTED: (Service.TPDO1, Service.TPDO2, Service.TPDO3, Service.TPDO4),
}
_COB, _TRANSMISSION, _INHIBIT, _EVENT_TIMER = 1, 2, 3, 5  # sub-indices


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
        for field in ("inhibit_100us", "event_ms"):
            if getattr(self, field) is not None:
                whole(field, getattr(self, field), 0, 0xFFFF)
        if self.inhibit_100us is not None and self.direction is Direction.RECEIVED:
            raise BadField("inhibit_100us", self.inhibit_100us, "None, where the device receives")
        if self.can_id is None and self.number > len(_IDS[self.direction]):
            raise BadField("can_id", self.can_id, "given, for a PDO behind the fourth")
        if self.can_id is not None:
            whole("can_id", self.can_id, 1, STANDARD_ID_MAX)

    @property
    def frame_id(self) -> int:
        """The id of its frames."""
        if self.can_id is not None:
            return self.can_id
        return cob_id(_IDS[self.direction][self.number - 1], self.node)

    @property
    def writes(self) -> tuple[Write, ...]:
        """What is written, in this order."""
        communication, mapping = (base + self.number - 1 for base in _PARAMETERS[self.direction])
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
        times = ((_INHIBIT, self.inhibit_100us), (_EVENT_TIMER, self.event_ms))
        return tuple(
            Write(Place(communication, sub), DataType.U16, value)
            for sub, value in times
            if value is not None
        )
