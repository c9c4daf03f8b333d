"""Write the reference of the Python calls from their docstrings: `python docs/reference.py`."""

from __future__ import annotations

import dataclasses
import enum
import inspect
import re
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import armdrive
from armdrive.arm.gripper import Gripper

PAGE = Path(__file__).parent / "reference.md"

INNER = frozenset(
    (
        "above_mark", "finish", "go_over", "goal_of", "homes_by_switches", "homing_groups", "known",
        "move_gripper", "on_close", "perform", "reference_request", "stand_still", "stops",
        "submit",
    )
)  # fmt: skip
"""Names that the parts of armdrive call of one another, and that a program has no use for."""

TOLD = (armdrive.Arm, armdrive.AsyncArm, armdrive.AsyncHandle)
"""Classes that are no values: the twins have the calls of what they are twins of."""

ORDER = (
    "Arm", "ReferenceCalls", "MoveCalls", "RouteCalls", "JogCalls", "TaskCalls", "Overrides",
    "StatusView", "PreviewCalls", "PointCalls", "VerifyCalls", "Reconnecting", "Connected",
)  # fmt: skip
"""The families of calls in the order in which one needs them; any further ones follow."""

HEAD = """# The Python calls

Made from the docstrings by `python docs/reference.py`; [python.md](python.md) is the page to begin
with. Names with `_mm`, `_deg`, `_rad` and `_s` say their unit; `speed` is a fraction of the limits.
`AsyncArm` and its gripper have every call of `Arm` and `arm.gripper` by the same name, awaited
where it may wait. Errors are listed with their remedies in [errors.md](errors.md).
"""


class _Bare:
    """Words that are shown without quotes."""

    def __init__(self, words: object) -> None:
        self._words = words

    def __repr__(self) -> str:
        return str(self._words)


def page() -> str:
    """Return the whole page."""
    return "\n".join([HEAD, *_arm(), *_gripper(), *_values()]).rstrip() + "\n"


def _arm() -> Iterator[str]:
    families = {kind.__name__: kind for kind in armdrive.Arm.__mro__[:-1]}
    names = [*ORDER, *(name for name in families if name not in ORDER)]
    yield "## `Arm`\n"
    seen: set[str] = set()
    for name in names:
        kind = families[name]
        calls = [each for each in _public(kind) if each not in seen]
        if name == "Arm":  # its decorator repeats the calls of its families
            calls = [each for each in calls if not any(each in vars(k) for k in kind.__mro__[1:])]
        seen.update(calls)
        if calls:
            yield f"### {_text(kind).splitlines()[0]}\n"
            for call in calls:
                yield from _call("arm", call, inspect.getattr_static(kind, call))


def _gripper() -> Iterator[str]:
    yield "## `arm.gripper`\n"
    for name in _public(Gripper):
        yield from _call("arm.gripper", name, inspect.getattr_static(Gripper, name))


def _values() -> Iterator[str]:
    yield "## Values and handles\n"
    for name in sorted(armdrive.__all__):
        kind = getattr(armdrive, name)
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


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
