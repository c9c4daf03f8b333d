"""Whether a program holds together: names that clash, calls and labels that lead nowhere."""

from __future__ import annotations

from collections.abc import Iterator

from armdrive.programs.acts import Mark
from armdrive.programs.naming import every, own_names, scoped, set_by, subprograms, variables
from armdrive.programs.problems import Problem
from armdrive.programs.syntax import (
    Call,
    Define,
    Do,
    Goto,
    Label,
    Repeat,
    Statement,
    Tree,
    While,
    bodies,
)
from armdrive.programs.vocabulary import RESERVED, SHAPES, WORDS
from armdrive.programs.wording import unknown_word
from kinematics.errors import suggestion


def shape_problems(tree: Tree, known: frozenset[str] = frozenset()) -> Iterator[Problem]:
    """Yield what keeps a program from being compiled; `known` have a value already."""
    yield from _names(tree)
    yield from _defines(tree, variables(tree) | known)
    yield from _calls(tree)
    for define in (None, *(line for line in tree.body if isinstance(line, Define))):
        body = _own_body(tree, define)
        yield from _twice(
            [(line.name, line.mark) for line in every(body) if isinstance(line, Label)],
            "there is a label {!r} already",
        )
        yield from _jumps(body, define is not None, looped=False, labels=frozenset())


def _own_body(tree: Tree, define: Define | None) -> tuple[Statement, ...]:
    if define is not None:
        return define.body
    return tuple(line for line in tree.body if not isinstance(line, Define))


def _twice(named: list[tuple[str, Mark]], text: str) -> Iterator[Problem]:
    seen: set[str] = set()
    for name, mark in named:
        if name.lower() in seen:
            yield Problem(mark, text.format(name))
        seen.add(name.lower())


def _names(tree: Tree) -> Iterator[Problem]:
    named = [(name, mark) for _, line in scoped(tree) for name, mark, _ in set_by(line)]
    for line in tree.body:
        if isinstance(line, Define):
            named += [(name, line.mark) for name in (line.name, *line.parameters)]
    for name, mark in named:
        if name.lower() in RESERVED:
            yield Problem(mark, f"`{name.lower()}` is a word of the language: take another name")


def _defines(tree: Tree, own: frozenset[str]) -> Iterator[Problem]:
    defines = [line for line in tree.body if isinstance(line, Define)]
    text = "there is a subprogram {!r} already"
    yield from _twice([(line.name, line.mark) for line in defines], text)
    for line in defines:
        yield from _twice(
            [(name, line.mark) for name in line.parameters], "two parameters are called {!r}"
        )
        if line.name.lower() in own | own_names(line):
            yield Problem(line.mark, f"{line.name!r} is the name of a value too: take another")


def _calls(tree: Tree) -> Iterator[Problem]:
    known = subprograms(tree)
    for _, line in scoped(tree):
        if isinstance(line, Call) and line.name.lower() not in known:
            names = (*(define.name for define in known.values()), *WORDS, *SHAPES)
            text = f"there is no word and no subprogram {line.name!r}"
            yield Problem(line.mark, unknown_word(line.name, names) or text)


def _jumps(
    body: tuple[Statement, ...], within: bool, *, looped: bool, labels: frozenset[str]
) -> Iterator[Problem]:
    labels |= {line.name.lower() for line in body if isinstance(line, Label)}
    for line in body:
        if isinstance(line, Goto) and line.name.lower() not in labels:
            yield Problem(line.mark, _no_label(line.name, labels))
        if isinstance(line, Do):
            yield from _leaves(line, within, looped)
        for block in bodies(line):
            inner = looped or isinstance(line, While | Repeat)
            yield from _jumps(block, within, looped=inner, labels=labels)


def _no_label(name: str, labels: frozenset[str]) -> str:
    low = name.lower()
    if low in RESERVED:
        return f"`{low}` is no label: what an `if` does stands on lines of its own, up to `end`"
    near = suggestion(low, labels)
    return f"no label {name!r} stands in this block or in one around it{near}"


def _leaves(line: Do, within: bool, looped: bool) -> Iterator[Problem]:
    if line.word == "return" and not within:
        yield Problem(line.mark, "`return` stands in a subprogram; `stop` ends the program")
    if line.word in ("break", "continue") and not looped:
        yield Problem(line.mark, f"`{line.word}` stands in a loop")
