"""Text for people: quantities with their decimals, counts with nouns, columns, folded lines."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence


def counted(count: int, one: str, several: str = "") -> str:
    """Return a count of things: `1 act`, `2 acts`, `3 axes`.

    `several` is the plural, unless it only adds an s. Both may have a verb: `row is`, `rows are`.
    """
    return f"{count} {one if count == 1 else several or f'{one}s'}"


def shown_name(name: str) -> str:
    """Return the name of a joint, axis or field for people: `wrist_pitch` is `wrist pitch`."""
    return name.replace("_", " ")


def sentence(words: str) -> str:
    """Return words as a sentence, with a capital letter and a full stop."""
    return f"{words[0].upper()}{words[1:].rstrip('.')}."


def rounded(value: float, digits: int) -> str:
    """Format with this many decimals, without the minus sign of a rounded zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}"


def plain(value: float, digits: int) -> str:
    """Format with at most this many decimals, without trailing zeros or a minus before zero."""
    text = rounded(value, digits)
    return text.rstrip("0").rstrip(".") if "." in text else text


# Lengths and angles as people read them.


def tenths(value: float) -> str:
    """Format mm or degrees, without the unit: one decimal is about a motor step of these arms."""
    return rounded(value, 1)


def mm_text(length_mm: float) -> str:
    """Format a length with its unit."""
    return f"{tenths(length_mm)} mm"


def deg_text(angle_deg: float) -> str:
    """Format an angle with its unit."""
    return f"{tenths(angle_deg)}°"


def joint_text(value: float, unit: str) -> str:
    """Format the value of a joint that is in `unit`: "rad" of one that turns, else "mm"."""
    return deg_text(math.degrees(value)) if unit == "rad" else mm_text(value)


def beyond(value: float, bound: float, unit: str = "rad", what: str = "limit") -> str:
    """Say by how much a joint's value is beyond its limit, both in `unit`."""
    far, most = joint_text(abs(value - bound), unit), joint_text(bound, unit)
    return f"{far} beyond its {what} of {most}"


def significant(value: float) -> str:
    """Format with three digits that count, without an exponent for what is large."""
    return f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}"


def aligned(cells: Sequence[Sequence[str]], *, left: int = 0) -> list[str]:
    """Return rows of cells as lines of aligned columns, the first `left` of them flush left."""
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    sides = [str.ljust] * left + [str.rjust] * (len(widths) - left)
    return [
        "  ".join(side(cell, width) for side, cell, width in zip(sides, row, widths, strict=True))
        for row in cells
    ]


def folded(line: str, width: int) -> list[str]:
    """Return a line as rows of at most `width` characters, broken at spaces.

    A word is broken only if it is longer than a row. The further rows begin below the last column
    of the line, which two spaces or more divide from what precedes it, if it has enough room
    there; else two columns further in than the line itself.
    """
    if len(line) <= width:
        return [line]
    own = len(line) - len(line.lstrip())
    columns = [found.end() for found in re.finditer(r"(?<=\S)  +(?=\S)", line)]
    column = max((at for at in columns if at <= width * _LAST_COLUMN), default=0)
    longest = max(map(len, line[column:].split()), default=0)
    indent = min(column or own + 2, max(width - longest, 0))
    rows = textwrap.wrap(line, width, subsequent_indent=" " * indent, break_on_hyphens=False)
    return rows or [""]


# The share of the width up to which a column has enough room for words.
_LAST_COLUMN = 0.7


def filled(text: str, width: int) -> list[str]:
    """Return a paragraph as rows of at most `width` characters, broken like folded lines."""
    return textwrap.wrap(text, width, break_on_hyphens=False)
