"""Object dictionaries: places, types and values, and the objects of CiA 402 drives."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from configparser import RawConfigParser, SectionProxy
from enum import Enum, IntEnum
from functools import cached_property
from typing import NamedTuple, TypeAlias

from firmware_protocol.canopen.services import checked_node
from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.fields import message

# An object's value: a whole number or ASCII text.
Value: TypeAlias = int | str


class _IndexAndSub(NamedTuple):
    index: int  # type: ignore[assignment] # hides a method of tuples
    sub: int


class Place(_IndexAndSub):
    """The address of an object in a dictionary: index and sub-index.

    A tuple, because its hash is needed for every value of every PDO.
    """

    __slots__ = ()

    def __new__(cls, index: int, sub: int = 0) -> Place:
        """Make an address. Raises `BadField` if a number is out of range."""
        return super().__new__(cls, whole("index", index, 0, 0xFFFF), whole("sub", sub, 0, 0xFF))

    def __str__(self) -> str:
        """Format as in manuals: `6040:00`."""
        return f"{self.index:04X}:{self.sub:02X}"

    @property
    def packed(self) -> bytes:
        """The three bytes on the wire."""
        return self.index.to_bytes(2, "little") + bytes((self.sub,))


class DataType(IntEnum):
    """A data type, by its number in EDS files. Drives of the profile have no others."""

    I8 = 0x02
    I16 = 0x03
    I32 = 0x04
    U8 = 0x05
    U16 = 0x06
    U32 = 0x07
    VISIBLE_STRING = 0x09

    @cached_property  # used for every PDO
    def size(self) -> int | None:
        """Bytes per value; None if the length varies."""
        return None if self is DataType.VISIBLE_STRING else int(self.name[1:]) // 8

    @cached_property
    def signed(self) -> bool:
        """Whether the type is a signed integer."""
        return self.name.startswith("I")

    @cached_property
    def limits(self) -> tuple[int, int] | None:
        """The smallest and the largest integer; None for text."""
        if self.size is None:
            return None
        span = 1 << 8 * self.size
        return (-span // 2, span // 2 - 1) if self.signed else (0, span - 1)

    def pack(self, value: Value) -> bytes:
        """Return a value's bytes. Raises `BadField` for a wrong type or a value out of range."""
        if self.limits is not None and self.size is not None:
            number = whole(self.name, value, *self.limits)
            return number.to_bytes(self.size, "little", signed=self.signed)
        if not isinstance(value, str) or not value.isascii():
            raise BadField(self.name, value, "ASCII text")
        return value.encode("ascii")

    def unpack(self, data: bytes, *, exact: bool = True) -> Value:
        """Return the value of bytes. Raises `RemoteProtocolError`.

        If the length is not `exact`, as in an SDO frame without a size, bytes after the value are
        ignored.
        """
        size = self.size
        if size is None:
            return data.rstrip(b"\0").decode("ascii", "replace")
        if len(data) != size if exact else len(data) < size:
            raise RemoteProtocolError(f"length {len(data)} where {self.name} has {size}")
        return int.from_bytes(data[:size], "little", signed=self.signed)


# Objects as data: index, sub-index, name, type, access, unit, default.


class Access(Enum):
    """An object's access rights, in the words of EDS files."""

    CONST = "const"
    RO = "ro"
    WO = "wo"
    RW = "rw"
    RWW = "rww"
    """Read and write; may be mapped into a received PDO."""

    @property
    def readable(self) -> bool:
        """Whether the object can be read over the bus."""
        return self is not Access.WO

    @property
    def writable(self) -> bool:
        """Whether the object can be written over the bus."""
        return self not in (Access.CONST, Access.RO)


@message()
class ObjectEntry:
    """An object, or one sub-index of a record.

    `unit` is free text, because the drive's factors define its position units. With `adds_node`,
    the node's number is added to `default`, as for COB-ids.
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
        if self.default is not None:
            self.type.pack(self.default)

    def initial(self, node: int) -> Value | None:
        """Return the object's initial value on a node."""
        if self.adds_node and isinstance(self.default, int):
            return self.default + checked_node(node)
        return self.default


class Dictionary:
    """A device's objects, sorted by place. Raises `BadField` for duplicates."""

    def __init__(self, entries: Iterable[ObjectEntry]) -> None:
        self._entries: dict[Place, ObjectEntry] = {}
        for entry in sorted(entries, key=lambda entry: entry.place):
            if entry.place in self._entries:
                raise BadField("place", str(entry.place), "of one object alone")
            self._entries[entry.place] = entry
        self.indices = frozenset(place.index for place in self._entries)
        """The indices of all objects."""

    def __iter__(self) -> Iterator[ObjectEntry]:
        return iter(self._entries.values())

    def find(self, place: Place) -> ObjectEntry | None:
        """Return the object at a place, or None."""
        return self._entries.get(place)


