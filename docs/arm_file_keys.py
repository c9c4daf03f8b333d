"""The page that lists the keys of an arm file, made from its schema."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import MISSING, Field, fields
from pathlib import Path
from typing import Any

from armdrive.config.link_model import AxisRow, LinkRow, ModelHead, Placement, Tip, UrdfSettings
from armdrive.config.sections import (
    Connection,
    FingerModel,
    FrameSettings,
    GripperSettings,
    GuardSettings,
    HomingKeys,
    MotionSettings,
    YawedPostureSettings,
)
from armdrive.registry import DIALECTS
from armdrive.text.toml import Rule, rule_of, value

PAGE = Path(__file__).parent / "reference" / "arm-file-keys.md"

HEAD = """# The keys of an arm file

Made from the schema by `python docs/generated.py`. [arm-file.md](arm-file.md) shows a whole
file and explains the tables by joint and by motor; this page lists every key of the other sections.
A key that is left out has its default. `armdrive config show NAME` prints all of them with
their present values, and `armdrive config check NAME` says everything that is wrong.
"""

SECTIONS: tuple[tuple[str, type[Any]], ...] = (
    ("urdf", UrdfSettings),
    ("connection", Connection),
    ("motion", MotionSettings),
    ("gripper", GripperSettings),
    ("fingers", FingerModel),
    ("reference", YawedPostureSettings),
    ("park", YawedPostureSettings),
    ("homing", HomingKeys),
    ("frames.NAME", FrameSettings),
    ("guards", GuardSettings),
)
"""The sections that every arm may have, in the order of the file."""

MODEL_HEAD = """# The keys of a model file

An arm file may name a model file (`model = "models/six.toml"`). It has a link table, `[[links]]`
with `[base]` and `[tool]`, or joint axes, `[[axes]]` with `[tip]`.
"""

MODEL_SECTIONS: tuple[tuple[str, type[Any]], ...] = (
    ("[links]", LinkRow),
    ("base", Placement),
    ("tool", Placement),
    ("[axes]", AxisRow),
    ("tip", Tip),
)
"""The sections of a model file; a name in brackets is that of an array."""


def page() -> str:
    """Return the whole page."""
    return "\n".join([HEAD, *_sections()]).rstrip() + "\n"


def _sections() -> Iterator[str]:
    for name, kind in SECTIONS:
        yield from _table(f"`[{name}]`", map(_row, fields(kind)))
    for row in DIALECTS.values():
        yield from _table(f"`[{row.name}]`: {row.title}", map(_row, fields(row.settings())))
    yield MODEL_HEAD
    yield from _table("At the top", map(_row, fields(ModelHead)))
    for name, kind in MODEL_SECTIONS:
        yield from _table(f"`[{name}]`", map(_row, fields(kind)))


def _row(key: Field[Any]) -> tuple[str, str, Rule]:
    if key.default is MISSING:
        return key.name, "(needed)", rule_of(key)
    return key.name, "" if key.default is None else f"`{value(key.default)}`", rule_of(key)


def _table(title: str, rows: Iterable[tuple[str, str, Rule]]) -> Iterator[str]:
    yield f"## {title}\n"
    yield "| key | default | allowed | meaning |"
    yield "|---|---|---|---|"
    for key, default, rule in rows:
        yield f"| `{key}` | {default} | {_allowed(rule)} | {rule.help} |"
    yield ""


def _allowed(rule: Rule) -> str:
    if rule.words:
        return ", ".join(rule.words)
    if math.isfinite(rule.low) and math.isfinite(rule.high):
        return f"{_number(rule.low)} to {_number(rule.high)}"
    return ""


def _number(bound: float) -> str:
    return f"{bound:.12g}"
