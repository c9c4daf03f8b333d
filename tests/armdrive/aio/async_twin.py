"""Write armdrive/aio/arm.py from the calls of `Arm`: `python tests/armdrive/aio/async_twin.py`.

How a call is awaited follows from how it is written: a `blocking` one waits, one with `wait=` or a
`Handle` begins a motion. The tables below say it of all others.
"""

from __future__ import annotations

import ast
import inspect
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import armdrive.aio
from armdrive.arm import Arm
from armdrive.arm.gripper import Gripper

FILE = Path(armdrive.aio.__file__).parent / "arm.py"

WIDTH = 100
"""Characters of a line."""

AT_ONCE = frozenset(
    (
        "estop", "hold", "log", "nudge", "pause", "pose_in", "reference_request", "release",
        "request_stop", "resume",
    )
)  # fmt: skip
"""Calls that never wait: they are not awaited."""

LONG = frozenset(("preview", "save_recording"))
"""Calls that never wait for an arm, but compute or write for long: they are awaited."""

ATTRIBUTES = {
    "config": ("ArmConfig", "The arm's file."),
    "simulated": ("bool", "Whether it is a simulated arm."),
    "twin": ("SimulatedArm | None", "The simulated arm behind, with its physical world."),
}
"""What an `Arm` has as plain attributes."""

TWINS = {"Gripper": "AsyncGripper", "Handle": "AsyncHandle"}
"""Classes that have a twin of their own."""

OWN = frozenset(("close",))
"""The calls of `Arm` that the twin has from `AsyncConnection`."""

HEAD = '''"""`AsyncArm`: an arm whose calls are awaited, each the twin of a call of `Arm`.

Written by `python tests/armdrive/aio/async_twin.py` from the calls of `Arm`: change those instead.
"""
'''

GRIPPER = '''class AsyncGripper(AsyncCalls[Gripper]):
    """The fingers of an arm: the calls of `Gripper`, awaited."""
'''

ARM = '''@checked_calls(RULES)
class AsyncArm(AsyncConnection):
    """One arm, connected, for a program of coroutines; `sync` is the `Arm` itself.

    Each call is described at the call of that name of `Arm`. Whoever cancels an awaited call,
    `asyncio.timeout` too, stops the arm: the cancelling goes on once it stands. What never waits
    (`status`, `pause`, `estop`, ...) is not awaited.
    """
'''

CONNECT = '''        """Connect as `Arm.connect` does: `await` it, or use it in `async with`.

        Simulated arms of one event loop live on one clock, unless `pace` says otherwise. What
        simulated time an arm needs passes while its calls are awaited, and not in `asyncio.sleep`.
        """
'''

