"""One line of g-code read into a block, as GRBL's parser does in its step 2.

What is wrong with the words alone is found here; what depends on the modes in force is found in
modes.py. A block that is refused carries the number that GRBL answers with.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.grbl.codes import error_code
from firmware_protocol.grbl.dialect import Dialect
from firmware_protocol.grbl.gtable import (
    BAD_DECIMALS_UNSUPPORTED,
    COMMANDS,
    LINE_NUMBER_MAX,
    NOT_NEGATIVE,
    OUTPUT_LETTERS,
    TOOL_MAX,
    VALUE_LETTERS,
    WHOLE_COMMANDS,
    AxisUse,
    Group,
    Word,
)
from firmware_protocol.grbl.words import take_number


class GcodeError(RemoteProtocolError):
    """The host sent a line that GRBL refuses with `code`."""

    def __init__(self, code: int, detail: str = "") -> None:
        self.code = code
        meaning = error_code(code).meaning
        super().__init__(f"error {code}: {meaning}{f' ({detail})' if detail else ''}")


@dataclass(frozen=True, slots=True)
class Block:
    """The words of one line: commands by group, axis words, and the other values by letter.

    Numbers are as they were written, in whatever unit is in force. `axis_use` is what an explicit
    command wants the axis words for. `jog` marks what stood behind `$J=`.
    """

    commands: Mapping[Group, str] = field(default_factory=dict, hash=False)
    axes: Mapping[str, float] = field(default_factory=dict, hash=False)
    values: Mapping[str, float] = field(default_factory=dict, hash=False)
    axis_use: AxisUse | None = None
    jog: bool = False

    def __post_init__(self) -> None:
        for name in ("commands", "axes", "values"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    @property
    def motion_use(self) -> bool:
        """Tell whether axis words, where there are any, are the target of a motion."""
        return self.axis_use is AxisUse.MOTION or (self.axis_use is None and bool(self.axes))


def parse_block(text: str, dialect: Dialect, *, jog: bool = False) -> Block:
    """Read the words of a cleaned line; raises `GcodeError`."""
    commands: dict[Group, str] = {}
    axes: dict[str, float] = {}
    values: dict[str, float] = {}
    use: AxisUse | None = None
    at = 0
    while at < len(text):
        letter = text[at]
        if not "A" <= letter <= "Z":
            raise GcodeError(1, letter)
        taken = take_number(text, at + 1)
        if taken is None:
            raise GcodeError(2, letter)
        value, at = taken
        if letter in "GM":
            word = _command(letter, value, dialect)
            use = _claimed(use, word)
            if word.group in commands:
                raise GcodeError(21, word.name)
            commands[word.group] = word.name
        else:
            _store(letter, value, dialect, axes, values)
    if values.get("N", 0) > LINE_NUMBER_MAX:
        raise GcodeError(27)
    return Block(commands, axes, values, use, jog)


def _command(letter: str, value: float, dialect: Dialect) -> Word:
    """Find a command word; hundredths are what GRBL tells decimals by."""
    whole_part = int(value)
    hundredths = round(100 * (value - whole_part))
    stem = f"{letter}{whole_part}"
    if value < 0 or stem not in WHOLE_COMMANDS:
        raise GcodeError(20, stem)
    name = stem if hundredths == 0 else f"{stem}.{hundredths:02d}".rstrip("0")
    word = COMMANDS.get(name)
    if word is None:
        raise GcodeError(20 if stem in BAD_DECIMALS_UNSUPPORTED else 23, name)
    if word.outputs_only and not dialect.outputs:
        raise GcodeError(20, name)
    return word


def _claimed(use: AxisUse | None, word: Word) -> AxisUse | None:
    if word.axis_use is None:
        return use
    if use is not None:
        raise GcodeError(24, word.name)
    return word.axis_use


def _store(
    letter: str,
    value: float,
    dialect: Dialect,
    axes: dict[str, float],
    values: dict[str, float],
) -> None:
    """Keep a value word, once."""
    into = axes if letter in dialect.axes else values
    known = VALUE_LETTERS | OUTPUT_LETTERS if dialect.outputs else VALUE_LETTERS
    if into is values and letter not in known:
        raise GcodeError(20, letter)
    if letter == "T" and value > TOOL_MAX:
        raise GcodeError(38)
    if letter in into:
        raise GcodeError(25, letter)
    if letter in NOT_NEGATIVE and value < 0:
        raise GcodeError(4, letter)
    into[letter] = value
