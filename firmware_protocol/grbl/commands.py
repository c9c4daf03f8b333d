"""A host's lines to a GRBL board, and its real-time commands.

A driver sends `$` commands and its own g-code (`Line`): only the driver knows how many digits of
the board's unit resolve a motor step. A board reads g-code with `gcode`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from enum import Enum, IntEnum
from types import MappingProxyType
from typing import TypeAlias

from firmware_protocol.errors import BadField
from firmware_protocol.fields import message, whole_from
from firmware_protocol.grbl.dialect import AXIS_LETTERS, Template, number, within

# GRBL's settings end at 255; grblHAL has more.
SETTING_MAX = 65535


class SystemCommand(Enum):
    """A `$` line without arguments, out of those that the driver sends."""

    QUERY_SETTINGS = "$$"
    QUERY_BUILD = "$I"
    """Ask for version, options, buffer size and, on some firmware, the axes."""
    UNLOCK = "$X"
    """Leave the alarm state. Moves nothing; the position may still be wrong."""
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
# Sources: gnea/grbl doc/markdown/commands.md and grbl/serial.c.


class Realtime(IntEnum):
    """One byte each; legal at any time, with no `ok`.

    Those that the driver does not send are left out: they are over 0x7F, so a board throws them
    away.
    """

    SOFT_RESET = 0x18
    """Empties ring and planner; in motion it raises ALARM:3. A banner follows."""
    FEED_HOLD = ord("!")
    STATUS = ord("?")
    RESUME = ord("~")
    JOG_CANCEL = 0x85
    """Ignored unless the state is Jog already; on GRBL it does not clear unread lines."""
    FEED_100 = 0x90
    """Ends a feed override."""


_PICKED = re.compile(rb"[\x18!?~\x80-\xff]|[^\x18!?~\x80-\xff]+")
_BY_BYTE: Mapping[bytes, Realtime] = MappingProxyType(
    {bytes((command,)): command for command in Realtime}
)


def pieces(data: bytes) -> Iterator[bytes | Realtime]:
    """Yield the text and the real-time commands of a stream, in their order.

    The receive interrupt picks a byte out of any line if it is a real-time command, or over 0x7F.
    Those over 0x7F that mean nothing are thrown away.
    """
    for piece in _PICKED.findall(data):
        if piece in _BY_BYTE:
            yield _BY_BYTE[piece]
        elif piece < b"\x80":
            yield piece
