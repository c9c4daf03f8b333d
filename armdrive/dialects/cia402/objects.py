"""The objects of CANopen devices: their names, and their values in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from firmware_protocol.canopen.drives import (
    INCREMENTS_A_SECOND,
    POSITION_INCREMENTS,
    RPM,
    ControlBit,
    Controlword,
    QuickStopOption,
    StatusBit,
    Statusword,
    mode_of,
    supported_modes,
)
from firmware_protocol.canopen.objects import (
    CONSUMER_HEARTBEAT,
    CONTROLWORD,
    DEVICE_NAME,
    DEVICE_TYPE,
    ERROR_CODE,
    ERROR_REGISTER,
    FAULT_REACTION_OPTION,
    HEARTBEAT_REACTION,
    HOMING_METHOD,
    MODE,
    MODE_SHOWN,
    POSITION_UNIT,
    QUICK_STOP_OPTION,
    SPEED_UNIT,
    STANDARD,
    STATUSWORD,
    SUPPORTED_MODES,
    Access,
    DataType,
    Dictionary,
    ObjectEntry,
    Place,
    Value,
)
from firmware_protocol.canopen.pdo import NO_REMOTE, NOT_VALID
from firmware_protocol.canopen.services import ErrorRegister, HeartbeatWatch, error_words
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.fields import in_words

# Values of the drive profile CiA 402 in words.
#
# Bits 4, 10, 12 and 13 mean something else in each mode: they have one name that fits all. While a
# drive has no current, 10 and 12 mean nothing and are left out.

# The number of the profile of drives, in object 1000.
DRIVES = 402
# Common device profiles. Source: CiA's list of profiles.
PROFILES: Mapping[int, str] = MappingProxyType(
    {
        0: "no profile",
        401: "an I/O module",
        402: "a drive",
        404: "a measuring device",
        405: "a programmable controller",
        406: "an encoder",
        408: "a hydraulic drive or valve",
        410: "an inclinometer",
    }
)
_KINDS = {0x01: "frequency converter", 0x02: "servo", 0x04: "stepper"}

_STATUS: Mapping[StatusBit, str] = {
    StatusBit.WARNING: "warning",
    StatusBit.REACHED: "target reached",
    StatusBit.LIMITED: "limited inside",
    StatusBit.ACKNOWLEDGED: "acknowledged",
    StatusBit.FOLLOWING_ERROR: "following or homing error",
}
_OF_MOTION = frozenset((StatusBit.REACHED, StatusBit.ACKNOWLEDGED))
_CONTROL: Mapping[ControlBit, str] = {
    ControlBit.NEW_SET_POINT: "new set-point or go home",
    ControlBit.AT_ONCE: "at once",
    ControlBit.RELATIVE: "relative",
    ControlBit.HALT: "halt",
    ControlBit.CHANGE_ON_SET_POINT: "without stopping there",
}
_REACTIONS = {0: "nothing", 1: "fault", 2: "disable voltage", 3: "quick stop"}
# The homing methods of CiA 402-2 (6098): up is the direction in which the drive counts up.
_HOMING: tuple[tuple[tuple[int, ...], str], ...] = (
    ((0,), "no homing"),
    ((1, 17), "down to the negative limit switch"),
    ((2, 18), "up to the positive limit switch"),
    ((*range(3, 7), *range(19, 23)), "to the home switch"),
    ((*range(7, 11), *range(23, 27)), "up to the home switch"),
    ((*range(11, 15), *range(27, 31)), "down to the home switch"),
    ((33,), "down to the index pulse"),
    ((34,), "up to the index pulse"),
    ((35, 37), "at the present position"),
)


def state_words(value: int) -> str:
    """Return a statusword: its state and its other flags."""
    word = Statusword(value)
    state = word.state
    parts = ["no state of CiA 402" if state is None else in_words(state)]
    holds = state is not None and state.holds
    parts += [
        words
        for bit, words in _STATUS.items()
        if word.has(bit) and (holds or bit not in _OF_MOTION)
    ]
    if not word.has(StatusBit.REMOTE):
        parts.append("not remote: it does not obey")
    return f"{word.value:04X} {', '.join(parts)}"


def control_words(value: int) -> str:
    """Return a controlword: its command and its other bits."""
    word = Controlword(value)
    bits = [words for bit, words in _CONTROL.items() if word.has(bit)]
    return f"{word.value:04X} {', '.join((in_words(word.command), *bits))}"


def mode_words(value: int) -> str:
    """Return a mode of operation with its number."""
    mode = mode_of(value)
    name = "one of the maker's" if value < 0 else "reserved"
    return f"{value}, {name if mode is None else in_words(mode)}"


def modes_words(value: int) -> str:
    """Return the modes that a drive supports."""
    modes = sorted(supported_modes(value))
    return ", ".join(in_words(mode) for mode in modes) or "none"


def device_words(value: int) -> str:
    """Return object 1000: the profile and the kind of drive."""
    profile = value & 0xFFFF
    words = PROFILES.get(profile, "a device of an unknown profile")
    if profile == DRIVES:
        kind = _KINDS.get(value >> 16 & 0xFF)
        return "CiA 402, a drive" + (f" ({kind})" if kind else "")
    return f"CiA {profile}, {words}" if profile else words


def register_words(value: int) -> str:
    """Return the kinds of errors in the error register."""
    kinds = [bit.name for bit in ErrorRegister if value & bit]
    return ", ".join(str(name).lower().replace("_", " ") for name in kinds) or "no error"


def stopping_words(value: int) -> str:
    """Return an option code of a stop (605A, 605E)."""
    words = next((in_words(option) for option in QuickStopOption if option == value), "not known")
    return f"{value}, {words}"


def reaction_words(value: int) -> str:
    """Return a drive's reaction to a missing heartbeat (6007)."""
    return f"{value}, {_REACTIONS.get(value, 'not known')}"


