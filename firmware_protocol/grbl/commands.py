"""A host's lines to a GRBL board, and its real-time commands.

A driver sends `$` commands and its own g-code (`Line`): only the driver knows how many digits of
the board's unit resolve a motor step. A board reads g-code with `gcode`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import Enum, IntEnum
from types import MappingProxyType
from typing import TypeAlias

from firmware_protocol.errors import BadField
from firmware_protocol.fields import message, whole_from
from firmware_protocol.grbl.dialect import (
    AXIS_LETTERS,
    Template,
    Variant,
    number,
    within,
)

# GRBL's settings end at 255; grblHAL has more.
SETTING_MAX = 65535


class SystemCommand(Enum):
    """A `$` line without arguments.

    Neither end uses help (`$`), coordinate systems (`$#`), start-up lines (`$N`), notes (`$I=`) and
    factory resets (`$RST`).
    """

    QUERY_SETTINGS = "$$"
    QUERY_BUILD = "$I"
    """Ask for version, options, buffer size and, on some firmware, the axes."""
    QUERY_MODES = "$G"
    UNLOCK = "$X"
    """Leave the alarm state. Moves nothing; the position may still be wrong."""
    CHECK_MODE = "$C"
    """Enter or leave check mode, in which nothing moves; leaving it resets the board."""
    SLEEP = "$SLP"
    """Switch the motors off until a reset; an arm sags."""

    @property
    def text(self) -> str:
        """The line without its end."""
        return self.value


@message()
class Home:
    """Home all axes, or those named if the firmware supports it; GRBL takes one letter."""

    axes: str = ""

    def __post_init__(self) -> None:
        fits = isinstance(self.axes, str) and set(self.axes) <= set(AXIS_LETTERS)
        if not fits or len(set(self.axes)) != len(self.axes):
            raise BadField("axes", self.axes, f"different letters out of {AXIS_LETTERS}, or none")

    text = Template("$H{axes}")


@message(setting=whole_from(0, SETTING_MAX), value=number)
class SetSetting:
    """Write a setting to EEPROM."""

    setting: int
    value: float

    text = Template("${setting}={value}")


@message(text=within("?!~"))
class Line:
    """Any text, such as g-code; an empty line only asks for an `ok`.

    The board would take `?`, `!` and `~` out of any line, as real-time commands.
    """

    text: str = ""


Command: TypeAlias = SystemCommand | Home | SetSetting | Line


# Real-time commands: single bytes, picked out of the stream at once and never counted.
#
# Sources: gnea/grbl doc/markdown/commands.md and grbl/serial.c; grblHAL/core grbl.h.


class Realtime(IntEnum):
    """One byte each; legal at any time, with no `ok`.

    Those that neither the driver nor the simulated board uses are left out: they are over 0x7F, so
    a board throws them away.
    """

    SOFT_RESET = 0x18
    """Empties ring and planner; in motion it raises ALARM:3. A banner follows."""
    STOP = 0x19
    """grblHAL only."""
    FEED_HOLD = ord("!")
    STATUS = ord("?")
    RESUME = ord("~")
    STATUS_ALIAS = 0x80
    """grblHAL only, as are the next two."""
    RESUME_ALIAS = 0x81
    FEED_HOLD_ALIAS = 0x82
    SAFETY_DOOR = 0x84
    JOG_CANCEL = 0x85
    """Ignored unless the state is Jog already; on GRBL it does not clear unread lines."""
    FULL_STATUS = 0x87
    """grblHAL only."""
    FEED_100 = 0x90
    FEED_PLUS_10 = 0x91
    FEED_MINUS_10 = 0x92
    FEED_PLUS_1 = 0x93
    FEED_MINUS_1 = 0x94


# What GRBL 1.1 itself does not have.
GRBLHAL_ONLY = frozenset(
    {
        Realtime.STOP,
        Realtime.STATUS_ALIAS,
        Realtime.RESUME_ALIAS,
        Realtime.FEED_HOLD_ALIAS,
        Realtime.FULL_STATUS,
    }
)

_GRBL = {int(member): member for member in Realtime if member not in GRBLHAL_ONLY}
_BY_BYTE: Mapping[Variant, Mapping[int, Realtime]] = MappingProxyType(
    {
        Variant.GRBL: _GRBL,
        Variant.GRBLHAL: {int(member): member for member in Realtime},
        Variant.FLUIDNC: _GRBL,
    }
)
_EXTENDED = 0x80


def pieces(data: bytes, variant: Variant = Variant.GRBL) -> Iterator[bytes | Realtime]:
    """Yield the text and the real-time commands of a stream, in their order.

    The receive interrupt picks a byte out of any line if it is a real-time command of this
    firmware, or over 0x7F. Those over 0x7F that mean nothing are thrown away.
    """
    commands, start = _BY_BYTE[variant], 0
    for at, byte in enumerate(data):
        command = commands.get(byte)
        if command is None and byte < _EXTENDED:
            continue
        if start < at:
            yield data[start:at]
        if command is not None:
            yield command
        start = at + 1
    if start < len(data):
        yield data[start:]


def split_realtime(
    data: bytes, variant: Variant = Variant.GRBL
) -> tuple[tuple[Realtime, ...], bytes]:
    """Return the real-time commands of a stream, and its text.

    Any chunking gives the same two sequences.
    """
    found = list(pieces(data, variant))
    commands = tuple(piece for piece in found if isinstance(piece, Realtime))
    return commands, b"".join(piece for piece in found if isinstance(piece, bytes))
