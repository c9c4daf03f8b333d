"""A TOML document for people: sections whose lines carry comments.

Plain text is written rather than a document edited, so that no further library is needed.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from armdrive.text.toml import FORMAT, FORMAT_KEY, key, value

COMMENT_AT = 30
"""The column that comments begin in, where the line before them is shorter."""

WIDTH = 96
"""The longest line of a heading."""


@dataclass(frozen=True, slots=True)
class TomlEntry:
    """One key with its value, and what a reader should know of it."""

    key: str
    value: Any
    comment: str = ""


FORMAT_ENTRY = TomlEntry(FORMAT_KEY, FORMAT)
"""The first key of every file that armdrive writes for people."""


@dataclass(frozen=True, slots=True)
class TomlSection:
    """A table of a document; the first one has no name, and one of an array says so."""

    name: str
    entries: tuple[TomlEntry, ...]
    comment: str = ""
    array: bool = field(default=False)


def document(sections: Iterable[TomlSection], heading: str = "") -> str:
    """Return the text of a document, one line at the end."""
    lines = [each for line in heading.splitlines() for each in textwrap.wrap(line, WIDTH)]
    blocks = ["\n".join(f"# {line}" for line in lines)] if lines else []
    blocks += [_section(each) for each in sections if each.entries]
    return "\n\n".join(blocks) + "\n"


def _section(section: TomlSection) -> str:
    lines = []
    if section.name:
        brackets = f"[[{section.name}]]" if section.array else f"[{section.name}]"
        lines.append(_commented(brackets, section.comment))
    lines += [
        _commented(f"{key(each.key)} = {value(each.value)}", each.comment)
        for each in section.entries
    ]
    return "\n".join(lines)


def _commented(line: str, comment: str) -> str:
    return f"{line.ljust(COMMENT_AT - 1)} # {comment}" if comment else line
