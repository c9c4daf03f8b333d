"""How GRBL's numbers, axis letters and lines of text are checked, written and read.

GRBL reads a number as an optional sign, digits and one point, without an exponent. It keeps the
first eight digits, including leading zeros, as a float32 of 24 bits, about 7.2 digits (gnea/grbl
grbl/nuts_bolts.c, read_float). So a number is written here with at most eight digits, and at most
four decimals. Numbers beyond 16,777,216 are refused: a float32 does not hold every one of them.
"""

from __future__ import annotations

import re
from enum import StrEnum
from string import Formatter
from typing import overload

from firmware_protocol.errors import BadField
from firmware_protocol.fields import Rule, message, row_of

# Letters that the firmwares of this family can give to an axis, in the order they are written.
AXIS_LETTERS = "XYZABCUVW"
# The most decimals that are written; GRBL reports three.
DECIMALS = 4
# Of coordinates in reports.
COORDINATE_DECIMALS = 3
COORDINATE_MAX = 1e9
# Digits that GRBL reads of a number; it drops the others.
DIGITS = 8
# A float32 holds every whole number up to this one.
NUMBER_MAX = float(1 << 24)

_NUMBER = re.compile(r"[+-]?(?:([0-9]+)(?:\.([0-9]*))?|\.([0-9]+))")


def number(field: str, value: object, most: float = NUMBER_MAX) -> float:
    """Return a number of at most this size as it is, or raise `BadField`."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not -most <= value <= most:
        raise BadField(field, value, f"a finite number from {-most:g} to {most:g}")
    return value


def write_number(value: float) -> str:
    """Return a number as text, without trailing zeros."""
    whole_digits = len(str(int(abs(value))))
    text = f"{value:.{max(0, min(DECIMALS, DIGITS - whole_digits))}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def take_number(text: str, start: int) -> tuple[float, int] | None:
    """Read a number at `start` as GRBL does; return it and the index of its end, or None.

    Digits after the eighth are dropped. Before the point, zeros take their place.
    """
    found = _NUMBER.match(text, start)
    if found is None:
        return None
    whole_part, decimals = found[1] or "", found[2] or found[3] or ""
    kept = whole_part[:DIGITS] + "0" * max(0, len(whole_part) - DIGITS)
    kept_decimals = decimals[: max(0, DIGITS - len(whole_part))]
    value = float(f"{kept or '0'}.{kept_decimals or '0'}")
    return (-value if text[start] == "-" else value), found.end()


@message()
class Template:
    """The text of a message, such as `${setting}={value}`, with its fields in braces.

    Numbers are written as GRBL reads them, coordinates as it reports them.
    """

    form: str

    @overload
    def __get__(self, message: None, kind: type) -> Template: ...
    @overload
    def __get__(self, message: object, kind: type) -> str: ...
    def __get__(self, message: object | None, kind: type) -> Template | str:
        if message is None:
            return self
        names = (name for _, name, _, _ in Formatter().parse(self.form) if name)
        return self.form.format(**{name: written(getattr(message, name)) for name in names})


def written(value: object) -> str:
    """Return a field of a message as GRBL writes it."""
    if isinstance(value, tuple):
        whole = all(isinstance(each, int) for each in value)
        return ",".join(str(each) if whole else f"{each:.{COORDINATE_DECIMALS}f}" for each in value)
    return write_number(value) if isinstance(value, float) else str(value)


def printable(field: str, value: object) -> str:
    """Return printable ASCII text, or raise `BadField`."""
    if not isinstance(value, str) or not all(" " <= sign <= "~" for sign in value):
        raise BadField(field, value, "printable ASCII text")
    return value


def within(forbidden: str) -> Rule:
    """Return the rule of printable text without characters that mean something else."""

    def rule(field: str, value: object) -> str:
        text = printable(field, value)
        if any(sign in forbidden for sign in text):
            raise BadField(field, value, f"text without any of {forbidden}")
        return text

    return rule


# The rule of at least one coordinate.
coordinates = row_of(
    lambda field, value: number(field, value, COORDINATE_MAX),
    range(1, len(AXIS_LETTERS) + 1),
    f"1 to {len(AXIS_LETTERS)} numbers",
)


class Variant(StrEnum):
    """The firmware. grbl-Mega-5X identifies itself as GRBL."""

    GRBL = "Grbl"
    GRBLHAL = "GrblHAL"
    FLUIDNC = "FluidNC"


@message()
class Dialect:
    """What one build of a firmware understands.

    `max_line` counts characters without the line end. With `outputs`, M64 to M68 are allowed.
    """

    variant: Variant = Variant.GRBL
    axes: str = "XYZ"
    max_line: int = 79
    outputs: bool = False
    single_axis_homing: bool = False
    named_settings: bool = False
    """Whether settings have names with slashes. Observed on FluidNC."""
    drops_brackets: bool = False
    """Whether a closing bracket that ends no comment is dropped; GRBL refuses it as a word without
    a letter. Observed on grblHAL and FluidNC.
    """

    def __post_init__(self) -> None:
        axes = self.axes
        if not isinstance(axes, str) or not axes or not set(axes) <= set(AXIS_LETTERS):
            raise BadField("axes", axes, f"letters out of {AXIS_LETTERS}")
        if len(set(axes)) != len(axes):
            raise BadField("axes", axes, "letters that differ from one another")


GRBL = Dialect()
GRBLHAL = Dialect(
    Variant.GRBLHAL,
    "XYZABC",
    max_line=256,
    outputs=True,
    single_axis_homing=True,
    drops_brackets=True,
)
FLUIDNC = Dialect(
    Variant.FLUIDNC,
    "XYZABC",
    max_line=127,
    outputs=True,
    single_axis_homing=True,
    named_settings=True,
    drops_brackets=True,
)
