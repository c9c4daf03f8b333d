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

INNER: Mapping[type, frozenset[str]] = MappingProxyType(
    {
        armdrive.Arm: frozenset(("abilities", "closed", "parts", "program", "reconnects")),
        ArmReference: frozenset(
            ("homes_by_switches", "homing_groups", "homing_words", "request", "unconfirmed")
        ),
        Points: frozenset(("put", "put_all", "read", "remove", "stamp")),
        armdrive.Drift: frozenset(("largest_rad", "words")),
        armdrive.PendantProgram: frozenset(
            (
                "LARGEST_BYTES",
                "meaning",
                "parse",
                "place_of",
                "require_fitting",
                "require_origin",
                "shift_to",
                "text",
                "view",
            )
        ),
        armdrive.SimulatedClock: frozenset(("add", "advance", "engines", "remove", "wait")),
    }
)
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

BRIEF = frozenset(("jogging", "controller", "recorder"))
"""Parts for special programs: the page has only the first sentence of each call."""

VALUES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "Goals": ("Pose", "Joints", "Point", "Motors"),
        "Moves": (
            "JointMove", "PoseMove", "LineMove", "ArcMove", "PathMove", "LinePart", "ArcPart",
            "PosePart", "JointPart", "GripperMove", "GraspMove", "ParkMove", "JogMove", "Jog",
            "MoveSequence", "move_to_json", "move_from_json",
        ),
        "Results": (
            "Handle", "Moved", "Grasped", "Jogged", "Verified", "Drift", "Verdict", "Preview",
        ),
        "Status": ("State", "Trust", "Current", "Status"),
        "For operators, tests and pendants": (
            "PostureRequest", "MarkRequest", "SimulatedClock", "PendantProgram",
        ),
    }
)  # fmt: skip
"""The other public names by subject, in the order of the page."""

TOLD = frozenset(("Arm", "AsyncArm", "AsyncHandle", "Move", "PathPart", "Space"))
"""Public names that have no row: the arm, its twins, unions, and the two spaces of a jog."""

RETURNED = frozenset(("Results", "Status"))
"""Subjects of values that a program reads and never makes: a row lists their fields."""

HEADING = re.compile(r"    # -- (.+?) -+")
"""A heading of a group of calls in the source of `Arm`."""

