"""The tree of a program: what was written, line by line, comments and blank lines included.

Two trees are the same where they say the same: marks are not compared, nor does it matter how
anything was spaced or in which spelling of a word. Numbers are as written: mm, deg, s.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from armdrive.errors import BadRequest
from armdrive.programs.acts import Mark

NOWHERE = Mark(1)
"""The mark of what was not read from a text."""

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
"""What a name of a program looks like. Names, like words, are the same in any capitals."""

_BREAKS = ("\n", "\r")


def _mark() -> Mark:
    return field(default=NOWHERE, compare=False, kw_only=True)  # type: ignore[no-any-return]


def one_line(text: str) -> str:
    """Return a text that fits into one line. Raises `BadRequest` for one that does not."""
    if any(sign in text for sign in _BREAKS):
        raise BadRequest(f"a text of a program is one line, not {text!r}")
    return text


# -- what has a value -------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Number:
    """A number; one that is written as a percentage stays one."""

    value: float
    percent: bool = False
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Truth:
    """`on` or `off`, also written `true` and `false`."""

    value: bool
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Text:
    """A text between quotes."""

    value: str
    mark: Mark = _mark()

    def __post_init__(self) -> None:
        one_line(self.value)


@dataclass(frozen=True, slots=True)
class Name:
    """A variable, a parameter, a point of the program, or one of the arm's own book."""

    name: str
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Unary:
    """`-` or `not` before a value. A negative number is a `Number`, see `negative`."""

    sign: str
    value: Expression
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Binary:
    """Two values and what stands between them: `+ - * / == != < <= > >= and or`."""

    left: Expression
    sign: str
    right: Expression
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class FieldOf:
    """A part of a place: `pick.x`."""

    value: Expression
    name: str
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Use:
    """A function with its arguments: `above(pick, 30)`."""

    name: str
    arguments: tuple[Expression, ...] = ()
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class JointsOf:
    """A place in joint angles, deg: `joints(base 0, shoulder 40, ...)`."""

    angles: tuple[tuple[str, Expression], ...]
    mark: Mark = _mark()


Expression: TypeAlias = Number | Truth | Text | Name | Unary | Binary | FieldOf | Use | JointsOf


def negative(value: Expression, mark: Mark = NOWHERE) -> Expression:
    """Return a value with the other sign; of a number, a number."""
    if isinstance(value, Number):
        return Number(-value.value, value.percent, mark=mark)
    return Unary("-", value, mark=mark)


def parts(value: Expression) -> tuple[Expression, ...]:
    """Return the values that a value is made of."""
    match value:
        case Unary() | FieldOf():
            return (value.value,)
        case Binary():
            return (value.left, value.right)
        case Use():
            return value.arguments
        case JointsOf():
            return tuple(each for _, each in value.angles)
        case _:
            return ()


def within(value: Expression) -> Iterator[Expression]:
    """Yield a value and all that it is made of."""
    waiting = [value]
    while waiting:
        found = waiting.pop()
        yield found
        waiting += reversed(parts(found))


# -- lines ------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Remark:
    """A comment on a line of its own; None is a blank line."""

    text: str | None = None
    mark: Mark = _mark()

    def __post_init__(self) -> None:
        one_line(self.text or "")


@dataclass(frozen=True, slots=True)
class Do:
    """A word of the vocabulary with what belongs to it: `wait 1, -2 within 5`."""

    word: str
    """As it is spelt today."""
    arguments: tuple[Expression, ...] = ()
    links: tuple[tuple[str, tuple[Expression, ...]], ...] = ()
    """What stands behind `into`, `by` and `within`."""
    note: str = field(default="", kw_only=True)
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Assign:
    """`height = 30`, or with `point` before it, which says that it is a place."""

    name: str
    value: Expression
    point: bool = False
    note: str = field(default="", kw_only=True)
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a subprogram: `fetch(pick)`."""

    name: str
    arguments: tuple[Expression, ...] = ()
    note: str = field(default="", kw_only=True)
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Label:
    """A place in the program that `goto` leads to: `again:`."""

    name: str
    note: str = field(default="", kw_only=True)
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Goto:
    """Go on at a label of the same block, or of one around it."""

    name: str
    note: str = field(default="", kw_only=True)
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Branch:
    """One way of an `if`: None is the condition of `else`."""

    condition: Expression | None
    body: tuple[Statement, ...]
    note: str = field(default="", kw_only=True)
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class If:
    """`if`, any number of `else if`, perhaps `else`: at least one branch."""

    branches: tuple[Branch, ...]
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class While:
    """As long as the condition holds."""

    condition: Expression
    body: tuple[Statement, ...]
    note: str = field(default="", kw_only=True)
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Repeat:
    """So many times, or for ever; `variable` counts them from 1."""

    count: Expression | None
    body: tuple[Statement, ...]
    variable: str = ""
    note: str = field(default="", kw_only=True)
    mark: Mark = _mark()


@dataclass(frozen=True, slots=True)
class Define:
    """A subprogram with its parameters."""

    name: str
    parameters: tuple[str, ...]
    body: tuple[Statement, ...]
    note: str = field(default="", kw_only=True)
    mark: Mark = _mark()


Statement: TypeAlias = Remark | Do | Assign | Call | Label | Goto | If | While | Repeat | Define


@dataclass(frozen=True, slots=True)
class Tree:
    """A whole program."""

    body: tuple[Statement, ...]


def bodies(statement: Statement) -> tuple[tuple[Statement, ...], ...]:
    """Return the blocks within a statement."""
    match statement:
        case If():
            return tuple(branch.body for branch in statement.branches)
        case While() | Repeat() | Define():
            return (statement.body,)
        case _:
            return ()