# The objects of CiA 301 and CiA 402 that arms with such drives need.
#
# Position units are defined by the drive (`inc`, encoder increments, if no factor is set).
# Sources: CiA 301, object dictionary; CiA 402-2 and -3 (IEC 61800-7-201), objects of the profile.

_U8, _U16, _U32 = DataType.U8, DataType.U16, DataType.U32
_I8, _I16, _I32 = DataType.I8, DataType.I16, DataType.I32
_RO, _RW, _CONST = Access.RO, Access.RW, Access.CONST
_RWW = Access.RWW

# names for the places that drivers and simulated drives use
DEVICE_TYPE = Place(0x1000)
ERROR_REGISTER = Place(0x1001)
ERROR_COUNT, LAST_ERROR = Place(0x1003, 0), Place(0x1003, 1)
SYNC_ID = Place(0x1005)
DEVICE_NAME = Place(0x1008)
# The node whose heartbeat the drive monitors, and the timeout: `nmt.HeartbeatWatch`.
CONSUMER_HEARTBEAT = Place(0x1016, 1)
PRODUCER_HEARTBEAT_MS = Place(0x1017)
VENDOR, PRODUCT, REVISION, SERIAL_NUMBER = (Place(0x1018, sub) for sub in (1, 2, 3, 4))
# What a communication error does to an operational node: 0 makes it pre-operational, 1 nothing.
ERROR_BEHAVIOUR = Place(0x1029, 1)
# The reaction (abort connection option code): 0 nothing, 1 fault, 2 disable, 3 quick stop.
HEARTBEAT_REACTION = Place(0x6007)
ERROR_CODE = Place(0x603F)
CONTROLWORD = Place(0x6040)
STATUSWORD = Place(0x6041)
QUICK_STOP_OPTION = Place(0x605A)
# The reaction to a fault: 0 releases the motor, so that an arm sags; 2 brakes first.
FAULT_REACTION_OPTION = Place(0x605E)
MODE = Place(0x6060)
MODE_SHOWN = Place(0x6061)
POSITION_DEMAND = Place(0x6062)
POSITION = Place(0x6064)
FOLLOWING_ERROR_WINDOW = Place(0x6065)
FOLLOWING_ERROR_TIMEOUT_MS = Place(0x6066)
POSITION_WINDOW = Place(0x6067)
VELOCITY = Place(0x606C)
TARGET_POSITION = Place(0x607A)
HOME_OFFSET = Place(0x607C)
LEAST_POSITION, MOST_POSITION = Place(0x607D, 1), Place(0x607D, 2)
MOST_MOTOR_SPEED = Place(0x6080)
PROFILE_SPEED = Place(0x6081)
PROFILE_ACCELERATION = Place(0x6083)
PROFILE_DECELERATION = Place(0x6084)
QUICK_STOP_DECELERATION = Place(0x6085)
ENCODER_INCREMENTS, ENCODER_TURNS = Place(0x608F, 1), Place(0x608F, 2)
# See `drives.speed_unit_hz`.
POSITION_UNIT, SPEED_UNIT = Place(0x60A8), Place(0x60A9)
HOMING_METHOD = Place(0x6098)
# The speed towards the home switch, and the speed off the switch.
HOMING_SPEED, HOMING_CREEP = Place(0x6099, 1), Place(0x6099, 2)
HOMING_ACCELERATION = Place(0x609A)
# The interpolation time of cyclic targets: a number of units, and the unit's power of ten.
PERIOD, PERIOD_POWER = Place(0x60C2, 1), Place(0x60C2, 2)
FOLLOWING_ERROR = Place(0x60F4)
DIGITAL_INPUTS = Place(0x60FD)
SUPPORTED_MODES = Place(0x6502)

