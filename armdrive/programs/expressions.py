"""Reading values: the parser's tree of what has a value becomes ours."""

# ruff: noqa: ARG002, D102 - one form for all methods of the table below

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from lark import Token, Tree

from armdrive.programs.acts import Mark
from armdrive.programs.terms import (
    Binary,
    Expression,
    FieldOf,
    JointsOf,
    Name,
    Number,
    Text,
    Truth,
    Unary,
    Use,
    negative,
)

SIGNS: Mapping[str, str] = MappingProxyType({
    "=": "==", "is": "==", "eq": "==", "is not": "!=", "<>": "!=", "ne": "!=",
    "lt": "<", "le": "<=", "gt": ">", "ge": ">=",
})  # fmt: skip
"""What the other spellings of a comparison mean."""

_TRUE = ("on", "true")


class Expressions:
    """Turns the values of one line into nodes that know where they stand."""

    def __init__(self, number: int, file: str) -> None:
        self._number = number
        self._file = file

    def mark(self, found: Tree[Token] | Token) -> Mark:
        """Return where something begins."""
        where = found if isinstance(found, Token) else found.meta
        return Mark(self._number, getattr(where, "column", None) or 1, self._file)

    def arguments(self, found: Tree[Token] | Token) -> tuple[Expression, ...]:
        """Return the values between commas."""
        assert isinstance(found, Tree)  # noqa: S101 - the grammar's own promise
        return tuple(self.value(each) for each in found.children)

    def value(self, found: Tree[Token] | Token) -> Expression:
        """Return one value."""
        assert isinstance(found, Tree)  # noqa: S101 - the grammar's own promise
        made: Expression = _VALUES[found.data](self, found.children, self.mark(found))
        return made

    def number_of(self, children: list[Any], mark: Mark) -> Expression:
        return Number(float(children[0]), mark=mark)

    def percent(self, children: list[Any], mark: Mark) -> Expression:
        return Number(float(children[0].rstrip("% \t")) / 100.0, percent=True, mark=mark)

    def text(self, children: list[Any], mark: Mark) -> Expression:
        return Text(children[0][1:-1].replace('""', '"'), mark=mark)

    def truth(self, children: list[Any], mark: Mark) -> Expression:
        return Truth(children[0].lower() in _TRUE, mark=mark)

    def name(self, children: list[Any], mark: Mark) -> Expression:
        return Name(str(children[0]), mark=mark)

    def use(self, children: list[Any], mark: Mark) -> Expression:
        arguments = self.arguments(children[1]) if len(children) > 1 else ()
        return Use(str(children[0]).lower(), arguments, mark=mark)

    def joints(self, children: list[Any], mark: Mark) -> Expression:
        angles = [each.children for each in children[1:]]
        named = tuple((str(name).lower(), self.value(angle)) for name, angle in angles)
        return JointsOf(named, mark=mark)

    def field(self, children: list[Any], mark: Mark) -> Expression:
        return FieldOf(self.value(children[0]), str(children[1]).lower(), mark=mark)

    def inner(self, children: list[Any], mark: Mark) -> Expression:
        return self.value(children[0])

    def unary(self, children: list[Any], mark: Mark) -> Expression:
        sign, value = str(children[0]).lower(), self.value(children[1])
        return negative(value, mark) if sign == "-" else Unary(sign, value, mark=mark)

    def binary(self, children: list[Any], mark: Mark) -> Expression:
        left, sign, right = children
        said = " ".join(str(sign).lower().split())
        at = self.mark(sign)
        return Binary(self.value(left), SIGNS.get(said, said), self.value(right), mark=at)


_VALUES: Mapping[str, Callable[[Expressions, list[Any], Mark], Expression]] = MappingProxyType({
    "number": Expressions.number_of,
    "percent": Expressions.percent,
    "text": Expressions.text,
    "truth": Expressions.truth,
    "name": Expressions.name,
    "use": Expressions.use,
    "joints": Expressions.joints,
    "field": Expressions.field,
    "inner": Expressions.inner,
    "unary": Expressions.unary,
    "binary": Expressions.binary,
})  # fmt: skip
