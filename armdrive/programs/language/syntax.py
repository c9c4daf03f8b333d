"""The tree of a program, line by line.

Two trees are equal if their programs do the same: marks, spaces and spellings do not matter.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from armdrive.programs.language.values import slot_of
from armdrive.programs.language.words import (
    ANY_VALUE,
    CONDITION,
    COUNT,
    NEGATIVE,
    NEW_NAME,
    PLACE,
    WORDS,
    Slot,
)
from armdrive.programs.problems import SourceMark

# The mark of what was not read from a text.
NOWHERE = SourceMark(1)

# The form of a program's names. Capitals do not matter, in names as in words.
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    """Any part of a program. Its place is not compared."""

    mark: SourceMark = field(default=NOWHERE, compare=False)


# Values. Numbers are as written: mm, deg, s.


@dataclass(frozen=True, slots=True)
class Literal(Node):
    """A number, perhaps written as a percentage; `on` or `off`; or a text between quotes."""

    value: float | bool | str
    percent: bool = False


@dataclass(frozen=True, slots=True)
class Name(Node):
    """A variable, a parameter, a point of the program, or one of the arm's own book."""

    name: str


@dataclass(frozen=True, slots=True)
class Use(Node):
    """A function or an operator with its values, or a part of a place: a row of `CALLABLE`.

    `above(pick, 30)`, `a + b` and `pick.x` have the names `above`, `+` and `.x`.
    """

    name: str
    arguments: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class JointsOf(Node):
    """A place in joint angles, deg: `joints(base 0, shoulder 40, ...)`."""

    angles: tuple[tuple[str, Expression], ...]


Expression: TypeAlias = Literal | Name | Use | JointsOf


def negative(value: Expression, mark: SourceMark) -> Expression:
    """Return a value with the opposite sign; a number stays a number."""
    if isinstance(value, Literal) and type(value.value) is float:
        return Literal(-value.value, value.percent, mark=mark)
    return Use(NEGATIVE, (value,), mark=mark)


def within(value: Expression) -> Iterator[Expression]:
    """Yield a value and all its parts, from left to right."""
    yield value
    parts: tuple[Expression, ...] = ()
    if isinstance(value, Use):
        parts = value.arguments
    elif isinstance(value, JointsOf):
        parts = tuple(each for _, each in value.angles)
    for part in parts:
        yield from within(part)


# Lines. While a block is being read, its head is a statement with an empty body.


@dataclass(frozen=True, slots=True)
class Do(Node):
    """A word of the vocabulary with its values: `wait_input 1, -2 within 5`."""

    word: str
    """In its present spelling."""
    arguments: tuple[Expression, ...] = ()
    links: tuple[tuple[str, tuple[Expression, ...]], ...] = ()
    """The values of `into`, `by` and `within`."""


@dataclass(frozen=True, slots=True)
class Assign(Node):
    """`height = 30`, or `point pick = ...` for a place."""

    name: str
    value: Expression
    point: bool = False


@dataclass(frozen=True, slots=True)
class Call(Node):
    """A call of a subprogram: `fetch(pick)`."""

    name: str
    arguments: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Label(Node):
    """A place in the program that `goto` leads to: `again:`."""

    name: str


@dataclass(frozen=True, slots=True)
class Goto(Node):
    """Go on at a label of the same block, or of one around it."""

    name: str


@dataclass(frozen=True, slots=True)
class IfBranch(Node):
    """One branch of an `if`; `else` has no condition."""

    condition: Expression | None
    body: tuple[Statement, ...] = ()


@dataclass(frozen=True, slots=True)
class If(Node):
    """`if`, any number of `else if`, perhaps `else`: at least one branch."""

    branches: tuple[IfBranch, ...]


@dataclass(frozen=True, slots=True)
class While(Node):
    """Repeat the body as long as the condition holds."""

    condition: Expression
    body: tuple[Statement, ...] = ()


