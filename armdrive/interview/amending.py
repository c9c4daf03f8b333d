"""Changing single keys in the text of an arm file, and leaving every other line as it stands.

The text is edited line by line, read back, and compared with the table that was wanted: a file
that is laid out in a way that this cannot edit is refused rather than spoilt.
"""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from armdrive.errors import ArmFileError
from armdrive.interview.corrections import Change
from armdrive.interview.toml_text import COMMENT_AT, key, value

MOTORS = "motors"
_HEADER = re.compile(r"\s*\[")


def amended(text: str, changes: Iterable[Change], order: Mapping[str, str] | None = None) -> str:
    """Return the text with these keys changed, and its motors in another order.

    `order` names, by the motor that was meant, the one that is really there. Raises
    `ArmFileError` where the file's layout is not understood; nothing is changed then.
    """
    changes = tuple(changes)
    lines = text.splitlines()
    for change in changes:
        lines = _changed(lines, change)
    if order:
        lines = _reordered(lines, order)
    after = "\n".join(lines).rstrip("\n") + "\n"
    if _read(after) != wanted(tomllib.loads(text), changes, order):
        by_hand = "; ".join(f"{each.name} = {value(each.value)}" for each in changes)
        raise ArmFileError(
            "the arm file is laid out in a way that cannot be edited here: write by hand, in an "
            f"editor, {by_hand or 'its [[motors]] in their real order'}"
        )
    return after


def wanted(
    table: Mapping[str, Any], changes: Iterable[Change], order: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Return the table as it should be read afterwards."""
    after: dict[str, Any] = copy.deepcopy(dict(table))
    for change in changes:
        inner: Any = after
        for step in change.path[:-1]:
            inner = inner[step] if isinstance(step, int) else inner.setdefault(step, {})
        inner[change.path[-1]] = change.value
    if order:
        named = {each["name"]: each for each in after[MOTORS]}
        after[MOTORS] = [named[order.get(each["name"], each["name"])] for each in after[MOTORS]]
    return after


def _read(text: str) -> dict[str, Any] | None:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return None


def _changed(lines: Sequence[str], change: Change) -> list[str]:
    """Return the lines with one key replaced, or added to its section."""
    start, end = _region(lines, change.path)
    name = str(change.path[-1])
    line = f"{key(name)} = {value(change.value)}".ljust(COMMENT_AT - 1) + f" # {change.why}"
    if start is None:
        return [*lines, "", f"[{change.path[0]}]", line]
    own = re.compile(rf'\s*"?{re.escape(name)}"?\s*=')
    for at in range(start, end):
        if own.match(lines[at]):
            return [*lines[:at], line, *lines[at + 1 :]]
    last = max((at for at in range(start, end) if _says(lines[at])), default=start - 1)
    return [*lines[: last + 1], line, *lines[last + 1 :]]


def _says(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith("#")


def _region(lines: Sequence[str], path: tuple[str | int, ...]) -> tuple[int | None, int]:
    """Return where a key's section begins (behind its header) and ends; None where it is not."""
    headers = [at for at, line in enumerate(lines) if _HEADER.match(line)]
    ends = dict(zip(headers, [*headers[1:], len(lines)], strict=True))
    if len(path) == 1:
        return 0, headers[0] if headers else len(lines)
    name = str(path[0])
    own = [at for at in headers if _title(lines[at]) == name]
    nth = path[1] if isinstance(path[1], int) else 0
    if nth >= len(own):
        return None, len(lines)
    return own[nth] + 1, ends[own[nth]]


def _title(header: str) -> str:
    return header.partition("#")[0].strip().strip("[]").strip()


def _reordered(lines: Sequence[str], order: Mapping[str, str]) -> list[str]:
    """Return the lines with the tables of the motors in their real order."""
    headers = [at for at, line in enumerate(lines) if _HEADER.match(line)]
    ends = dict(zip(headers, [*headers[1:], len(lines)], strict=True))
    own = [at for at in headers if _title(lines[at]) == MOTORS]
    blocks = [list(lines[at : ends[at]]) for at in own]
    named = {_name_of(block): block for block in blocks}
    if set(order) - set(named) or not own:
        return list(lines)  # found out when the text is read back
    placed = [named[order.get(_name_of(block), _name_of(block))] for block in blocks]
    out = list(lines)
    for at, block in reversed(list(zip(own, placed, strict=True))):
        out[at : ends[at]] = block
    return out


def _name_of(block: Sequence[str]) -> str:
    return str((_read("\n".join(block)) or {}).get(MOTORS, [{}])[0].get("name", ""))
