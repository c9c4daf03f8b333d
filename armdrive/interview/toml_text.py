"""Writing TOML for people: values, and sections whose lines carry comments.

Plain text is written rather than a document edited, so that no further library is needed.
"""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

COMMENT_AT = 30
"""The column that comments begin in, where the line before them is shorter."""

WIDTH = 96
"""The longest line of a heading."""

_BARE = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True, slots=True)
class Entry:
    """One key with its value, and what a reader should know of it."""

    key: str
    value: Any
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Section:
    """A table of a document; the first one has no name, and one of an array says so."""

    name: str
    entries: tuple[Entry, ...]
    comment: str = ""
    array: bool = field(default=False)


def document(sections: Iterable[Section], heading: str = "") -> str:
    """Return the text of a document, one line at the end."""
    lines = [each for line in heading.splitlines() for each in textwrap.wrap(line, WIDTH)]
    blocks = ["\n".join(f"# {line}" for line in lines)] if lines else []
    blocks += [_section(each) for each in sections if each.entries]
    return "\n\n".join(blocks) + "\n"


def _section(section: Section) -> str:
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


def key(name: str) -> str:
    """Return a key, quoted where it is no single word."""
    return name if _BARE.fullmatch(name) else value(name)


def value(given: Any) -> str:
    """Return a value as TOML: text, numbers, true and false, lists, inline tables."""
    if isinstance(given, bool):
        return "true" if given else "false"
    if isinstance(given, str):
        return json.dumps(given, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(given, float):
        return _float(given)
    if isinstance(given, Mapping):
        inside = ", ".join(f"{key(name)} = {value(one)}" for name, one in given.items())
        return f"{{ {inside} }}"
    if isinstance(given, list | tuple):
        return f"[{', '.join(map(value, given))}]"
    return str(given)


def _float(given: float) -> str:
    """Return the shortest text that reads back as the same number."""
    if given == int(given) and abs(given) < 1e15:
        return str(int(given))
    return repr(given)
