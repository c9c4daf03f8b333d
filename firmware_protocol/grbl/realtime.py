"""GRBL's real-time commands: single bytes, picked out of the stream at once and never counted.

Sources: gnea/grbl doc/markdown/commands.md and grbl/serial.c; grblHAL/core grbl.h.
"""

from __future__ import annotations

from enum import IntEnum


class Realtime(IntEnum):
    """One byte each; legal at any time, with no `ok`."""

    SOFT_RESET = 0x18
    """Empties ring and planner; in motion it raises ALARM:3. A banner follows."""
    STOP = 0x19
    """grblHAL only."""
    FEED_HOLD = ord("!")
    STATUS = ord("?")
    RESUME = ord("~")
    STATUS_ALIAS = 0x80
    """grblHAL only, as are the next three."""
    RESUME_ALIAS = 0x81
    FEED_HOLD_ALIAS = 0x82
    PARSER_STATE = 0x83
    SAFETY_DOOR = 0x84
    JOG_CANCEL = 0x85
    """Ignored unless the state is Jog already; on GRBL it does not clear unread lines."""
    FULL_STATUS = 0x87
    """grblHAL only, as are the next five."""
    OPTIONAL_STOP = 0x88
    SINGLE_BLOCK = 0x89
    FAN = 0x8A
    PENDANT_MODE = 0x8B
    AUTO_REPORT = 0x8C
    FEED_100 = 0x90
    FEED_PLUS_10 = 0x91
    FEED_MINUS_10 = 0x92
    FEED_PLUS_1 = 0x93
    FEED_MINUS_1 = 0x94
    RAPID_100 = 0x95
    RAPID_50 = 0x96
    RAPID_25 = 0x97
    SPINDLE_100 = 0x99
    SPINDLE_PLUS_10 = 0x9A
    SPINDLE_MINUS_10 = 0x9B
    SPINDLE_PLUS_1 = 0x9C
    SPINDLE_MINUS_1 = 0x9D
    SPINDLE_STOP = 0x9E
    FLOOD_TOGGLE = 0xA0
    MIST_TOGGLE = 0xA1
    PID_REPORT = 0xA2
    """grblHAL only, as are the next two."""
    TOOL_ACKNOWLEDGE = 0xA3
    PROBE_TOGGLE = 0xA4


GRBLHAL_ONLY = frozenset(
    {
        Realtime.STOP,
        Realtime.STATUS_ALIAS,
        Realtime.RESUME_ALIAS,
        Realtime.FEED_HOLD_ALIAS,
        Realtime.PARSER_STATE,
        Realtime.FULL_STATUS,
        Realtime.OPTIONAL_STOP,
        Realtime.SINGLE_BLOCK,
        Realtime.FAN,
        Realtime.PENDANT_MODE,
        Realtime.AUTO_REPORT,
        Realtime.PID_REPORT,
        Realtime.TOOL_ACKNOWLEDGE,
        Realtime.PROBE_TOGGLE,
    }
)
"""What GRBL 1.1 itself does not have."""

_BY_BYTE = {int(member): member for member in Realtime}
_EXTENDED = 0x80


def realtime_of(byte: int, *, grblhal: bool = False) -> Realtime | None:
    """Return the real-time command of a byte on this firmware, or None where it is none."""
    member = _BY_BYTE.get(byte)
    return None if member in GRBLHAL_ONLY and not grblhal else member


def is_picked_out(byte: int, *, grblhal: bool = False) -> bool:
    """Tell whether a byte never reaches the ring: a real-time command, or any over 0x7F.

    Those over 0x7F that mean nothing are thrown away.
    """
    return byte >= _EXTENDED or realtime_of(byte, grblhal=grblhal) is not None


def split_realtime(data: bytes, *, grblhal: bool = False) -> tuple[tuple[Realtime, ...], bytes]:
    """Part a stream, as the receive interrupt does: the real-time commands, and the other bytes.

    Any chunking gives the same two sequences.
    """
    found = (realtime_of(byte, grblhal=grblhal) for byte in data)
    rest = bytes(byte for byte in data if not is_picked_out(byte, grblhal=grblhal))
    return tuple(member for member in found if member is not None), rest
