"""The objects of CiA 301 and CiA 402 that arms on such drives need.

Position units are the drive's (`inc` where no factor is set: increments of its encoder). Sources:
CiA 301, object dictionary; CiA 402-2 and -3 (IEC 61800-7-201), objects of the drive profile.
"""

from __future__ import annotations

from firmware_protocol.canopen.datatypes import DataType
from firmware_protocol.canopen.objects import Access, Dictionary, ObjectEntry
from firmware_protocol.canopen.sdo_messages import Place

_U8, _U16, _U32 = DataType.U8, DataType.U16, DataType.U32
_I8, _I16, _I32 = DataType.I8, DataType.I16, DataType.I32
_RO, _RW, _CONST = Access.RO, Access.RW, Access.CONST
_RWW = Access.RWW

DEVICE_TYPE = Place(0x1000)
ERROR_REGISTER = Place(0x1001)
CONSUMER_HEARTBEAT = Place(0x1016, 1)
"""Whose silence the drive minds, and from when on: `nmt.HeartbeatWatch`."""
PRODUCER_HEARTBEAT_MS = Place(0x1017)
HEARTBEAT_REACTION = Place(0x6007)
"""What it does then (abort connection option code): 0 nothing, 1 fault, 2 disable, 3 quick stop."""
ERROR_CODE = Place(0x603F)
CONTROLWORD = Place(0x6040)
STATUSWORD = Place(0x6041)
QUICK_STOP_OPTION = Place(0x605A)
FAULT_REACTION_OPTION = Place(0x605E)
"""What it does upon a fault: 0 lets the motor turn freely, so that an arm sags; 2 brakes first."""
MODE = Place(0x6060)
MODE_SHOWN = Place(0x6061)
POSITION = Place(0x6064)
FOLLOWING_ERROR_WINDOW = Place(0x6065)
FOLLOWING_ERROR_TIMEOUT_MS = Place(0x6066)
TARGET_POSITION = Place(0x607A)
PROFILE_SPEED = Place(0x6081)
PROFILE_ACCELERATION = Place(0x6083)
PROFILE_DECELERATION = Place(0x6084)
QUICK_STOP_DECELERATION = Place(0x6085)
FOLLOWING_ERROR = Place(0x60F4)
SUPPORTED_MODES = Place(0x6502)

_ROWS: tuple[tuple[Place, str, DataType, Access, str, int | None], ...] = (
    (DEVICE_TYPE, "Device type", _U32, _CONST, "", 0x0004_0192),
    (ERROR_REGISTER, "Error register", _U8, _RO, "", 0),
    (Place(0x1003, 0), "Number of errors", _U8, _RW, "", 0),
    (Place(0x1003, 1), "Standard error field", _U32, _RO, "", None),
    (Place(0x1016, 0), "Highest sub-index of consumer heartbeats", _U8, _CONST, "", 1),
    (CONSUMER_HEARTBEAT, "Consumer heartbeat time", _U32, _RW, "", 0),
    (PRODUCER_HEARTBEAT_MS, "Producer heartbeat time", _U16, _RW, "ms", 0),
    (Place(0x1018, 0), "Highest sub-index of the identity", _U8, _CONST, "", 4),
    (Place(0x1018, 1), "Vendor-ID", _U32, _CONST, "", 0),
    (Place(0x1018, 2), "Product code", _U32, _CONST, "", 0),
    (Place(0x1018, 3), "Revision number", _U32, _CONST, "", 0),
    (Place(0x1018, 4), "Serial number", _U32, _CONST, "", 0),
    (HEARTBEAT_REACTION, "Abort connection option code", _I16, _RW, "", 1),
    (ERROR_CODE, "Error code", _U16, _RO, "", 0),
    (CONTROLWORD, "Controlword", _U16, _RWW, "", 0),
    (STATUSWORD, "Statusword", _U16, _RO, "", 0),
    (QUICK_STOP_OPTION, "Quick stop option code", _I16, _RW, "", 2),
    (FAULT_REACTION_OPTION, "Fault reaction option code", _I16, _RW, "", 2),
    (MODE, "Modes of operation", _I8, _RWW, "", 0),
    (MODE_SHOWN, "Modes of operation display", _I8, _RO, "", 0),
    (POSITION, "Position actual value", _I32, _RO, "inc", 0),
    (FOLLOWING_ERROR_WINDOW, "Following error window", _U32, _RW, "inc", None),
    (FOLLOWING_ERROR_TIMEOUT_MS, "Following error time out", _U16, _RW, "ms", None),
    (TARGET_POSITION, "Target position", _I32, _RWW, "inc", 0),
    (Place(0x607D, 0), "Highest sub-index of the software limits", _U8, _CONST, "", 2),
    (Place(0x607D, 1), "Min position limit", _I32, _RW, "inc", None),
    (Place(0x607D, 2), "Max position limit", _I32, _RW, "inc", None),
    (PROFILE_SPEED, "Profile velocity", _U32, _RWW, "inc/s", None),
    (PROFILE_ACCELERATION, "Profile acceleration", _U32, _RWW, "inc/s2", None),
    (PROFILE_DECELERATION, "Profile deceleration", _U32, _RWW, "inc/s2", None),
    (QUICK_STOP_DECELERATION, "Quick stop deceleration", _U32, _RWW, "inc/s2", None),
    (Place(0x6098), "Homing method", _I8, _RW, "", 0),
    (Place(0x6099, 0), "Highest sub-index of the homing speeds", _U8, _CONST, "", 2),
    (Place(0x6099, 1), "Speed during search for switch", _U32, _RW, "inc/s", None),
    (Place(0x6099, 2), "Speed during search for zero", _U32, _RW, "inc/s", None),
    (Place(0x609A), "Homing acceleration", _U32, _RW, "inc/s2", None),
    (Place(0x60C2, 0), "Highest sub-index of the interpolation time", _U8, _CONST, "", 2),
    (Place(0x60C2, 1), "Interpolation time period value", _U8, _RW, "", 1),
    (Place(0x60C2, 2), "Interpolation time index", _I8, _RW, "power of ten s", -3),
    (FOLLOWING_ERROR, "Following error actual value", _I32, _RO, "inc", 0),
    (SUPPORTED_MODES, "Supported drive modes", _U32, _RO, "", 0),
)
_RECORDS = {
    0x1003: "Pre-defined error field",
    0x1016: "Consumer heartbeat time",
    0x1018: "Identity object",
    0x607D: "Software position limit",
    0x6099: "Homing speeds",
    0x60C2: "Interpolation time period",
}
_MAPPED = frozenset(
    (
        ERROR_REGISTER,
        ERROR_CODE,
        CONTROLWORD,
        STATUSWORD,
        MODE,
        MODE_SHOWN,
        POSITION,
        TARGET_POSITION,
        PROFILE_SPEED,
        PROFILE_ACCELERATION,
        PROFILE_DECELERATION,
        FOLLOWING_ERROR,
    )
)

STANDARD = Dictionary(
    (
        ObjectEntry(place, name, kind, access, unit, default, mappable=place in _MAPPED)
        for place, name, kind, access, unit, default in _ROWS
    ),
    _RECORDS,
)
"""What a drive of CiA 402 has, as far as arms use it; an EDS file tells what one really has."""