@dataclass(frozen=True, slots=True)
class Repeat(Node):
    """Repeat the body `count` times, or endlessly; `variable` counts the rounds from 1."""

    count: Expression | None
    body: tuple[Statement, ...] = ()
    variable: str = ""


@dataclass(frozen=True, slots=True)
class Define(Node):
    """A subprogram with its parameters."""

    name: str
    parameters: tuple[str, ...]
    body: tuple[Statement, ...] = ()


Statement: TypeAlias = Do | Assign | Call | Label | Goto | If | While | Repeat | Define


@dataclass(frozen=True, slots=True)
class Tree:
    """A whole program."""

    body: tuple[Statement, ...]

    @property
    def defines(self) -> tuple[Define, ...]:
        """Its subprograms."""
        return tuple(line for line in self.body if isinstance(line, Define))


def bodies(statement: Statement) -> tuple[tuple[Statement, ...], ...]:
    """Return the blocks within a statement."""
    match statement:
        case If():
            return tuple(branch.body for branch in statement.branches)
        case While() | Repeat() | Define():
            return (statement.body,)
        case _:
            return ()


def every(body: tuple[Statement, ...]) -> Iterator[Statement]:
    """Yield every statement of a body and of the blocks within it, in the order of lines."""
    for statement in body:
        yield statement
        for block in bodies(statement):
            yield from every(block)


# The values that a line takes and the names that it sets, by one table for every kind of line. The
# checks of values and the names that a line needs come from it.


def slotted(line: Statement) -> Iterator[tuple[Expression, Slot]]:
    """Yield the values of a line itself with their slots, without the lines within it.

    The values of a call are left out, because only the subprogram knows their slots, and so are
    values beyond the last slot.
    """
    match line:
        case Assign():
            yield line.value, PLACE if line.point else ANY_VALUE
            yield Name(line.name, mark=line.mark), NEW_NAME
        case While():
            yield line.condition, CONDITION
        case If():
            for branch in line.branches:
                if branch.condition is not None:
                    yield branch.condition, CONDITION
        case Repeat():
            if line.count is not None:
                yield line.count, COUNT
            if line.variable:
                yield Name(line.variable, mark=line.mark), NEW_NAME
        case Do():
            word = WORDS[line.word]
            known = dict(word.links)
            rows = [(line.arguments, word.slots)]
            rows += [(values, known.get(link, ())) for link, values in line.links]
            for values, slots in rows:
                for index, value in enumerate(values):
                    slot = slot_of(slots, index)
                    if slot is not None:
                        yield value, slot


def set_by(line: Statement) -> Iterator[Name]:
    """Yield the names that a line itself sets."""
    for value, slot in slotted(line):
        if slot.sets and isinstance(value, Name):
            yield value


def own_names(define: Define | None) -> frozenset[str]:
    """Return the parameters of a subprogram in lower case; none of the program itself."""
    return frozenset(() if define is None else (name.lower() for name in define.parameters))


@dataclass(frozen=True, slots=True)
class ProgramNames:
    """What a program's names stand for, in lower case.

    `variables` are the names that the program sets anywhere, without parameters. Those that only
    `shift` sets are `only_shifted`: they begin as points of the arm's book.
    """

    subprograms: Mapping[str, Define]
    variables: frozenset[str]
    only_shifted: frozenset[str]


def names_of(tree: Tree, known: frozenset[str] = frozenset()) -> ProgramNames:
    """Return the names of a program; `known` are variables that have a value before it begins."""
    subprograms: dict[str, Define] = {}
    shifted, otherwise_set = set[str](), set(known)
    for statement in tree.body:
        define = statement if isinstance(statement, Define) else None
        if define is not None:
            subprograms.setdefault(define.name.lower(), define)
        for line in every((statement,)):
            by_shift = isinstance(line, Do) and line.word == "shift"
            names = {name.name.lower() for name in set_by(line)} - own_names(define)
            (shifted if by_shift else otherwise_set).update(names)
    return ProgramNames(
        subprograms, frozenset(shifted | otherwise_set), frozenset(shifted - otherwise_set)
    )