CALLS = "AsyncCalls AsyncConnection AsyncHandle Connecting at_once awaited begun"
FROM = {
    **dict.fromkeys(CALLS.split(), "armdrive.aio.calls"),
    "RULES": "armdrive.arm.arguments",
    "checked_calls": "armdrive.errors.arguments",
    "ArmConfig": "armdrive.config.arm",
    "ConnectOptions": "armdrive.connect.parts",
    "Self": "typing",
    "TYPE_CHECKING": "typing",
}
"""Where the names come from that the source of `Arm` has not, or not from there."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True, slots=True)
class Source:
    """The source of one class: its public functions, and where the names in it come from."""

    kind: type
    name: str
    text: str
    functions: tuple[Function, ...]
    modules: dict[str, str]
    """The module of each imported name."""
    typing_only: frozenset[str]
    """The names that are imported for type checkers alone."""

    def words(self, node: ast.expr | None) -> str:
        """Return an expression as it is written."""
        return "" if node is None else ast.get_source_segment(self.text, node) or ""


def source_of(kind: type) -> Source:
    """Read the source of a class."""
    text = inspect.getsource(sys.modules[kind.__module__])
    tree = ast.parse(text)
    (found,) = (
        each for each in tree.body if isinstance(each, ast.ClassDef) and each.name == kind.__name__
    )
    functions = tuple(
        each for each in found.body if isinstance(each, Function) and each.name[0] != "_"
    )
    modules = {
        alias.asname or alias.name: each.module or ""
        for each in ast.walk(tree)
        if isinstance(each, ast.ImportFrom)
        for alias in each.names
    }
    typing_only = {
        alias.name
        for block in tree.body
        if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING"
        for each in block.body
        if isinstance(each, ast.ImportFrom)
        for alias in each.names
    }
    return Source(kind, kind.__name__, text, functions, modules, frozenset(typing_only))


# Signatures and calls, laid out as ruff does.


def laid_out(begin: str, words: list[str], end: str) -> str:
    """Return what stands in brackets on one line, its words on a line of their own, or one each."""
    indent = " " * (len(begin) - len(begin.lstrip()))
    line = f"{begin}({', '.join(words)}){end}\n"
    if len(line) <= WIDTH + 1:
        return line
    inner = f"{indent}    {', '.join(words)}\n"
    if len(inner) > WIDTH + 1:
        inner = "".join(f"{indent}    {each},\n" for each in words)
    return f"{begin}(\n{inner}{indent}){end}\n"


def signature(source: Source, function: Function, begin: str, returned: str, end: str = "") -> str:
    """Return the first lines of a function that takes what another one takes."""
    given = function.args
    plain = [*given.posonlyargs, *given.args]
    defaults = [None] * (len(plain) - len(given.defaults)) + given.defaults
    words = [_parameter(source, each, value) for each, value in zip(plain, defaults, strict=True)]
    if given.posonlyargs:
        words.insert(len(given.posonlyargs), "/")
    if given.vararg is not None:
        words.append(f"*{_parameter(source, given.vararg, None)}")
    elif given.kwonlyargs:
        words.append("*")
    words += [
        _parameter(source, each, value)
        for each, value in zip(given.kwonlyargs, given.kw_defaults, strict=True)
    ]
    if given.kwarg is not None:
        words.append(f"**{_parameter(source, given.kwarg, None)}")
    return laid_out(f"    {begin} {function.name}", words, f" -> {returned}:{end}")


def _parameter(source: Source, name: ast.arg, default: ast.expr | None) -> str:
    words = name.arg if name.annotation is None else f"{name.arg}: {source.words(name.annotation)}"
    return words if default is None else f"{words} = {source.words(default)}"


def passed_on(function: Function, **instead: str) -> list[str]:
    """Return the arguments with which a twin makes the call."""
    given = function.args
    words = [each.arg for each in [*given.posonlyargs, *given.args][1:]]
    words += [] if given.vararg is None else [f"*{given.vararg.arg}"]
    words += [f"{each.arg}={instead.get(each.arg, each.arg)}" for each in given.kwonlyargs]
    words += [] if given.kwarg is None else [f"**{given.kwarg.arg}"]
    return words


def first_line(function: Function) -> str:
    """Return the first line of a docstring, as a docstring."""
    return f'        """{(ast.get_docstring(function) or "").splitlines()[0]}"""\n'


# How each kind of call is awaited.


def twins(source: Source) -> str:
    """Return the body of the twin of a class: its properties, its motions, and all other calls."""
    properties: list[str] = []
    motions: list[str] = []
    calls: list[str] = []
    overloads = ""
    for function in source.functions:
        marks = {ast.unparse(each) for each in function.decorator_list}
        if "property" in marks:
            properties.append(_property(source, function))
        elif any(each.endswith(".setter") for each in marks):
            properties.append(_setter(source, function))
        elif "classmethod" in marks:
            motions.insert(0, _connect(source, function))
        elif "overload" in marks:
            overloads += _overload(source, function)
        elif overloads and not _has_wait(function):
            made = f"{_made_by(source, function)}({source.name}.{function.name})"
            made = f"    _{function.name} = {made}\n\n"
            motions.append(f"{made}{overloads}{_overloaded(source, function)}")
            overloads = ""
        elif _has_wait(function):
            motions.append(f"{overloads}{_motion(source, function)}")
            overloads = ""
        elif not (source.kind is Arm and function.name in OWN):
            call = f"{source.name}.{function.name}"
            calls.append(f"    {function.name} = {_made_by(source, function)}({call})\n")
    if source.kind is Arm:
        properties[:0] = [_attribute(name, *words) for name, words in ATTRIBUTES.items()]
    return "\n".join([*properties, *motions, "".join(calls)])


def _made_by(source: Source, function: Function) -> str:
    """Return what makes the twin of a call without `wait=`."""
    returned = source.words(function.returns)
    if returned.startswith("Handle["):
        return "begun"
    if isinstance(function, ast.AsyncFunctionDef) or function.name in LONG:
        return "awaited"
    if function.name in AT_ONCE:
        return "at_once"
    raise LookupError(
        f"{function.name}: make it `blocking`, or say in AT_ONCE or LONG how long it takes"
    )


def _attribute(name: str, kind: str, words: str) -> str:
    return (
        f"    @property\n    def {name}(self) -> {kind}:\n"
        f'        """{words}"""\n        return self.sync.{name}\n'
    )


def _property(source: Source, function: Function) -> str:
    returned, value = source.words(function.returns), f"self.sync.{function.name}"
    if (twin := TWINS.get(returned)) is not None:
        returned, value = twin, f"{twin}({value}, self._arm)"
    head = signature(source, function, "def", returned)
    return f"    @property\n{head}{first_line(function)}        return {value}\n"


def _setter(source: Source, function: Function) -> str:
    name, value = function.name, function.args.args[1].arg
    head = signature(source, function, "def", "None")
    return f"    @{name}.setter\n{head}        self.sync.{name} = {value}\n"


def _connect(source: Source, function: Function) -> str:
    head = signature(source, function, "def", "Connecting[Self]")
    words = [f"{each.arg}={each.arg}" for each in function.args.kwonlyargs]
    options = laid_out("        options = ConnectOptions", words, "")
    made = "        return Connecting(cls, target, options)\n"
    return f"    @classmethod\n{head}{CONNECT}{options}{made}"


def _overload(source: Source, function: Function) -> str:
    return f"    @overload\n{_awaited_signature(source, function, ' ...')}"


def _motion(source: Source, function: Function) -> str:
    call = ", ".join(passed_on(function, wait="False"))
    begin = [f"lambda: self.sync.{function.name}({call})", "wait"]
    body = laid_out("        return await self._begin", begin, "")
    return f"{_awaited_signature(source, function)}{first_line(function)}{body}"


def _has_wait(function: Function) -> bool:
    return any(each.arg == "wait" for each in function.args.kwonlyargs)


def _overloaded(source: Source, function: Function) -> str:
    call = ", ".join(passed_on(function))
    body = f"        return await self._{function.name}({call})\n"
    return f"{_awaited_signature(source, function)}{first_line(function)}{body}"


def _awaited_signature(source: Source, function: Function, end: str = "") -> str:
    returned = source.words(function.returns)
    for name, twin in TWINS.items():
        returned = re.sub(rf"\b{name}\b", twin, returned)
    return signature(source, function, "async def", returned, end)


# The whole module.


def text() -> str:
    """Return the source of the twins."""
    gripper, arm = source_of(Gripper), source_of(Arm)
    classes = f"{GRIPPER}\n{twins(gripper)}\n\n{ARM}\n{twins(arm)}"
    return f"{HEAD}\n{imports(classes, gripper, arm)}\n\n{classes}"


def imports(classes: str, *sources: Source) -> str:
    """Return the imports of all names in some classes, sorted as ruff does."""
    modules = dict(FROM)
    for source in sources:
        modules |= {source.kind.__name__: source.kind.__module__}
        modules |= {name: module for name, module in source.modules.items() if name not in modules}
    typing_only = frozenset().union(*(source.typing_only for source in sources))
    names = (each for each in ast.walk(ast.parse(classes)) if isinstance(each, ast.Name))
    used = {each.id for each in names if isinstance(each.ctx, ast.Load)}
    used |= {"TYPE_CHECKING"} if used & typing_only else set()
    plain = sorted(used & modules.keys() - typing_only)
    standard = [
        each for each in plain if modules[each].partition(".")[0] in sys.stdlib_module_names
    ]
    ours = [each for each in plain if each not in standard]
    words = ["from __future__ import annotations\n"]
    words += ["".join(_from(modules, each, "")) for each in (standard, ours)]
    if rare := sorted(used & typing_only):
        block = "".join(_from(modules, rare, "    "))
        words.append(f"if TYPE_CHECKING:  # a real arm loads no simulation\n{block}")
    return "\n".join(words)


def _from(modules: Mapping[str, str], names: Iterable[str], indent: str) -> Iterator[str]:
    by_module: dict[str, list[str]] = {}
    for name in names:
        by_module.setdefault(modules[name], []).append(name)
    for module, found in sorted(by_module.items()):
        # constants, then classes, then functions
        found.sort(key=lambda each: (not each.isupper(), each[0].islower(), each))
        line = f"{indent}from {module} import {', '.join(found)}\n"
        if len(line) > WIDTH + 1:
            each = "".join(f"{indent}    {name},\n" for name in found)
            line = f"{indent}from {module} import (\n{each}{indent})\n"
        yield line


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
