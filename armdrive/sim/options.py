"""Settings of a simulated device that a person or a test may choose, by name: a table for each.

The values are numbers, texts or true and false; on the command line they are written NAME=VALUE.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from armdrive.errors import BadRequest
from kinematics.errors import did_you_mean

Value: TypeAlias = bool | int | float | str
_FLAGS = {"yes": True, "true": True, "on": True, "1": True}
_FLAGS |= {"no": False, "false": False, "off": False, "0": False}


@dataclass(frozen=True, slots=True)
class Option:
    """One setting: its kind is that of its default; `choices` bounds a text."""

    name: str
    default: Value
    summary: str
    choices: tuple[str, ...] = ()

    def parse(self, text: str) -> Value:
        """Read a value as a person types it. Raises `BadRequest`."""
        if isinstance(self.default, bool):
            if text.lower() not in _FLAGS:
                raise BadRequest(f"{self.name} must be yes or no, not {text!r}")
            return _FLAGS[text.lower()]
        if isinstance(self.default, str):
            return self.checked(text)
        whole = isinstance(self.default, int)
        try:
            value = int(text) if whole else float(text)
        except ValueError:
            kind = "a whole number" if whole else "a number"
            raise BadRequest(f"{self.name} must be {kind}, not {text!r}") from None
        return self.checked(value)

    def checked(self, value: Value) -> Value:
        """Return a value of the right kind, or raise `BadRequest`."""
        if isinstance(self.default, float) and type(value) is int:
            value = float(value)
        if type(value) is not type(self.default):
            raise BadRequest(f"{self.name} must be like {self.default!r}, not {value!r}")
        if isinstance(value, float) and not math.isfinite(value):
            raise BadRequest(f"{self.name} must be finite")
        if self.choices and value not in self.choices:
            raise BadRequest(f"{self.name} is one of {', '.join(self.choices)}, not {value!r}")
        return value


class Options:
    """The chosen settings, the rest at their defaults; read with the type that is expected."""

    def __init__(self, table: Iterable[Option], chosen: Mapping[str, Value] | None = None) -> None:
        rows = {row.name: row for row in table}
        self._values = {name: row.default for name, row in rows.items()}
        for name, value in (chosen or {}).items():
            self._values[name] = _row(rows, name).checked(value)

    @classmethod
    def parse(cls, table: Iterable[Option], words: Iterable[str]) -> dict[str, Value]:
        """Read NAME=VALUE words. Raises `BadRequest` with the nearest name."""
        rows = {row.name: row for row in table}
        chosen: dict[str, Value] = {}
        for word in words:
            name, equals, text = word.partition("=")
            if not equals:
                raise BadRequest(f"write a setting as NAME=VALUE, not {word!r}")
            key = name.strip().replace("-", "_")
            chosen[key] = _row(rows, key).parse(text.strip())
        return chosen

    def flag(self, name: str) -> bool:
        """Return a setting that is true or false."""
        return bool(self._values[name])

    def whole(self, name: str) -> int:
        """Return a whole number."""
        return int(self._values[name])

    def number(self, name: str) -> float:
        """Return a number."""
        return float(self._values[name])

    def text(self, name: str) -> str:
        """Return a text."""
        return str(self._values[name])


def _row(rows: Mapping[str, Option], name: str) -> Option:
    if name in rows:
        return rows[name]
    known = f"known are {', '.join(rows)}" if rows else "this device has none"
    hint = did_you_mean(name, rows, known)
    raise BadRequest(f"the simulated device has no setting {name!r}; {hint}")
