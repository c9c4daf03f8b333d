"""Answers that are given beforehand: a TOML table, flattened to the keys of the questions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def flattened(table: Mapping[str, Any], before: str = "") -> dict[str, str]:
    """Return every answer by its key, `[gear] base = "20:1"` as gear.base, as one would type it."""
    found: dict[str, str] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            found |= flattened(value, f"{before}{key}.")
        else:
            found[before + key] = _typed(value)
    return found


def _typed(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        if any(isinstance(one, list) for one in value):
            return "; ".join(_typed(one) for one in value)
        return ", ".join(map(str, value)) or "none"
    return str(value)
