"""What words and numbers of the drive profile CiA 402 mean, in words.

Bits 4, 10, 12 and 13 mean what the mode says; where it is not known they are called as in profile
position. While a drive has no current, 10 and 12 mean nothing, and are left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from firmware_protocol.canopen.drive_modes import OperationMode, mode_of, supported_modes
from firmware_protocol.canopen.drive_words import (
    ControlBit,
    Controlword,
    DriveState,
    StatusBit,
    Statusword,
)
from firmware_protocol.canopen.emcy_codes import ErrorRegister
from firmware_protocol.canopen.quick_stop import QuickStopOption

DRIVES = 402
"""The number of the profile of drives, in object 1000."""
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
"""The device profiles that are met beside drives. Source: CiA's list of profiles."""
_KINDS = {0x01: "frequency converter", 0x02: "servo", 0x04: "stepper"}

STATES: Mapping[DriveState, str] = MappingProxyType(
    {
        DriveState.NOT_READY: "not ready to switch on",
        DriveState.DISABLED: "switch on disabled",
        DriveState.READY: "ready to switch on",
        DriveState.SWITCHED_ON: "switched on",
        DriveState.ENABLED: "operation enabled",
        DriveState.QUICK_STOP: "quick stop active",
        DriveState.FAULT_REACTION: "fault reaction active",
        DriveState.FAULT: "fault",
    }
)
"""The states by the names that manuals give them."""

_CYCLIC = (
    OperationMode.CYCLIC_POSITION,
    OperationMode.CYCLIC_VELOCITY,
    OperationMode.CYCLIC_TORQUE,
)
_STATUS: Mapping[StatusBit, str] = {
    StatusBit.WARNING: "warning",
    StatusBit.REACHED: "target reached",
    StatusBit.LIMITED: "limited inside",
    StatusBit.ACKNOWLEDGED: "set-point taken",
    StatusBit.FOLLOWING_ERROR: "following error",
}
_OF_MOTION = frozenset((StatusBit.REACHED, StatusBit.ACKNOWLEDGED))
_STATUS_IN: Mapping[OperationMode, Mapping[StatusBit, str]] = {
    OperationMode.HOMING: {
        StatusBit.ACKNOWLEDGED: "home found",
        StatusBit.FOLLOWING_ERROR: "homing failed",
    },
    **{
        mode: {StatusBit.REACHED: "", StatusBit.ACKNOWLEDGED: "follows its targets"}
        for mode in _CYCLIC
    },
}
_CONTROL: Mapping[ControlBit, str] = {
    ControlBit.NEW_SET_POINT: "new set-point",
    ControlBit.AT_ONCE: "at once",
    ControlBit.RELATIVE: "relative",
    ControlBit.HALT: "halt",
    ControlBit.CHANGE_ON_SET_POINT: "without stopping there",
}
_CONTROL_IN: Mapping[OperationMode, Mapping[ControlBit, str]] = {
    OperationMode.HOMING: {ControlBit.NEW_SET_POINT: "go home"},
}
_STOPPING = {
    QuickStopOption.DISABLE: "the motor loses its current at once",
    QuickStopOption.RAMP: "by its ramp, then it disables itself",
    QuickStopOption.QUICK_RAMP: "by the quick-stop ramp, then it disables itself",
    QuickStopOption.CURRENT_LIMIT: "at the limit of current, then it disables itself",
    QuickStopOption.VOLTAGE_LIMIT: "at the limit of voltage, then it disables itself",
    QuickStopOption.RAMP_AND_STAY: "by its ramp, then it holds",
    QuickStopOption.QUICK_RAMP_AND_STAY: "by the quick-stop ramp, then it holds",
    QuickStopOption.CURRENT_LIMIT_AND_STAY: "at the limit of current, then it holds",
    QuickStopOption.VOLTAGE_LIMIT_AND_STAY: "at the limit of voltage, then it holds",
}
_REACTIONS = {0: "nothing", 1: "fault", 2: "disable voltage", 3: "quick stop"}


def state_words(value: int, mode: OperationMode | None = None) -> str:
    """Return a statusword: its state, and the flags that do not belong to it."""
    word = Statusword(value & 0xFFFF)
    state = word.state
    said = [f"{word.value:04X}", "no state of CiA 402" if state is None else STATES[state]]
    special = _STATUS_IN.get(mode, {}) if mode is not None else {}
    told = [bit for bit in _STATUS if word.has(bit) and (bit not in _OF_MOTION or _holds(state))]
    said += filter(None, (special.get(bit, _STATUS[bit]) for bit in told))
    if not word.has(StatusBit.REMOTE):
        said.append("not remote: it does not obey")
    return f"{said[0]} {', '.join(said[1:])}"


def _holds(state: DriveState | None) -> bool:
    return state is not None and state.holds


def control_words(value: int, mode: OperationMode | None = None) -> str:
    """Return a controlword: its command, and the bits that the mode gives a meaning."""
    word = Controlword(value & 0xFFFF)
    special = _CONTROL_IN.get(mode, {}) if mode is not None else {}
    bits = [special.get(bit, words) for bit, words in _CONTROL.items() if word.has(bit)]
    command = word.command.name.lower().replace("_", " ")
    return f"{word.value:04X} {', '.join((command, *bits))}"


def mode_words(value: int) -> str:
    """Return a mode of operation with its number."""
    mode = mode_of(value)
    name = "one of the maker's" if value < 0 else "reserved"
    return f"{value}, {name if mode is None else mode.name.lower().replace('_', ' ')}"


def modes_words(value: int) -> str:
    """Return the modes that a drive has."""
    modes = sorted(supported_modes(value))
    return ", ".join(mode.name.lower().replace("_", " ") for mode in modes) or "none"


def device_words(value: int) -> str:
    """Return what object 1000 says: the profile and the kind of drive."""
    profile = value & 0xFFFF
    words = PROFILES.get(profile, "a device of a profile that is not known here")
    if profile == DRIVES:
        kind = _KINDS.get(value >> 16 & 0xFF)
        return "CiA 402, a drive" + (f" ({kind})" if kind else "")
    return f"CiA {profile}, {words}" if profile else words


def register_words(value: int) -> str:
    """Return the error register: which kinds of errors there are."""
    kinds = [bit.name for bit in ErrorRegister if value & bit]
    return ", ".join(str(name).lower().replace("_", " ") for name in kinds) or "no error"


def stopping_words(value: int) -> str:
    """Return an option code of a stop (605A, 605E)."""
    words = next((_STOPPING[option] for option in QuickStopOption if option == value), None)
    return f"{value}, {words}" if words else str(value)


def reaction_words(value: int) -> str:
    """Return what a drive does when the heartbeat that it watches is missing (6007)."""
    return f"{value}, {_REACTIONS.get(value, 'not known')}"
