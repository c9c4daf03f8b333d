"""Object dictionaries: places, types and values, and the objects of CiA 402 drives."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterable, Iterator, Mapping
from configparser import Error, RawConfigParser, SectionProxy
from dataclasses import dataclass
from enum import Enum, IntEnum
from functools import cached_property
from typing import NamedTuple, TypeAlias

from firmware_protocol.canopen.services import checked_node
from firmware_protocol.errors import BadField, RemoteProtocolError, whole

Value: TypeAlias = bool | int | float | str | bytes
"""An object's value: bool, int, float, ASCII text, or bytes without a known meaning."""


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
    """A data type, by its number in object dictionaries and EDS files."""

    BOOLEAN = 0x01
    I8 = 0x02
    I16 = 0x03
    I32 = 0x04
    U8 = 0x05
    U16 = 0x06
    U32 = 0x07
    REAL32 = 0x08
    VISIBLE_STRING = 0x09
    OCTET_STRING = 0x0A
    UNICODE_STRING = 0x0B
    TIME_OF_DAY = 0x0C
    TIME_DIFFERENCE = 0x0D
    DOMAIN = 0x0F
    I24 = 0x10
    REAL64 = 0x11
    I40 = 0x12
    I48 = 0x13
    I56 = 0x14
    I64 = 0x15
    U24 = 0x16
    U40 = 0x18
    U48 = 0x19
    U56 = 0x1A
    U64 = 0x1B

    @cached_property  # used for every PDO
    def size(self) -> int | None:
        """Bytes per value; None if the length varies."""
        return _SIZES.get(self)

    @cached_property
    def bits(self) -> int | None:
        """Bits per value in a PDO; None if the type cannot be mapped."""
        return 1 if self is DataType.BOOLEAN else None if self.size is None else 8 * self.size

    @cached_property
    def signed(self) -> bool:
        """Whether the type is a signed integer."""
        return self in _SIGNED

    @cached_property
    def limits(self) -> tuple[int, int] | None:
        """The smallest and the largest integer; None for other types."""
        return _LIMITS.get(self)

    def pack(self, value: Value) -> bytes:
        """Return a value's bytes. Raises `BadField` for a wrong type or a value out of range."""
        if (limits := self.limits) is not None:
            number = whole(self.name, value, *limits)
            return number.to_bytes(_SIZES[self], "little", signed=self.signed)
        if self is DataType.BOOLEAN and isinstance(value, bool):
            return bytes((value,))
        if self in _REALS and isinstance(value, int | float) and not isinstance(value, bool):
            return self._pack_real(value)
        if self is DataType.VISIBLE_STRING and isinstance(value, str) and value.isascii():
            return value.encode("ascii")
        if self not in _TYPED and isinstance(value, bytes):
            return value
        raise BadField(self.name, value, _ALLOWED.get(self, "bytes"))

    def unpack(self, data: bytes, *, exact: bool = True) -> Value:
        """Return the value of bytes. Raises `RemoteProtocolError`.

        If the length is not `exact`, as in an SDO frame without a size, bytes after the value are
        ignored.
        """
        size = self.size
        if size is not None and (len(data) != size if exact else len(data) < size):
            raise RemoteProtocolError(f"length {len(data)} where {self.name} has {size}")
        data = data[:size]
        if self.limits is not None:
            return int.from_bytes(data, "little", signed=self.signed)
        if self is DataType.BOOLEAN:
            return bool(data[0])
        if self in _REALS:
            (real,) = struct.unpack(_REALS[self], data)
            return float(real)
        if self is DataType.VISIBLE_STRING:
            return data.rstrip(b"\0").decode("ascii", "replace")
        return data

    def _pack_real(self, value: float) -> bytes:
        try:
            return struct.pack(_REALS[self], value)
        except (OverflowError, struct.error):
            raise BadField(self.name, value, "a number that it can hold") from None