HEAD = """# The Python calls

Made from the docstrings by `python docs/generated.py`. Begin with
[From Python](../how-to/python.md). `help(Arm.move_l)` and your editor show the types as well.

- Tables have the first sentence of what `help(...)` says.
- A name with `_mm`, `_deg`, `_rad` or `_s` states its unit. `speed` is a fraction of the limits.
- Arguments after `*` are given by name.
- `AsyncArm` has every call of `Arm`, awaited where the call may wait.
- [Errors](errors.md) are listed with their remedies.
- Moves, poses, joint angles, the status and errors have a JSON form:
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
    calls, seen, heading = _public(armdrive.Arm), set(PARTS), ""
    for line in inspect.getsource(armdrive.Arm).splitlines():
        if found := HEADING.fullmatch(line):
            heading = f"### {found[1].capitalize()}\n"
        name = line.replace("    async def ", "    def ").removeprefix("    def ").partition("(")[0]
        if name in calls and name not in seen:
            seen.add(name)
            yield from filter(None, (heading,))
            heading = ""
            yield from _call("arm", name, inspect.getattr_static(armdrive.Arm, name))


def _part(part: str, kind: type) -> Iterator[str]:
    yield f"## `arm.{part}`\n"
    yield f"{_text(kind)}\n"
    calls = {name: inspect.getattr_static(kind, name) for name in _public(kind)}
    if part not in BRIEF:
        for name, found in calls.items():
            yield from _call(f"arm.{part}", name, found)
        return
    yield "| call | meaning |\n|---|---|"
    for name, found in calls.items():
        first = _text(found).partition("\n\n")[0]
        yield f"| `{name}{_signature(found)}` | {_in_row(first)} |"
    yield ""


def _values() -> Iterator[str]:
    """Yield a table for each subject, and below it what a docstring lists."""
    listed = {name for names in VALUES.values() for name in names} | TOLD
    public = {name for name in dir(armdrive.exports) if not name.startswith("_")}
    if listed != {name for name in public if not _is_error(getattr(armdrive.exports, name))}:
        raise LookupError(f"VALUES or TOLD have to list: {sorted(listed ^ public)}")
    for subject, names in VALUES.items():
        yield f"## {subject}\n\n| name | meaning | has |\n|---|---|---|"
        lists = []
        for name in names:
            value = getattr(armdrive.exports, name)
            fields, made = (_fields(value), "") if subject in RETURNED else ((), _made(value))
            has = ", ".join((*fields, *_calls(value)))
            first, *more = _text(value).split("\n\n")
            yield f"| `{name}{made}` | {_in_row(first)} | {has} |"
            lists += [f"`{name}`:\n\n{part}\n" for part in more if part.startswith("- ")]
        yield ""
        yield from lists


def _is_error(value: object) -> bool:
    return inspect.isclass(value) and issubclass(value, Exception)


def _in_row(text: str) -> str:
    return " ".join(text.split()).replace("|", r"\|")


def _made(value: Any) -> str:
    """Return the arguments that make a value or that a function takes."""
    plain = inspect.isclass(value) and not dataclasses.is_dataclass(value)
    return "" if plain or _is_choice(value) else _signature(value).partition(" ->")[0]


def _fields(value: Any) -> Iterator[str]:
    if _is_choice(value):
        yield from (f"`{each.name}`" for each in value)
    elif dataclasses.is_dataclass(value):
        yield from (f"`.{each.name}`" for each in dataclasses.fields(value))


def _calls(value: Any) -> Iterator[str]:
    """Yield the methods and properties of a class that have a docstring."""
    for name in _public(value) if inspect.isclass(value) and not _is_choice(value) else ():
        found = inspect.getattr_static(value, name)
        if inspect.getdoc(found) and not inspect.ismemberdescriptor(found):
            function = getattr(found, "__func__", found)
            call = _signature(function).partition(" ->")[0] if callable(function) else ""
            yield f"`.{name}{call}`"


def _is_choice(value: object) -> bool:
    return inspect.isclass(value) and issubclass(value, enum.Enum)


def _public(kind: type) -> list[str]:
    return [
        name
        for name, found in vars(kind).items()
        if not name.startswith("_")
        and name not in INNER.get(kind, ())
        and (callable(found) or isinstance(found, property | cached_property | classmethod))
        and not inspect.isclass(found)
        and getattr(found, "__module__", None) != "collections.abc"  # a mapping's usual calls
    ]


def _call(owner: str, name: str, found: Any) -> Iterator[str]:
    if isinstance(found, property | cached_property):
        yield f"**`{owner}.{name}`**\n"
    else:
        owner = "Arm" if isinstance(found, classmethod) else owner
        yield f"**`{owner}.{name}{_signature(getattr(found, '__func__', found))}`**\n"
    yield f"{_text(found)}\n"


def _signature(function: Any) -> str:
    """Return the parameters with their defaults, and what is returned."""
    signature = inspect.signature(function)
    kept = [
        each.replace(annotation=each.empty, default=_default(each.default))
        for each in signature.parameters.values()
        if each.name not in ("self", "cls")
    ]
    returned = signature.return_annotation
    shown = signature.empty if returned in ("None", signature.empty) else _Bare(returned)
    return str(signature.replace(parameters=kept, return_annotation=shown))


def _default(default: object) -> object:
    """Return what is shown of a default: of a function that does nothing, None."""
    return None if inspect.isfunction(default) else default


def _text(thing: Any) -> str:
    """Return a docstring as Markdown: its examples stand indented, or in a fence."""
    said = inspect.getdoc(thing)
    if said is None:
        raise LookupError(f"{thing!r} has no docstring")
    return said.strip()


def schema() -> str:
    """Return the JSON schema of moves, poses, joint angles, status and errors."""
    return json.dumps(json_forms.schema(), indent=1) + "\n"
