"""Write armdrive/aio/__init__.pyi, the signatures of the twins, where this file is run.

The twins are made as they are loaded, so a type checker cannot see them. What stands here is read
from them and from the calls that they are twins of.
"""

import ast
import inspect
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, get_overloads

import armdrive.aio as twins
from armdrive.arm import Arm, device, moving, reference
from armdrive.arm.connected import Recorder

FILE = Path(twins.__file__).with_suffix(".pyi")

HEAD = '"""What type checkers read of this package, from tests/armdrive/aio/async_twin.py."""\n'


KINDS = (
    (twins.AsyncGripper, moving.Gripper),
    (twins.AsyncInputsOutputs, device.InputsOutputs),
    (twins.AsyncReference, reference.ArmReference),
    (twins.AsyncControllerMemory, device.ControllerMemory),
    (twins.AsyncRecorder, Recorder),
    (twins.AsyncArm, Arm),
)

ATTRIBUTES = {"config": "ArmConfig", "simulated": "bool", "twin": "SimulatedArm | None"}
"""What an `Arm` has as plain attributes, whose types no signature says."""

RENAMED = {"Handle": "AsyncHandle"} | {kind.__name__: twin.__name__ for twin, kind in KINDS[:-1]}
"""Classes that have a twin of their own."""

BESIDE = {
    "ArmConfig": "armdrive.config.arm",
    "AsyncHandle": "armdrive.aio.calls",
    "Accept": "armdrive.arm.reference",
    "Lines": "armdrive.arm.device",
    "overload": "typing",
}
"""Where the names come from that no module imports whose calls these are."""


class _Bare:
    """Words that are shown without quotes."""

    def __init__(self, words: str) -> None:
        self._words = words

    def __repr__(self) -> str:
        return self._words


def text() -> str:
    """Return the stub, laid out in no particular way."""
    classes = "\n".join(line for twin, kind in KINDS for line in _class(twin, kind))
    return "\n".join([HEAD, *_imports(classes), classes])


def _class(twin: type, kind: type) -> Iterator[str]:
    (base,) = twin.__orig_bases__ if "__orig_bases__" in vars(twin) else twin.__bases__
    yield f"class {twin.__name__}({getattr(base, '__name__', '')}{_parameter(base)}):"
    yield _described(twin, 1)
    for name, found in vars(twin).items():
        if name.startswith("_"):
            continue
        if isinstance(found, property):
            yield from _property(name, found, vars(kind).get(name, found))
        elif isinstance(found, classmethod):
            yield "    @classmethod"
            returned = inspect.get_annotations(found.__func__)["return"]
            yield _function("def", name, inspect.unwrap(found.__func__), found, returned)
        else:
            word = "async def" if inspect.iscoroutinefunction(found) else "def"
            forms = get_overloads(inspect.unwrap(found))
            for form in forms:
                yield "    @overload"
                yield _function(word, name, form, found if form is forms[0] else None)
            if not forms:
                yield _function(word, name, found, found)


def _parameter(base: Any) -> str:
    """Return the parameter of a generic base, in its brackets."""
    return "".join(f"[{each.__name__}]" for each in getattr(base, "__args__", ()))


def _property(name: str, found: property, original: property) -> Iterator[str]:
    kind = ATTRIBUTES.get(name) or inspect.signature(original.fget).return_annotation
    yield f"    @property\n    def {name}(self) -> {_renamed(kind)}:\n{_described(found, 2)}"
    if found.fset is not None:
        yield f"    @{name}.setter\n    def {name}(self, {name}: {kind}) -> None: ..."


def _function(
    word: str,
    name: str,
    call: Callable[..., Any],
    described: object = None,
    returned: str = "",
) -> str:
    """Return a function, with its docstring where it has one that is described."""
    signature = inspect.signature(call)
    words = [
        each.replace(
            annotation=each.annotation if each.annotation is each.empty else _Bare(each.annotation),
            default=each.default if each.default is each.empty else _Bare("..."),
        )
        for each in signature.parameters.values()
    ]
    kind = _Bare(_renamed(returned or signature.return_annotation))
    shown = signature.replace(parameters=words, return_annotation=kind)
    body = " ..." if described is None else f"\n{_described(described, 2)}"
    return f"    {word} {name}{shown}:{body}"


def _described(thing: object, depth: int) -> str:
    """Return a docstring's first line; of a class and of what is the twin's own, all of it."""
    said = inspect.getdoc(thing) or ""
    own = isinstance(thing, type | classmethod)
    if not own:
        said = said.splitlines()[0]
    closing = '\n"""' if "\n" in said else '"""'
    lines = f'"""{said}{closing}'.splitlines()
    return "\n".join(f"{'    ' * depth}{line}".rstrip() for line in lines)


def _renamed(kind: str) -> str:
    for name, twin in RENAMED.items():
        kind = re.sub(rf"\b{name}\b", twin, kind)
    return kind


def _imports(classes: str) -> Iterator[str]:
    """Give an import for each name in some classes, from where the calls' modules have it."""
    modules = dict(BESIDE)
    for module in (*(sys.modules[kind.__module__] for _, kind in KINDS), twins):
        for each in ast.walk(ast.parse(inspect.getsource(module))):
            if isinstance(each, ast.ImportFrom):
                modules |= {alias.name: each.module or "" for alias in each.names}
    used = {each.id for each in ast.walk(ast.parse(classes)) if isinstance(each, ast.Name)}
    for name in sorted(used & modules.keys()):
        yield f"from {modules[name]} import {name}"


def parts(stub: str) -> tuple[set[str], list[str]]:
    """Return what a stub imports, and all else, however it is laid out."""
    body = ast.parse(stub).body
    imports = [each for each in body if isinstance(each, ast.ImportFrom)]
    names = {f"{each.module}.{alias.name}" for each in imports for alias in each.names}
    return names, [ast.unparse(each) for each in body if each not in imports]


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
    for words in (("format",), ("check", "--fix")):
        subprocess.run([sys.executable, "-m", "ruff", *words, "--quiet", FILE], check=True)
