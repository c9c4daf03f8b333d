"""Writes a tree as text in the present spelling, with its comments and blank lines."""

from __future__ import annotations

from collections.abc import Iterator

from armdrive.programs.language.syntax import (
    Assign,
    Binary,
    Call,
    Define,
    Do,
    Expression,
    FieldOf,
    Goto,
    If,
    JointsOf,
    Label,
    Name,
    Number,
    Remark,
    Repeat,
    Statement,
    TextValue,
    Tree,
    Truth,
    Unary,
    Use,
    While,
    bodies,
)
from armdrive.programs.language.values import COMPARES, OPERATORS

INDENT = "  "
"""The indentation of each block."""

_MINUS, _PART = 7, 8
"""How closely `-` before a value binds, and the parts of a place."""


def unparse(tree: Tree) -> str:
    """Return a program's text; reading it returns an equal tree."""
    return "".join(f"{line}\n" for line in _block(tree.body, ""))


def written(value: Expression) -> str:
    """Return a value as text."""
    return _value(value, 0)


def _block(body: tuple[Statement, ...], indent: str) -> Iterator[str]:
    for statement in body:
        yield from _statement(statement, indent)


def _noted(indent: str, text: str, note: str) -> str:
    return f"{indent}{text}  # {note}" if note else f"{indent}{text}"


def _statement(statement: Statement, indent: str) -> Iterator[str]:
    match statement:
        case Remark():
            yield "" if statement.text is None else f"{indent}# {statement.text}".rstrip()
        case If():
            for index, branch in enumerate(statement.branches):
                test = "" if branch.condition is None else f"if {written(branch.condition)}"
                words = test if index == 0 else f"else {test}".rstrip()
                yield _noted(indent, words, branch.note)
                yield from _block(branch.body, indent + INDENT)
            yield f"{indent}end"
        case _:
            yield _noted(indent, _words(statement), statement.note)
            for body in bodies(statement):
                yield from _block(body, indent + INDENT)
                yield f"{indent}end"


def _words(statement: Do | Assign | Call | Label | Goto | While | Repeat | Define) -> str:
    """Return a line, or the head of a block."""
    match statement:
        case Do():
            linked = "".join(f" {link} {_listed(values)}" for link, values in statement.links)
            return f"{statement.word} {_listed(statement.arguments)}".rstrip() + linked
        case Assign():
            return f"{'point ' * statement.point}{statement.name} = {written(statement.value)}"
        case Call():
            return f"{statement.name}({_listed(statement.arguments)})"
        case Label():
            return f"{statement.name}:"
        case Goto():
            return f"goto {statement.name}"
        case While():
            return f"while {written(statement.condition)}"
        case Repeat():
            count = "" if statement.count is None else f" {written(statement.count)}"
            counted = f" as {statement.variable}" if statement.variable else ""
            return f"repeat{count}{counted}"
        case Define():
            return f"define {statement.name}({', '.join(statement.parameters)})"


def _listed(values: tuple[Expression, ...]) -> str:
    return ", ".join(written(value) for value in values)


def _value(value: Expression, strength: int) -> str:
    """Return a value, in brackets if the operator around it binds as strongly."""
    match value:
        case Number():
            text = _number(value)
            return f"({text})" if strength == _PART else text
        case Truth():
            return "on" if value.value else "off"
        case TextValue():
            return '"' + value.value.replace('"', '""') + '"'
        case Name():
            return value.name
        case Use():
            return f"{value.name}({_listed(value.arguments)})"
        case FieldOf():
            return f"{_value(value.value, _PART)}.{value.name}"
        case JointsOf():
            angles = (f"{name} {_value(each, COMPARES)}" for name, each in value.angles)
            return f"joints({', '.join(angles)})"
        case Unary():
            own = _MINUS if value.sign == "-" else OPERATORS[value.sign].strength
            space = "" if value.sign == "-" else " "
            text = f"{value.sign}{space}{_value(value.value, own - 1)}"
        case Binary():
            own, text = _binary(value)
    return f"({text})" if own <= strength else text


def _binary(value: Binary) -> tuple[int, str]:
    own = OPERATORS[value.sign].strength
    sign = value.sign
    if isinstance(value.right, Truth):
        sign = {"==": "is", "!=": "is not"}.get(sign, sign)
    left_bound = own if own == COMPARES else own - 1
    return own, f"{_value(value.left, left_bound)} {sign} {_value(value.right, own)}"


def _number(value: Number) -> str:
    if not value.percent:
        return _decimal(value.value)
    for text in (_decimal(round(value.value * 100.0, 9)), _decimal(value.value * 100.0)):
        if float(text) / 100.0 == value.value:
            return f"{text}%"
    return _decimal(value.value)


def _decimal(value: float) -> str:
    text = repr(float(value))
    return text.removesuffix(".0")
