"""The reference of the Python calls, made from their docstrings; `generated.py` writes it."""

from __future__ import annotations

import dataclasses
import enum
import inspect
import json
import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any

import armdrive.exports
from armdrive.arm.connected import Recorder
from armdrive.arm.device import ControllerMemory, InputsOutputs
from armdrive.arm.jogging import Jogging
from armdrive.arm.moving import Gripper
from armdrive.arm.reference import ArmReference
from armdrive.storage.point_file import Points
from armdrive.text import json_forms

FOLDER = Path(__file__).parent / "reference"
PAGE = FOLDER / "python-api.md"
SCHEMA = FOLDER / "armdrive.schema.json"

INNER = frozenset(("closed", "parts", "stops"))
"""Calls that the desk and the command line need, and a program has no use for."""

PARTS: Mapping[str, type] = MappingProxyType(
    {
        "gripper": Gripper,
        "points": Points,
        "io": InputsOutputs,
        "jogging": Jogging,
        "reference": ArmReference,
        "controller": ControllerMemory,
        "recorder": Recorder,
    }
)
"""The parts of an arm that have calls of their own, in the order of the page."""

TOLD = (armdrive.Arm, armdrive.AsyncArm, armdrive.AsyncHandle)
"""Classes that are no values: the twins have the calls of what they are twins of."""

HEADING = re.compile(r"    # -- (.+?) -+")
"""A heading of a group of calls in the source of `Arm`."""

HEAD = """# The Python calls

Made from the docstrings by `python docs/generated.py`. Begin with
[From Python](../how-to/python.md). Names with `_mm`, `_deg`, `_rad` and `_s` state their unit;
`speed` is a fraction of the limits. `AsyncArm` and its parts have every call of `Arm` and its parts
under the same name, awaited where it may wait. [Errors](errors.md) are listed with their remedies.
Moves, poses, joint angles, the status and errors have one JSON form:
[armdrive.schema.json](armdrive.schema.json).
"""


class _Bare:
    """Words that are shown without quotes."""

    def __init__(self, words: object) -> None:
        self._words = words

    def __repr__(self) -> str:
        return str(self._words)


def page() -> str:
    """Return the whole page."""
    parts = (line for part in PARTS.items() for line in _part(*part))
    return "\n".join([HEAD, *_arm(), *parts, *_values()]).rstrip() + "\n"


def _arm() -> Iterator[str]:
    """Yield the calls of an arm in the order and under the headings of its source."""
    yield "## `Arm`\n"
    calls, seen = _public(armdrive.Arm), set[str]()
    for line in inspect.getsource(armdrive.Arm).splitlines():
        if heading := HEADING.fullmatch(line):
            yield f"### {heading[1].capitalize()}\n"
        name = line.replace("    async def ", "    def ").removeprefix("    def ").partition("(")[0]
        if name in calls and name not in seen:
            seen.add(name)
            yield from _call("arm", name, inspect.getattr_static(armdrive.Arm, name))


def _part(part: str, kind: type) -> Iterator[str]:
    yield f"## `arm.{part}`\n"
    yield f"{_text(kind)}\n"
    for name in _public(kind):
        yield from _call(f"arm.{part}", name, inspect.getattr_static(kind, name))


def _values() -> Iterator[str]:
    yield "## Values and handles\n"
    for name in dir(armdrive.exports):
        kind = getattr(armdrive.exports, name)
        if kind in TOLD or not inspect.isclass(kind) or issubclass(kind, Exception):
            continue
        yield f"### `{name}`\n"
        yield f"{_text(kind)}\n"
        if issubclass(kind, enum.Enum):
            yield f"One of {', '.join(f'`{each.name}`' for each in kind)}.\n"
            continue
        if dataclasses.is_dataclass(kind):
            fields = [f"`{each.name}`: {_code(each.type)}" for each in dataclasses.fields(kind)]
            yield f"Fields: {', '.join(fields)}.\n"
        for call in _public(kind):
            found = inspect.getattr_static(kind, call)
            if inspect.getdoc(found) and not _is_slot(found):
                yield from _call("", call, found)


def _public(kind: type) -> list[str]:
    return [
        name
        for name, found in vars(kind).items()
        if not name.startswith("_")
        and name not in INNER
        and (callable(found) or isinstance(found, property | cached_property | classmethod))
        and not inspect.isclass(found)
        and getattr(found, "__module__", None) != "collections.abc"  # a mapping's usual calls
    ]


def _call(owner: str, name: str, found: Any) -> Iterator[str]:
    dot = f"{owner}." if owner else "."
    if isinstance(found, property | cached_property):
        getter = found.fget if isinstance(found, property) else found.func
        kind = inspect.signature(getter).return_annotation if getter else ""
        yield f"**`{dot}{name}`**: {_code(kind)}\n"
    else:
        function = found.__func__ if isinstance(found, classmethod | staticmethod) else found
        if isinstance(found, classmethod):
            dot = "Arm." if owner == "arm" else dot
        yield f"**`{dot}{name}{_signature(function)}`**\n"
    yield f"{_text(found)}\n"


def _signature(function: Any) -> str:
    signature = inspect.signature(function)
    kept = [
        each.replace(annotation=_Bare(each.annotation), default=_default(each.default))
        for each in signature.parameters.values()
        if each.name not in ("self", "cls")
    ]
    returned = _Bare(signature.return_annotation)
    return str(signature.replace(parameters=kept, return_annotation=returned))


def _default(default: object) -> object:
    return _Bare(default.__name__) if inspect.isfunction(default) else default


def _text(thing: Any) -> str:
    """Return a docstring as Markdown: its examples stand indented, or in a fence."""
    said = inspect.getdoc(thing)
    if said is None:
        raise LookupError(f"{thing!r} has no docstring")
    return said.strip()


def _code(kind: object) -> str:
    words = kind if isinstance(kind, str) else getattr(kind, "__name__", str(kind))
    return f"`{re.sub(r'^typing[.]', '', words)}`"


def _is_slot(found: object) -> bool:
    return inspect.ismemberdescriptor(found)


def schema() -> str:
    """Return the JSON schema of moves, poses, joint angles, status and errors."""
    return json.dumps(json_forms.schema(), indent=1) + "\n"
