"""What has a value in a program: the nodes that lines are made with.

Numbers are as written: mm, deg, s. Marks are not compared.
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


def one_line(text: str) -> str:
    """Return a text that fits into one line. Raises `BadRequest` for one that does not."""
    if any(sign in text for sign in _BREAKS):
        raise BadRequest(f"a text of a program is one line, not {text!r}")
    return text


@dataclass(frozen=True, slots=True)
class Number:
    """A number; one that is written as a percentage stays one."""

    value: float
    percent: bool = False
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Truth:
    """`on` or `off`, also written `true` and `false`."""

    value: bool
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Text:
    """A text between quotes."""

    value: str
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)

    def __post_init__(self) -> None:
        one_line(self.value)


@dataclass(frozen=True, slots=True)
class Name:
    """A variable, a parameter, a point of the program, or one of the arm's own book."""

    name: str
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Unary:
    """`-` or `not` before a value. A negative number is a `Number`, see `negative`."""

    sign: str
    value: Expression
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Binary:
    """Two values and what stands between them: `+ - * / == != < <= > >= and or`."""

    left: Expression
    sign: str
    right: Expression
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class FieldOf:
    """A part of a place: `pick.x`."""

    value: Expression
    name: str
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Use:
    """A function with its arguments: `above(pick, 30)`."""

    name: str
    arguments: tuple[Expression, ...] = ()
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class JointsOf:
    """A place in joint angles, deg: `joints(base 0, shoulder 40, ...)`."""

    angles: tuple[tuple[str, Expression], ...]
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


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
