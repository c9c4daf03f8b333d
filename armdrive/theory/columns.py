"""Sections laid in columns of a given height, as a newspaper's: pure, tested without a screen."""

from __future__ import annotations

from collections.abc import Iterable

from kinematics.worked_text import Section

Column = tuple[str, ...]

RULE = "\N{BOX DRAWINGS LIGHT HORIZONTAL}"
PLAIN_RULE = "-"


def laid(
    sections: Iterable[Section], width: int, height: int, *, plain: bool = False
) -> tuple[Column, ...]:
    """Return the columns that hold all sections in order, none higher than `height` lines.

    A section that does not fit in what is left begins a column of its own, unless it would not
    fit in a whole one either: then it begins at once and goes on in the next.
    """
    height = max(height, 2)
    columns: list[list[str]] = [[]]
    for section in sections:
        lines = [heading(section.title, width, plain=plain), *section.lines]
        if len(columns[-1]) + len(lines) > height and columns[-1]:
            left = height - len(columns[-1])
            if len(lines) <= height or left < height // 2:
                columns.append([])
        for line in lines:
            if len(columns[-1]) == height:
                columns.append([])
            columns[-1].append(line)
    return tuple(map(tuple, columns))


def heading(title: str, width: int, *, plain: bool = False) -> str:
    """Return a title with a rule to the end of its line."""
    rule = PLAIN_RULE if plain else RULE
    return f"{rule}{rule} {title} ".ljust(width, rule)[:width]