# fmt: off
# The objects of a CiA 402 drive that arms use; an EDS file describes a particular drive.
STANDARD = Dictionary((
    ObjectEntry(DEVICE_TYPE, "Device type", _U32, _CONST, "", 0x0004_0192),
    ObjectEntry(ERROR_REGISTER, "Error register", _U8, _RO, "", 0, True),
    ObjectEntry(ERROR_COUNT, "Number of errors", _U8, _RW, "", 0),
    ObjectEntry(LAST_ERROR, "Standard error field", _U32, _RO),
    ObjectEntry(Place(0x1016, 0), "Highest sub-index of consumer heartbeats", _U8, _CONST, "", 1),
    ObjectEntry(CONSUMER_HEARTBEAT, "Consumer heartbeat time", _U32, _RW, "", 0),
    ObjectEntry(PRODUCER_HEARTBEAT_MS, "Producer heartbeat time", _U16, _RW, "ms", 0),
    ObjectEntry(Place(0x1018, 0), "Highest sub-index of the identity", _U8, _CONST, "", 4),
    ObjectEntry(VENDOR, "Vendor-ID", _U32, _CONST, "", 0),
    ObjectEntry(PRODUCT, "Product code", _U32, _CONST, "", 0),
    ObjectEntry(REVISION, "Revision number", _U32, _CONST, "", 0),
    ObjectEntry(SERIAL_NUMBER, "Serial number", _U32, _CONST, "", 0),
    ObjectEntry(HEARTBEAT_REACTION, "Abort connection option code", _I16, _RW, "", 1),
    ObjectEntry(ERROR_CODE, "Error code", _U16, _RO, "", 0, True),
    ObjectEntry(CONTROLWORD, "Controlword", _U16, _RWW, "", 0, True),
    ObjectEntry(STATUSWORD, "Statusword", _U16, _RO, "", 0, True),
    ObjectEntry(QUICK_STOP_OPTION, "Quick stop option code", _I16, _RW, "", 2),
    ObjectEntry(FAULT_REACTION_OPTION, "Fault reaction option code", _I16, _RW, "", 2),
    ObjectEntry(MODE, "Modes of operation", _I8, _RWW, "", 0, True),
    ObjectEntry(MODE_SHOWN, "Modes of operation display", _I8, _RO, "", 0, True),
    ObjectEntry(POSITION, "Position actual value", _I32, _RO, "inc", 0, True),
    ObjectEntry(FOLLOWING_ERROR_WINDOW, "Following error window", _U32, _RW, "inc"),
    ObjectEntry(FOLLOWING_ERROR_TIMEOUT_MS, "Following error time out", _U16, _RW, "ms"),
    ObjectEntry(TARGET_POSITION, "Target position", _I32, _RWW, "inc", 0, True),
    ObjectEntry(Place(0x607D, 0), "Highest sub-index of the software limits", _U8, _CONST, "", 2),
    ObjectEntry(LEAST_POSITION, "Min position limit", _I32, _RW, "inc"),
    ObjectEntry(MOST_POSITION, "Max position limit", _I32, _RW, "inc"),
    ObjectEntry(PROFILE_SPEED, "Profile velocity", _U32, _RWW, "inc/s", None, True),
    ObjectEntry(PROFILE_ACCELERATION, "Profile acceleration", _U32, _RWW, "inc/s2", None, True),
    ObjectEntry(PROFILE_DECELERATION, "Profile deceleration", _U32, _RWW, "inc/s2", None, True),
    ObjectEntry(QUICK_STOP_DECELERATION, "Quick stop deceleration", _U32, _RWW, "inc/s2"),
    ObjectEntry(HOMING_METHOD, "Homing method", _I8, _RW, "", 0),
    ObjectEntry(Place(0x6099, 0), "Highest sub-index of the homing speeds", _U8, _CONST, "", 2),
    ObjectEntry(HOMING_SPEED, "Speed during search for switch", _U32, _RW, "inc/s"),
    ObjectEntry(HOMING_CREEP, "Speed during search for zero", _U32, _RW, "inc/s"),
    ObjectEntry(HOMING_ACCELERATION, "Homing acceleration", _U32, _RW, "inc/s2"),
    ObjectEntry(SPEED_UNIT, "SI unit velocity", _U32, _RW),
    ObjectEntry(Place(0x60C2, 0), "Highest sub-index of interpolation time", _U8, _CONST, "", 2),
    ObjectEntry(PERIOD, "Interpolation time period value", _U8, _RW, "", 1),
    ObjectEntry(PERIOD_POWER, "Interpolation time index", _I8, _RW, "power of ten s", -3),
    ObjectEntry(FOLLOWING_ERROR, "Following error actual value", _I32, _RO, "inc", 0, True),
    ObjectEntry(SUPPORTED_MODES, "Supported drive modes", _U32, _RO, "", 0),
))
# fmt: on


# The EDS file of a drive (CiA 306), as a simulated drive needs it: whole numbers and texts.

_OBJECT = re.compile(r"([0-9A-F]{4})(?:sub([0-9A-F]{1,2}))?")
_RECORD = "0x9"
_NODE = "$NODEID+"


def read_eds(text: str) -> Dictionary:
    """Return the objects of an EDS file. Units are from the keyword `Unit`, which is our own."""
    parser = RawConfigParser()
    parser.read_string(text)
    found = [(parser[name], _OBJECT.fullmatch(name)) for name in parser.sections()]
    return Dictionary(
        _entry(Place(int(place[1], 16), int(place[2] or "0", 16)), section)
        for section, place in found
        if place is not None and section["ObjectType"] != _RECORD
    )


def _entry(place: Place, section: SectionProxy) -> ObjectEntry:
    kind, text = DataType(int(section["DataType"], 0)), section.get("DefaultValue")
    default: Value | None = text
    if text is not None and kind.limits is not None:
        default = int(text.removeprefix(_NODE), 0)
    return ObjectEntry(
        place,
        section["ParameterName"],
        kind,
        Access(section["AccessType"]),
        section.get("Unit", ""),
        default,
        section["PDOMapping"] == "1",
        text is not None and text.startswith(_NODE),
    )
