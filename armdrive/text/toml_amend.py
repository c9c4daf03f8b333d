"""Changing single keys of a TOML file that a person keeps; everything else stays as it stands.

tomlkit keeps comments, empty lines and the order of keys. Only what changes an arm file imports
this module, since tomlkit takes 40 ms to load.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import tomlkit
from tomlkit.container import Container
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import InlineTable, Item, SingleKey, Table

from armdrive.errors import ArmFileError
from armdrive.text.toml import COMMENT_AT, require_format, value


@dataclass(frozen=True, slots=True)
class Change:
    """One key of a file, its new value, and why: tables of an array are reached by their index."""

    path: tuple[str | int, ...]
    value: Any
    why: str = ""

    @property
    def name(self) -> str:
        """The key as people write it."""
        return ".".join(map(str, self.path))


def amended(text: str, changes: Iterable[Change]) -> str:
    """Return the text with these keys changed.

    A key keeps its comment; one without a comment gets the reason. Raises `ArmFileError` where the
    format is not understood, or the text could not be changed.
    """
    wanted = tomllib.loads(text)
    require_format(wanted)
    changes = tuple(changes)
    try:
        found = tomlkit.parse(text if text.endswith("\n") else f"{text}\n")
        for change in changes:
            _put(found, change)
            _put_plain(wanted, change)
        # read back, and compared with the same changes made to plain data: tomlkit puts some keys
        # of unusual layouts into the wrong table
        after = found.as_string()
        whole = tomllib.loads(after) == wanted
    except (TOMLKitError, ValueError, LookupError, TypeError, AttributeError):
        whole = False
    if not whole:
        by_hand = "; ".join(f"{each.name} = {value(each.value)}" for each in changes)
        raise ArmFileError(
            "the arm file is laid out in a way that cannot be edited here: write by hand, in an "
            f"editor, {by_hand}"
        )
    return after if after.endswith("\n") else f"{after}\n"


def _put_plain(table: Any, change: Change) -> None:
    """Make a change in plain data, which the changed text is compared with."""
    for step in change.path[:-1]:
        table = table.setdefault(step, {}) if isinstance(step, str) else table[step]
    table[change.path[-1]] = tomllib.loads(f"value = {value(change.value)}")["value"]


def _put(found: Container, change: Change) -> None:
    table: Any = found
    for step in change.path[:-1]:
        if isinstance(step, str) and step not in table:
            table.add(step, tomlkit.table())
        table = table[step]
    key = change.path[-1]
    item = tomlkit.value(value(change.value))
    inline = isinstance(table, InlineTable | list)
    is_new = key not in table
    if change.why and not inline and (is_new or not table[key].trivia.comment):
        item.comment(change.why)
        written = len(f"{SingleKey(str(key)).as_string()} = {item.as_string()}")
        item.trivia.comment_ws = " " * max(COMMENT_AT - written, 1)
    if is_new and not inline:
        add_last(table, str(key), item)
    else:
        table[key] = item


def add_last(table: Table | Container, key: str, item: Item) -> None:
    """Add a key after the last one of a table, above comments: those are of the next table."""
    table.add(SingleKey(key), item)
    body = table.value.body if isinstance(table, Table) else table.body
    at = next(at for at, (each, _) in enumerate(body) if each == SingleKey(key))
    last = at
    while last and body[last - 1][0] is None:
        last -= 1
    if last < at:
        if at + 1 < len(body):  # tomlkit has put an empty line between the key and a table
            below = body[at + 1][1].trivia
            below.indent = below.indent.removeprefix("\n")
        body.insert(last, body.pop(at))
