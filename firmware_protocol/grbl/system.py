"""GRBL's `$` commands, as a host sends them and as a device reads them."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.errors import BadField, whole
from firmware_protocol.grbl.words import AXIS_LETTERS, line_text, number, write_number

SETTING_MAX = 65535
"""GRBL's settings end at 255; grblHAL has more."""
STARTUP_LINES = 2
RESTORABLE = "$#*"


class _Plain:
    """A command that takes nothing; equal to every other one of its class."""

    __slots__ = ()
    _text = ""

    @property
    def text(self) -> str:
        """The line without its end."""
        return self._text


@dataclass(frozen=True, slots=True)
class Help(_Plain):
    """Ask which commands there are."""

    _text = "$"


@dataclass(frozen=True, slots=True)
class QuerySettings(_Plain):
    """Ask for all settings."""

    _text = "$$"


@dataclass(frozen=True, slots=True)
class QueryBuildInfo(_Plain):
    """Ask for version, options, ring size and, on some firmwares, the axes."""

    _text = "$I"


@dataclass(frozen=True, slots=True)
class QueryParameters(_Plain):
    """Ask for the offsets of all coordinate systems."""

    _text = "$#"


@dataclass(frozen=True, slots=True)
class QueryParserState(_Plain):
    """Ask for the modes in force."""

    _text = "$G"


@dataclass(frozen=True, slots=True)
class QueryStartupLines(_Plain):
    """Ask for the lines that are executed at every start."""

    _text = "$N"


@dataclass(frozen=True, slots=True)
class Unlock(_Plain):
    """Leave the alarm state. Moves nothing; the position may still be wrong."""

    _text = "$X"


@dataclass(frozen=True, slots=True)
class CheckMode(_Plain):
    """Enter or leave the mode in which lines are checked and nothing moves; leaving it resets."""

    _text = "$C"


@dataclass(frozen=True, slots=True)
class Sleep(_Plain):
    """Switch the motors off until a reset; an arm sags."""

    _text = "$SLP"


@dataclass(frozen=True, slots=True)
class Home:
    """Home all axes, or the ones named, where the firmware can: GRBL takes one letter."""

    axes: str = ""

    def __post_init__(self) -> None:
        fits = isinstance(self.axes, str) and set(self.axes) <= set(AXIS_LETTERS)
        if not fits or len(set(self.axes)) != len(self.axes):
            raise BadField("axes", self.axes, f"different letters out of {AXIS_LETTERS}, or none")

    @property
    def text(self) -> str:
        """The line without its end."""
        return f"$H{self.axes}"


@dataclass(frozen=True, slots=True)
class SetSetting:
    """Write one setting into EEPROM."""

    setting: int
    value: float

    def __post_init__(self) -> None:
        whole("setting", self.setting, 0, SETTING_MAX)
        number("value", self.value)

    @property
    def text(self) -> str:
        """The line without its end."""
        return f"${self.setting}={write_number(self.value)}"


@dataclass(frozen=True, slots=True)
class StoreStartupLine:
    """Write a line of g-code that is executed at every start."""

    which: int
    line: str

    def __post_init__(self) -> None:
        whole("which", self.which, 0, STARTUP_LINES - 1)
        line_text("line", self.line)

    @property
    def text(self) -> str:
        """The line without its end."""
        return f"$N{self.which}={self.line}"


@dataclass(frozen=True, slots=True)
class StoreBuildInfo:
    """Write the owner's text that `$I` shows."""

    note: str

    def __post_init__(self) -> None:
        line_text("note", self.note)

    @property
    def text(self) -> str:
        """The line without its end."""
        return f"$I={self.note}"


@dataclass(frozen=True, slots=True)
class Restore:
    """Put defaults back: of the settings (`$`), the coordinate systems (`#`), or all (`*`)."""

    what: str = "$"

    def __post_init__(self) -> None:
        if not isinstance(self.what, str) or len(self.what) != 1 or self.what not in RESTORABLE:
            raise BadField("what", self.what, f"one of {RESTORABLE}")

    @property
    def text(self) -> str:
        """The line without its end."""
        return f"$RST={self.what}"
