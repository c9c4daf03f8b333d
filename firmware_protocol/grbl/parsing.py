"""A received line and what it asks for: nothing, a `$` command, a block, or a refusal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.grbl.commands import SystemCommand
from firmware_protocol.grbl.dialect import Dialect, Variant
from firmware_protocol.grbl.gcode import Block, GcodeError, parse_block
from firmware_protocol.grbl.system import (
    SETTING_MAX,
    CheckMode,
    Help,
    Home,
    QueryBuildInfo,
    QueryParameters,
    QueryParserState,
    QuerySettings,
    QueryStartupLines,
    Restore,
    SetSetting,
    Sleep,
    StoreBuildInfo,
    StoreStartupLine,
    Unlock,
)
from firmware_protocol.grbl.words import take_number

GRBL_SETTING_MAX = 255
OVERLONG = 11
"""The error of a line that is too long."""
_JOG = "$J="


@dataclass(frozen=True, slots=True)
class Empty:
    """A line of nothing, or of a comment; its answer is an ok."""


@dataclass(frozen=True, slots=True)
class Rejected:
    """A line that is refused whatever the state: the code to answer with, and why."""

    code: int
    reason: str


Content: TypeAlias = Empty | SystemCommand | Block | Rejected


def parse_line(text: str, dialect: Dialect) -> Content:
    """Read a cleaned line. What depends on the machine's state (errors 8 and 9) is not looked at.

    The modes in force are not looked at either: `Modal.after` does.
    """
    if len(text) > dialect.max_line:
        return Rejected(OVERLONG, f"a line of more than {dialect.max_line} characters")
    if not text:
        return Empty()
    try:
        if text.startswith(_JOG):
            return parse_block(text[len(_JOG) :], dialect, jog=True)
        return _system(text, dialect) if text.startswith("$") else parse_block(text, dialect)
    except GcodeError as error:
        return Rejected(error.code, str(error))
    except LocalProtocolError as error:  # a value that no message of ours can hold
        return Rejected(3, str(error))


_PLAIN: dict[str, Callable[[], SystemCommand]] = {
    "$": Help,
    "$$": QuerySettings,
    "$I": QueryBuildInfo,
    "$#": QueryParameters,
    "$G": QueryParserState,
    "$N": QueryStartupLines,
    "$X": Unlock,
    "$C": CheckMode,
    "$SLP": Sleep,
}
_KNOWN_LETTERS = "$GCXJ#HSIR"
"""What stands behind the `$` of commands; any other sign begins the number of a setting."""


def _system(text: str, dialect: Dialect) -> SystemCommand:
    plain = _PLAIN.get(text)
    if plain is not None:
        return plain()
    if text.startswith("$H"):
        return _home(text[2:], dialect)
    if text.startswith("$RST=") and len(text) == len("$RST=") + 1:
        return Restore(text[-1])
    if text.startswith("$I="):
        return StoreBuildInfo(text[3:])
    if text[1] in _KNOWN_LETTERS:
        raise GcodeError(3, text)
    if text[1] == "N":
        which, at = _key(text, 2)
        return StoreStartupLine(which, text[at:])
    return _setting(text, dialect)


def _home(letters: str, dialect: Dialect) -> Home:
    most = len(dialect.axes) if dialect.variant is Variant.GRBLHAL else 1
    allowed = most if dialect.single_axis_homing else 0
    if len(letters) > allowed or not set(letters) <= set(dialect.axes):
        raise GcodeError(3, f"$H{letters}")
    return Home(letters)


def _setting(text: str, dialect: Dialect) -> SetSetting:
    key, at = _key(text, 1)
    taken = take_number(text, at)
    if taken is None:
        raise GcodeError(2, text)
    value, end = taken
    most = GRBL_SETTING_MAX if dialect.variant is Variant.GRBL else SETTING_MAX
    if end != len(text) or key > most:
        raise GcodeError(3, text)
    return SetSetting(key, value)


def _key(text: str, start: int) -> tuple[int, int]:
    """Read the number before an equals sign; return it and where the value begins."""
    taken = take_number(text, start)
    if taken is None:
        raise GcodeError(2, text)
    value, at = taken
    if text[at : at + 1] != "=" or value < 0:
        raise GcodeError(3, text)
    return int(value), at + 1
