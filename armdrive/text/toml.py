"""Reading a table of an arm file into a frozen dataclass: one rule for every section.

Keys, types and defaults come from the dataclass itself, so that nothing is listed twice. Unknown
keys, wrong types and numbers out of bounds are errors that name the key.
"""

from __future__ import annotations

import json
import math
import re
import types
import typing
from collections.abc import Mapping
from dataclasses import fields
from typing import Any, TypeVar

from armdrive.errors import ArmFileError
from armdrive.text.reading import Failure
from kinematics.errors import BadNumber, did_you_mean, finite
from kinematics.limits import JointRange

S = TypeVar("S")


def read_section(kind: type[S], table: object, where: str) -> S:
    """Build `kind` from a TOML table; `where` names the section in errors."""
    entries = require_table(table, where)
    hints = typing.get_type_hints(kind)
    names = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    refuse_unknown(entries, names, where)
    values = {
        key: _convert(hints[key], value, f"{where}.{key}" if where else key)
        for key, value in entries.items()
    }
    try:
        return kind(**values)
    except TypeError:
        missing = ", ".join(name for name in names if name not in values)
        raise ArmFileError(f"[{where}] is missing {missing}") from None


def require_table(table: object, where: str) -> Mapping[str, Any]:
    """Return the table, or say that something else stands there."""
    if not isinstance(table, Mapping):
        raise ArmFileError(f"{where} must be a table, written [{where}], not {table!r}")
    return table


def refuse_unknown(entries: Mapping[str, object], known: list[str], where: str) -> None:
    """Raise for the first unknown key, with the nearest known one."""
    for key in entries:
        if key not in known:
            place = f"in [{where}]" if where else "at the top"
            hint = did_you_mean(key, known, f"known are {', '.join(known)}", likeness=0.5)
            raise ArmFileError(f"unknown key {key!r} {place}; {hint}")


def _convert(wanted: Any, value: object, where: str) -> Any:
    """Check one value against its annotation; whole numbers are fine where floats belong."""
    origin = typing.get_origin(wanted)
    if origin in (types.UnionType, typing.Union):
        kinds = [one for one in typing.get_args(wanted) if one is not type(None)]
        plain = isinstance(value, int | float) and not isinstance(value, bool)
        return _convert(float if plain and float in kinds else kinds[0], value, where)
    if origin is tuple:
        return _convert_tuple(wanted, value, where)
    if wanted is float:
        return number(value, where)
    if wanted in (int, str, bool) and type(value) is wanted:
        return value
    raise ArmFileError(f"{where} must be {_WORDS.get(wanted, wanted)}, not {value!r}")


def _convert_tuple(wanted: Any, value: object, where: str) -> tuple[Any, ...]:
    inner = typing.get_args(wanted)
    if not isinstance(value, list | tuple):
        raise ArmFileError(f"{where} must be a list, not {value!r}")
    if len(inner) == 2 and inner[1] is Ellipsis:
        return tuple(_convert(inner[0], item, f"{where}[{i}]") for i, item in enumerate(value))
    if len(value) != len(inner):
        raise ArmFileError(f"{where} must have {len(inner)} entries, not {len(value)}")
    return tuple(
        _convert(kind, item, f"{where}[{i}]")
        for i, (kind, item) in enumerate(zip(inner, value, strict=True))
    )


def number(value: object, where: str) -> float:
    """Return a finite number, or raise `ArmFileError` that names the key."""
    try:
        return finite(where, value)
    except BadNumber as error:
        raise ArmFileError(str(error)) from None


def within(where: str, value: float, low: float, high: float) -> None:
    """Raise `ArmFileError` for a number out of its bounds."""
    if not low <= value <= high:
        raise ArmFileError(f"{where} must be from {low:g} to {high:g}, not {value:g}")


def joint_range(value: object, where: str) -> JointRange:
    """Return a range of the file, a pair of degrees."""
    if not isinstance(value, list) or len(value) != 2:
        raise ArmFileError(f"{where} must be a pair of degrees, for example [-90, 90]")
    low, high = (number(one, where) for one in value)
    if low >= high:
        raise ArmFileError(f"{where}: the first number must be below the second")
    return JointRange(math.radians(low), math.radians(high))


_WORDS: Mapping[Any, str] = types.MappingProxyType(
    {int: "a whole number", str: "text", bool: "true or false"}
)


# The version of a file that people keep: an arm file, a model file, a file of points.

FORMAT_KEY = "format"
FORMAT = 1
"""The format that this armdrive reads and writes. Files from before the key existed have it too."""


def require_format(table: Mapping[str, Any], failure: Failure = ArmFileError) -> None:
    """Raise the error that `failure` makes unless this armdrive knows the format of a file.

    Call this before reading any other key: in another format, the same key may mean something else.
    """
    given = table.get(FORMAT_KEY, FORMAT)
    if type(given) is not int or given < FORMAT:  # neither true nor 1.0 is a whole number here
        raise failure(f"{FORMAT_KEY}: expected the whole number {FORMAT}, got {given!r:.40}")
    if given > FORMAT:
        raise failure(
            f"{FORMAT_KEY} {given} is newer than this armdrive reads ({FORMAT}). Update armdrive."
        )


# Values as TOML.

_BARE = r"[A-Za-z0-9_-]+"


def key(name: str) -> str:
    """Return a key, quoted where it is no single word."""
    return name if re.fullmatch(_BARE, name) else value(name)


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
