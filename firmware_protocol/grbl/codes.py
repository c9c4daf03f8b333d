"""The GRBL family's error and alarm codes: meaning, remedy, and whether the position is kept.

Sources: gnea/grbl doc/csv (error_codes_en_US.csv, alarm_codes_en_US.csv); grblHAL/core errors.h
and alarms.h; the alarm names of FluidNC's Protocol.cpp. Codes above GRBL's own mean different
things on grblHAL and on FluidNC, and so does FluidNC's error 14.
"""

from __future__ import annotations

from firmware_protocol.fields import message
from firmware_protocol.grbl.dialect import Variant


@message()
class ErrorCode:
    """Why a line was refused. A refused line had no effect."""

    code: int
    meaning: str
    remedy: str


@message()
class AlarmCode:
    """Why the machine is locked. `position_kept` is false if it may have lost steps."""

    code: int
    meaning: str
    remedy: str
    position_kept: bool = False


_LINE = "correct the line; if it left the host whole, bytes were lost on the wire"
_BUSY = "wait until the state is Idle, then send it again"
_SETTING = "correct the setting's value"
_SWITCH = "look at the switches and their wires, then home"
_REHOME = "reset, unlock, and home before moving by plan"
_FIRMWARE = "build the firmware with this option, or do without it"

_ERROR_ROWS: tuple[tuple[int, str, str], ...] = (
    (1, "a word has no letter", _LINE),
    (2, "a number is missing or cannot be read", _LINE),
    (3, "this $ command is not known or not supported", "check the firmware's version and options"),
    (4, "a number is negative that must not be", _LINE),
    (5, "homing is not enabled", "set $22=1 where the arm has switches"),
    (6, "the step pulse is too short", "set $0 to 3 or more"),
    (7, "settings memory could not be read; defaults were restored", "write all settings again"),
    (8, "this $ command needs the state Idle", _BUSY),
    (9, "locked: alarm or jog", "after an alarm unlock with $X; after a jog wait for Idle"),
    (10, "soft limits need homing", "set $22=1 before $20=1"),
    (11, "the line is too long and was not executed", "send shorter lines"),
    (12, "the setting would exceed the greatest step rate", "lower steps per unit or max rate"),
    (13, "the safety door is open", "close the door"),
    (14, "the text to be stored is too long", "store a shorter text"),
    (15, "the jog would leave the travel; it was ignored", "jog less far"),
    (16, "the jog has no = or a word that a jog must not have", _LINE),
    (17, "laser mode needs a PWM output", "set $32=0"),
    (20, "a command is not supported", _LINE),
    (21, "two commands of one modal group", _LINE),
    (22, "no feed rate is set", "give an F word"),
    (23, "a command needs a whole number", _LINE),
    (24, "two commands want the axis words; a lost line end does this", _LINE),
    (25, "a word is repeated; a lost line end does this", _LINE),
    (26, "axis words are missing", _LINE),
    (28, "a command lacks a value word", _LINE),
    (29, "the work coordinate system does not exist", "use G54 to G59"),
    (31, "axis words that no command uses", _LINE),
    (32, "the arc has no axis word in its plane", _LINE),
    (33, "the target is invalid", _LINE),
    (34, "the arc's radius is impossible", _LINE),
    (35, "the arc has no offset in its plane", _LINE),
    (36, "words are left over that nothing uses", _LINE),
)

_GRBLHAL_ERROR_ROWS: tuple[tuple[int, str, str], ...] = (
    (39, "a value is out of range", _LINE),
    (43, "the feed rate is too great", "lower F"),
    (45, "a limit switch is engaged: only homing is allowed", _SWITCH),
    (46, "homing is required", "home"),
    (50, "the emergency stop is active", "release it, then reset"),
    (51, "a motor driver reports a fault", "look at the drivers, then reset"),
    (52, "the setting's value is out of range", _SETTING),
    (53, "the setting is not available on this board", _FIRMWARE),
    (55, "homing is configured impossibly", _SETTING),
    (58, "the output port does not exist", "use a port that the board has"),
    (79, "not allowed while a critical event is active", "reset"),
)

