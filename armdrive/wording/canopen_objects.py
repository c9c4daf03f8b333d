"""The objects of CANopen devices by name, and what they hold in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from armdrive.wording.canopen_drives import (
    control_words,
    device_words,
    mode_words,
    modes_words,
    reaction_words,
    register_words,
    stopping_words,
)
from armdrive.wording.canopen_drives import state_words as status_words
from firmware_protocol.canopen.datatypes import DataType, Value
from firmware_protocol.canopen.emcy_codes import error_words
from firmware_protocol.canopen.nmt import HeartbeatWatch
from firmware_protocol.canopen.objects import Access, Dictionary, Entry
from firmware_protocol.canopen.pdo_setup import NO_REMOTE, NOT_VALID
from firmware_protocol.canopen.sdo_messages import Place
from firmware_protocol.canopen.standard import (
    CONSUMER_HEARTBEAT,
    CONTROLWORD,
    DEVICE_TYPE,
    ERROR_CODE,
    ERROR_REGISTER,
    FAULT_REACTION_OPTION,
    HEARTBEAT_REACTION,
    MODE,
    MODE_SHOWN,
    QUICK_STOP_OPTION,
    STANDARD,
    STATUSWORD,
    SUPPORTED_MODES,
)
from firmware_protocol.errors import RemoteProtocolError

NAME = Place(0x1008)
"""The manufacturer's name of a device."""

_U8, _U16, _U32, _I32 = DataType.U8, DataType.U16, DataType.U32, DataType.I32
_TEXT = DataType.VISIBLE_STRING
_MORE = Dictionary(
    Entry(place, name, kind, Access.RW, unit)
    for place, name, kind, unit in (
        (Place(0x1002), "Manufacturer status register", _U32, ""),
        (Place(0x1005), "COB-ID of SYNC", _U32, ""),
        (Place(0x1006), "Communication cycle period", _U32, "us"),
        (NAME, "Manufacturer device name", _TEXT, ""),
        (Place(0x1009), "Manufacturer hardware version", _TEXT, ""),
        (Place(0x100A), "Manufacturer software version", _TEXT, ""),
        (Place(0x1014), "COB-ID of EMCY", _U32, ""),
        (Place(0x1019), "Counter of SYNC", _U8, ""),
        (Place(0x605B), "Shutdown option code", DataType.I16, ""),
        (Place(0x605C), "Disable operation option code", DataType.I16, ""),
        (Place(0x605D), "Halt option code", DataType.I16, ""),
        (Place(0x606C), "Velocity actual value", _I32, "inc/s"),
        (Place(0x607C), "Home offset", _I32, "inc"),
        (Place(0x607E), "Polarity", _U8, ""),
        (Place(0x607F), "Max profile velocity", _U32, "inc/s"),
        (Place(0x6080), "Max motor speed", _U32, "rpm"),
        (Place(0x608F, 1), "Encoder increments", _U32, "inc"),
        (Place(0x608F, 2), "Motor revolutions", _U32, ""),
        (Place(0x6091, 1), "Gear ratio, motor shaft", _U32, ""),
        (Place(0x6091, 2), "Gear ratio, driving shaft", _U32, ""),
        (Place(0x6092, 1), "Feed", _U32, ""),
        (Place(0x6092, 2), "Feed, shaft revolutions", _U32, ""),
        (Place(0x60FF), "Target velocity", _I32, "inc/s"),
    )
)
"""What is met on a bus beside the objects that arms need."""

_PDO_SPAN = 0x200
_PDO_BASES = {0x1400: "RPDO", 0x1600: "RPDO", 0x1800: "TPDO", 0x1A00: "TPDO"}
_MAPPINGS = (0x1600, 0x1A00)
_COMMUNICATION = {
    0: ("highest sub-index", _U8),
    1: ("COB-ID", _U32),
    2: ("transmission type", _U8),
    3: ("inhibit time", _U16),
    5: ("event timer", _U16),
}


def entry_of(place: Place) -> Entry | None:
    """Return an object that is known by its place; None where it is none of the standards'."""
    return STANDARD.find(place) or _MORE.find(place) or _pdo_entry(place)


def object_words(place: Place) -> str:
    """Name an object: `6041:00 Statusword`."""
    entry = entry_of(place)
    return str(place) if entry is None else f"{place} {entry.name}"


def held_words(place: Place, data: bytes) -> str:
    """Return what an object holds, in words where they are known, else its bytes."""
    entry = entry_of(place)
    try:
        value = None if entry is None else entry.type.unpack(data, exact=False)
    except RemoteProtocolError:
        value = None
    if entry is None or value is None or isinstance(value, bytes):
        return data.hex(" ") or "nothing"
    return value_words(place, value, entry.unit)


def value_words(place: Place, value: Value, unit: str = "") -> str:
    """Return a value of an object in words."""
    words = _WORDS.get(place) or _pdo_words(place)
    if words is not None and isinstance(value, int):
        return words(value)
    shown = value.hex(" ") if isinstance(value, bytes) else str(value)
    return f"{shown} {unit}" if unit else shown


def _pdo_entry(place: Place) -> Entry | None:
    kind = _PDO_BASES.get(place.index & ~(_PDO_SPAN - 1))
    if kind is None:
        return None
    name = f"{kind}{place.index % _PDO_SPAN + 1}"
    if place.index & ~(_PDO_SPAN - 1) in _MAPPINGS:
        count = place.sub == 0
        what, size = ("number of objects", _U8) if count else (f"object {place.sub}", _U32)
    else:
        what, size = _COMMUNICATION.get(place.sub, ("", _U32))
    return Entry(place, f"{name} {what}", size, Access.RW) if what else None


def _pdo_words(place: Place) -> Callable[[int], str] | None:
    base = place.index & ~(_PDO_SPAN - 1)
    if base in _MAPPINGS and place.sub:
        return _mapped_words
    return _cob_words if base in _PDO_BASES and base not in _MAPPINGS and place.sub == 1 else None


def _mapped_words(word: int) -> str:
    return f"{object_words(Place(word >> 16, word >> 8 & 0xFF))}, {word & 0xFF} bits"


def _cob_words(word: int) -> str:
    off = ", switched off" if word & NOT_VALID else ""
    return f"{word & ~(NOT_VALID | NO_REMOTE):03X}{off}"


def _watch_words(word: int) -> str:
    watch = HeartbeatWatch.of(word)
    return "nobody" if watch is None else f"node {watch.node} within {watch.silence_ms} ms"


def _error_words(code: int) -> str:
    return f"{code:04X}, {error_words(code)}" if code else "none"


_WORDS: Mapping[Place, Callable[[int], str]] = MappingProxyType(
    {
        DEVICE_TYPE: device_words,
        ERROR_REGISTER: register_words,
        CONSUMER_HEARTBEAT: _watch_words,
        HEARTBEAT_REACTION: reaction_words,
        ERROR_CODE: _error_words,
        CONTROLWORD: control_words,
        STATUSWORD: status_words,
        QUICK_STOP_OPTION: stopping_words,
        FAULT_REACTION_OPTION: stopping_words,
        MODE: mode_words,
        MODE_SHOWN: mode_words,
        SUPPORTED_MODES: modes_words,
        Place(0x1018, 1): "{:08X}".format,
        Place(0x1018, 2): "{:08X}".format,
        Place(0x1018, 3): "{:08X}".format,
    }
)