def homing_words(value: int) -> str:
    """Return a homing method (6098): where the drive searches."""
    name = "one of the maker's" if value < 0 else "not known"
    return f"{value}, {next((words for methods, words in _HOMING if value in methods), name)}"


_U8, _U16, _U32, _I32 = DataType.U8, DataType.U16, DataType.U32, DataType.I32
_TEXT = DataType.VISIBLE_STRING
# Further objects that are common on a bus but that arms do not need.
_MORE = Dictionary(
    ObjectEntry(place, name, kind, Access.RW, unit)
    for place, name, kind, unit in (
        (Place(0x1002), "Manufacturer status register", _U32, ""),
        (Place(0x1005), "COB-ID of SYNC", _U32, ""),
        (Place(0x1006), "Communication cycle period", _U32, "us"),
        (DEVICE_NAME, "Manufacturer device name", _TEXT, ""),
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


def entry_of(place: Place) -> ObjectEntry | None:
    """Return the standard object at a place, or None."""
    return STANDARD.find(place) or _MORE.find(place) or _pdo_entry(place)


def is_text(place: Place) -> bool:
    """Return whether an object is text."""
    entry = entry_of(place)
    return entry is not None and entry.type is _TEXT


def object_words(place: Place) -> str:
    """Return an object's place and name: `6041:00 Statusword`."""
    entry = entry_of(place)
    return str(place) if entry is None else f"{place} {entry.name}"


def held_words(place: Place, data: bytes) -> str:
    """Return an object's value in words if they are known, else its bytes."""
    entry = entry_of(place)
    try:
        value = None if entry is None else entry.type.unpack(data, exact=False)
    except RemoteProtocolError:
        value = None
    if entry is None or value is None:
        return data.hex(" ") or "nothing"
    return value_words(place, value, entry.unit)


def value_words(place: Place, value: Value, unit: str = "") -> str:
    """Return a value of an object in words."""
    words = _WORDS.get(place) or _pdo_words(place)
    if words is not None and isinstance(value, int):
        return words(value)
    return f"{value} {unit}" if unit else str(value)


def _pdo_entry(place: Place) -> ObjectEntry | None:
    kind = _PDO_BASES.get(place.index & ~(_PDO_SPAN - 1))
    if kind is None:
        return None
    name = f"{kind}{place.index % _PDO_SPAN + 1}"
    if place.index & ~(_PDO_SPAN - 1) in _MAPPINGS:
        count = place.sub == 0
        what, size = ("number of objects", _U8) if count else (f"object {place.sub}", _U32)
    else:
        what, size = _COMMUNICATION.get(place.sub, ("", _U32))
    return ObjectEntry(place, f"{name} {what}", size, Access.RW) if what else None


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


_UNITS = {POSITION_INCREMENTS: "increments", INCREMENTS_A_SECOND: "increments/s", RPM: "rpm"}


def _unit_words(word: int) -> str:
    """Return a unit as manuals write it."""
    return f"{word:08X} ({_UNITS[word]})" if word in _UNITS else f"{word:08X}"


def _watch_words(word: int) -> str:
    watch = HeartbeatWatch.of(word)
    return "no node" if watch is None else f"node {watch.node} within {watch.silence_ms} ms"


def _error_words(code: int) -> str:
    return f"{code:04X}, {error_words(code)}" if code else "none"


_WORDS: Mapping[Place, Callable[[int], str]] = MappingProxyType(
    {
        DEVICE_TYPE: device_words,
        ERROR_REGISTER: register_words,
        CONSUMER_HEARTBEAT: _watch_words,
        HEARTBEAT_REACTION: reaction_words,
        HOMING_METHOD: homing_words,
        ERROR_CODE: _error_words,
        CONTROLWORD: control_words,
        STATUSWORD: state_words,
        QUICK_STOP_OPTION: stopping_words,
        FAULT_REACTION_OPTION: stopping_words,
        MODE: mode_words,
        MODE_SHOWN: mode_words,
        SUPPORTED_MODES: modes_words,
        POSITION_UNIT: _unit_words,
        SPEED_UNIT: _unit_words,
        Place(0x1018, 1): "{:08X}".format,
        Place(0x1018, 2): "{:08X}".format,
        Place(0x1018, 3): "{:08X}".format,
    }
)