_FLUIDNC_ERROR_ROWS: tuple[tuple[int, str, str], ...] = (
    (14, "the line is too long and was not executed", "send shorter lines"),
    (18, "homing has no cycle", "give each axis a homing section in the board's configuration"),
    (19, "homing of a single axis is not allowed", "allow it in the axis's homing section"),
    (40, "a control input is on", "look at the inputs"),
    (152, "the board's configuration is invalid", "look at its messages after a restart"),
    (162, "this setting can only be read", "change it in the board's configuration file"),
)

_ALARM_ROWS = (
    AlarmCode(1, "a limit switch stopped the motion at once", _REHOME),
    AlarmCode(2, "the target lies outside the travel", "reset, unlock, correct it", True),
    AlarmCode(3, "reset while in motion", _REHOME),
    AlarmCode(4, "the probe was not in its first state", "look at the probe", True),
    AlarmCode(5, "the probe touched nothing", "look at the probe", True),
    AlarmCode(6, "homing was reset", "home again"),
    AlarmCode(7, "the safety door opened while homing", "close it and home again"),
    AlarmCode(8, "homing did not clear the switch when pulling off", "raise $27 or " + _SWITCH),
    AlarmCode(9, "homing did not find the switch", "raise the travel ($130...) or " + _SWITCH),
)

_GRBLHAL_ALARM_ROWS = (
    AlarmCode(10, "the emergency stop is asserted", "release it, reset, and home"),
    AlarmCode(11, "homing is required", "home"),
    AlarmCode(12, "a limit switch is engaged", _SWITCH),
    AlarmCode(13, "the probe protection triggered", _REHOME),
    AlarmCode(14, "the spindle did not reach its speed in time", "look at the spindle"),
    AlarmCode(15, "homing did not find the second switch of an axis", _SWITCH),
    AlarmCode(16, "the power-on self-test failed", "switch the board off and on"),
    AlarmCode(17, "a motor driver reports a fault", "look at the drivers, reset, and home"),
    AlarmCode(18, "homing is configured impossibly", _SETTING),
)

_FLUIDNC_ALARM_ROWS = (
    AlarmCode(10, "the spindle could not be controlled", "look at the spindle"),
    AlarmCode(11, "a control input was on at the start", "look at the inputs, then reset"),
    AlarmCode(
        12,
        "a switch counts as engaged before homing",
        "free it, or, if it is free, switch the board off and on; then home",
    ),
    AlarmCode(13, "the motion was stopped hard", _REHOME),
    AlarmCode(14, "not homed yet", "home"),
    AlarmCode(15, "the start was not finished", "reset"),
)

# GRBL's own errors, common to the family.
ERRORS = {row[0]: ErrorCode(*row) for row in _ERROR_ROWS}
GRBLHAL_ERRORS = {row[0]: ErrorCode(*row) for row in _GRBLHAL_ERROR_ROWS}
FLUIDNC_ERRORS = {row[0]: ErrorCode(*row) for row in _FLUIDNC_ERROR_ROWS}
# GRBL's own alarms, common to the family.
ALARMS = {row.code: row for row in _ALARM_ROWS}
GRBLHAL_ALARMS = {row.code: row for row in _GRBLHAL_ALARM_ROWS}
FLUIDNC_ALARMS = {row.code: row for row in _FLUIDNC_ALARM_ROWS}

_MORE_ERRORS = {Variant.GRBLHAL: GRBLHAL_ERRORS, Variant.FLUIDNC: FLUIDNC_ERRORS}
_MORE_ALARMS = {Variant.GRBLHAL: GRBLHAL_ALARMS, Variant.FLUIDNC: FLUIDNC_ALARMS}
_LOOK_UP = "look the code up in the firmware's own list"


def error_code(code: int, variant: Variant = Variant.GRBL) -> ErrorCode:
    """Return an error's meaning on this firmware, or a placeholder for an unknown code."""
    row = _MORE_ERRORS.get(variant, {}).get(code) or ERRORS.get(code)
    return row or ErrorCode(code, f"error {code}, which is not in the table", _LOOK_UP)


def alarm_code(code: int, variant: Variant = Variant.GRBL) -> AlarmCode:
    """Return an alarm's meaning on this firmware; an unknown alarm loses the position."""
    row = _MORE_ALARMS.get(variant, {}).get(code) or ALARMS.get(code)
    return row or AlarmCode(code, f"alarm {code}, which is not in the table", _LOOK_UP)