# an integer type's name contains its sign and its number of bits
_WHOLE = {kind: int(kind.name[1:]) // 8 for kind in DataType if kind.name[1:].isdigit()}
_SIGNED = frozenset(kind for kind in _WHOLE if kind.name.startswith("I"))
_LIMITS = {
    kind: (-(1 << 8 * size - 1), (1 << 8 * size - 1) - 1)
    if kind in _SIGNED
    else (0, (1 << 8 * size) - 1)
    for kind, size in _WHOLE.items()
}
_REALS = {DataType.REAL32: "<f", DataType.REAL64: "<d"}
_SIZES = {
    **_WHOLE,
    DataType.BOOLEAN: 1,
    DataType.REAL32: 4,
    DataType.REAL64: 8,
}
_TYPED = frozenset((*_SIZES, DataType.VISIBLE_STRING))
_ALLOWED = {
    DataType.BOOLEAN: "True or False",
    DataType.REAL32: "a number",
    DataType.REAL64: "a number",
    DataType.VISIBLE_STRING: "ASCII text",
}


# Objects as data: index, sub-index, name, type, access, unit, default.


class Access(Enum):
    """An object's access rights, in the words of EDS files."""

    CONST = "const"
    RO = "ro"
    WO = "wo"
    RW = "rw"
    RWR = "rwr"
    """Read and write; may be mapped into a transmitted PDO."""
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


def one_line(field: str, value: object) -> str:
    """Return text that fits on a line of an EDS file, or raise `BadField`."""
    fits = isinstance(value, str) and value.isprintable() and value == value.strip()
    if not fits or not value or " ;" in str(value):
        raise BadField(field, value, "one line of text, without blanks around it and without ' ;'")
    return str(value)


@dataclass(frozen=True, slots=True)
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
        """Return the object's initial value on a node."""
        if self.adds_node and isinstance(self.default, int):
            return self.default + checked_node(node)
        return self.default


class Dictionary:
    """A device's objects, sorted by place. Raises `BadField` for duplicates.

    `records` names the indices that have sub-indices; an unnamed one takes its first entry's name.
    """

    def __init__(
        self, entries: Iterable[ObjectEntry], records: Mapping[int, str] | None = None
    ) -> None:
        self._entries: dict[Place, ObjectEntry] = {}
        for entry in sorted(entries, key=lambda entry: entry.place):
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
        """The names of the indices that have sub-indices."""
        return dict(self._records)

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
CONSUMER_HEARTBEAT = Place(0x1016, 1)
"""The node whose heartbeat the drive monitors, and the timeout: `nmt.HeartbeatWatch`."""
PRODUCER_HEARTBEAT_MS = Place(0x1017)
VENDOR, PRODUCT, REVISION, SERIAL_NUMBER = (Place(0x1018, sub) for sub in (1, 2, 3, 4))
ERROR_BEHAVIOUR = Place(0x1029, 1)
"""What a communication error does to an operational node: 0 makes it pre-operational, 1 nothing."""
HEARTBEAT_REACTION = Place(0x6007)
"""The reaction (abort connection option code): 0 nothing, 1 fault, 2 disable, 3 quick stop."""
ERROR_CODE = Place(0x603F)
CONTROLWORD = Place(0x6040)
STATUSWORD = Place(0x6041)
QUICK_STOP_OPTION = Place(0x605A)
FAULT_REACTION_OPTION = Place(0x605E)
"""The reaction to a fault: 0 releases the motor, so that an arm sags; 2 brakes first."""
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
POSITION_UNIT, SPEED_UNIT = Place(0x60A8), Place(0x60A9)
"""See `drives.speed_unit_hz`."""
HOMING_METHOD = Place(0x6098)
HOMING_SPEED, HOMING_CREEP = Place(0x6099, 1), Place(0x6099, 2)
"""The speed towards the home switch, and the speed off the switch."""
HOMING_ACCELERATION = Place(0x609A)
PERIOD, PERIOD_POWER = Place(0x60C2, 1), Place(0x60C2, 2)
"""The interpolation time of cyclic targets: a number of units, and the unit's power of ten."""
FOLLOWING_ERROR = Place(0x60F4)
DIGITAL_INPUTS = Place(0x60FD)
SUPPORTED_MODES = Place(0x6502)

STANDARD = Dictionary(
    (
        ObjectEntry(DEVICE_TYPE, "Device type", _U32, _CONST, "", 0x0004_0192),
        ObjectEntry(ERROR_REGISTER, "Error register", _U8, _RO, "", 0, mappable=True),
        ObjectEntry(ERROR_COUNT, "Number of errors", _U8, _RW, "", 0),
        ObjectEntry(LAST_ERROR, "Standard error field", _U32, _RO),
        ObjectEntry(
            Place(0x1016, 0), "Highest sub-index of consumer heartbeats", _U8, _CONST, "", 1
        ),
        ObjectEntry(CONSUMER_HEARTBEAT, "Consumer heartbeat time", _U32, _RW, "", 0),
        ObjectEntry(PRODUCER_HEARTBEAT_MS, "Producer heartbeat time", _U16, _RW, "ms", 0),
        ObjectEntry(Place(0x1018, 0), "Highest sub-index of the identity", _U8, _CONST, "", 4),
        ObjectEntry(VENDOR, "Vendor-ID", _U32, _CONST, "", 0),
        ObjectEntry(PRODUCT, "Product code", _U32, _CONST, "", 0),
        ObjectEntry(REVISION, "Revision number", _U32, _CONST, "", 0),
        ObjectEntry(SERIAL_NUMBER, "Serial number", _U32, _CONST, "", 0),
        ObjectEntry(HEARTBEAT_REACTION, "Abort connection option code", _I16, _RW, "", 1),
        ObjectEntry(ERROR_CODE, "Error code", _U16, _RO, "", 0, mappable=True),
        ObjectEntry(CONTROLWORD, "Controlword", _U16, _RWW, "", 0, mappable=True),
        ObjectEntry(STATUSWORD, "Statusword", _U16, _RO, "", 0, mappable=True),
        ObjectEntry(QUICK_STOP_OPTION, "Quick stop option code", _I16, _RW, "", 2),
        ObjectEntry(FAULT_REACTION_OPTION, "Fault reaction option code", _I16, _RW, "", 2),
        ObjectEntry(MODE, "Modes of operation", _I8, _RWW, "", 0, mappable=True),
        ObjectEntry(MODE_SHOWN, "Modes of operation display", _I8, _RO, "", 0, mappable=True),
        ObjectEntry(POSITION, "Position actual value", _I32, _RO, "inc", 0, mappable=True),
        ObjectEntry(FOLLOWING_ERROR_WINDOW, "Following error window", _U32, _RW, "inc"),
        ObjectEntry(FOLLOWING_ERROR_TIMEOUT_MS, "Following error time out", _U16, _RW, "ms"),
        ObjectEntry(TARGET_POSITION, "Target position", _I32, _RWW, "inc", 0, mappable=True),
        ObjectEntry(
            Place(0x607D, 0), "Highest sub-index of the software limits", _U8, _CONST, "", 2
        ),
        ObjectEntry(LEAST_POSITION, "Min position limit", _I32, _RW, "inc"),
        ObjectEntry(MOST_POSITION, "Max position limit", _I32, _RW, "inc"),
        ObjectEntry(PROFILE_SPEED, "Profile velocity", _U32, _RWW, "inc/s", None, mappable=True),
        ObjectEntry(
            PROFILE_ACCELERATION, "Profile acceleration", _U32, _RWW, "inc/s2", None, mappable=True
        ),
        ObjectEntry(
            PROFILE_DECELERATION, "Profile deceleration", _U32, _RWW, "inc/s2", None, mappable=True
        ),
        ObjectEntry(QUICK_STOP_DECELERATION, "Quick stop deceleration", _U32, _RWW, "inc/s2"),
        ObjectEntry(HOMING_METHOD, "Homing method", _I8, _RW, "", 0),
        ObjectEntry(Place(0x6099, 0), "Highest sub-index of the homing speeds", _U8, _CONST, "", 2),
        ObjectEntry(HOMING_SPEED, "Speed during search for switch", _U32, _RW, "inc/s"),
        ObjectEntry(HOMING_CREEP, "Speed during search for zero", _U32, _RW, "inc/s"),
        ObjectEntry(HOMING_ACCELERATION, "Homing acceleration", _U32, _RW, "inc/s2"),
        ObjectEntry(SPEED_UNIT, "SI unit velocity", _U32, _RW),
        ObjectEntry(
            Place(0x60C2, 0), "Highest sub-index of the interpolation time", _U8, _CONST, "", 2
        ),
        ObjectEntry(PERIOD, "Interpolation time period value", _U8, _RW, "", 1),
        ObjectEntry(PERIOD_POWER, "Interpolation time index", _I8, _RW, "power of ten s", -3),
        ObjectEntry(
            FOLLOWING_ERROR, "Following error actual value", _I32, _RO, "inc", 0, mappable=True
        ),
        ObjectEntry(SUPPORTED_MODES, "Supported drive modes", _U32, _RO, "", 0),
    ),
    {
        0x1003: "Pre-defined error field",
        0x1016: "Consumer heartbeat time",
        0x1018: "Identity object",
        0x607D: "Software position limit",
        0x6099: "Homing speeds",
        0x60C2: "Interpolation time period",
    },
)
"""The objects of a CiA 402 drive that arms use; an EDS file describes a particular drive."""


# Parsing of EDS files (CiA 306).
ARRAY, RECORD, VARIABLE = 0x08, 0x09, 0x07
"""Object codes of CiA 301."""

_OBJECT = re.compile(r"([0-9A-F]{4})(?:sub([0-9A-F]{1,2}))?", re.IGNORECASE)
_NODE = re.compile(r"\$NODEID", re.IGNORECASE)


def read_eds(text: str) -> Dictionary:
    """Return the objects of an EDS or DCF file. Raises `RemoteProtocolError`, with the section.

    Objects of manufacturer-specific types stay bytes. The unit comes from the keyword `Unit`,
    which is an extension of CiA 306.
    """
    parser = RawConfigParser(strict=False, inline_comment_prefixes=(";",), default_section="")
    try:
        parser.read_string(text.removeprefix("\ufeff"))
    except Error as error:
        reason = " ".join(error.message.split())
        raise RemoteProtocolError(f"this is no EDS file: {reason}") from None
    entries: dict[Place, ObjectEntry] = {}
    records: dict[int, str] = {}
    for name in parser.sections():
        found = _OBJECT.fullmatch(name)
        if found is None:
            continue
        index, sub = int(found[1], 16), found[2]
        try:
            if sub is None and _number(parser[name], "ObjectType", VARIABLE) in (ARRAY, RECORD):
                records[index] = _word(parser[name], "ParameterName")
                entries |= {entry.place: entry for entry in _compact(index, parser[name])}
            else:
                place = Place(index, int(sub or "0", 16))
                entries[place] = _entry(place, parser[name])
        except (BadField, RemoteProtocolError) as error:
            raise RemoteProtocolError(f"section [{name}]: {error}") from None
    return Dictionary(entries.values(), records)


def _compact(index: int, section: SectionProxy) -> Iterator[ObjectEntry]:
    """Yield the entries of an array that is described in a single section."""
    count = _number(section, "CompactSubObj", 0)
    if not count:
        return
    yield ObjectEntry(Place(index), "Highest sub-index", DataType.U8, Access.CONST, default=count)
    model = _entry(Place(index), section)
    for sub in range(1, count + 1):
        yield ObjectEntry(
            Place(index, sub),
            f"{model.name} {sub}",
            model.type,
            model.access,
            model.unit,
            model.default,
            model.mappable,
            model.adds_node,
        )


def _entry(place: Place, section: SectionProxy) -> ObjectEntry:
    kind = _type(_number(section, "DataType", 0))
    default, adds_node = _default(kind, section.get("DefaultValue"))
    return ObjectEntry(
        place,
        _word(section, "ParameterName"),
        kind,
        _access(section),
        _clean(section.get("Unit")),
        default,
        bool(_number(section, "PDOMapping", 0)),
        adds_node,
    )


def _word(section: SectionProxy, key: str) -> str:
    value = _clean(section.get(key))
    if not value:
        raise RemoteProtocolError(f"{key} is missing")
    return value


def _clean(value: str | None) -> str:
    """Return the text as a single clean line."""
    return "".join(c if c.isprintable() else " " for c in value or "").strip()


def _access(section: SectionProxy) -> Access:
    word = (section.get("AccessType") or Access.RO.value).lower()  # optional for a DOMAIN
    try:
        return Access(word)
    except ValueError:
        raise RemoteProtocolError(f"AccessType {word} is none") from None


def _number(section: SectionProxy, key: str, default: int) -> int:
    value = section.get(key)
    return default if not value else _whole(key, value)


def _whole(key: str, value: str) -> int:
    try:
        return int(value, 0)
    except ValueError:
        pass
    try:
        return int(value)  # "010" means ten
    except ValueError:
        raise RemoteProtocolError(f"{key} {value} is no whole number") from None


def _type(number: int) -> DataType:
    try:
        return DataType(number)
    except ValueError:
        return DataType.DOMAIN


def _default(kind: DataType, text: str | None) -> tuple[Value | None, bool]:
    """Return a default value, and whether to add the node's number."""
    if not text:
        return None, False
    bare, times = _NODE.subn("", text)
    if times and kind.limits is not None:
        return _whole("DefaultValue", bare.replace("+", "").strip() or "0"), True
    return _value(kind, text), False


def _value(kind: DataType, text: str) -> Value | None:
    if kind.limits is not None:
        number = _whole("DefaultValue", text)
        wraps = kind.signed and number > kind.limits[1]  # FFh as an I8 is -1
        return number - (1 << (kind.bits or 0)) if wraps else number
    if kind is DataType.BOOLEAN:
        return bool(_whole("DefaultValue", text))
    try:
        if kind in (DataType.REAL32, DataType.REAL64):
            return float(text)
        if kind is DataType.VISIBLE_STRING:
            return (_clean(text) or None) if text.isascii() else None
        return bytes.fromhex(text) or None
    except ValueError:
        return None  # manufacturers write byte strings in many forms
