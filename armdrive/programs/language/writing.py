"""Writes a tree as text in the present spelling, with its comments and blank lines."""

from __future__ import annotations

from collections.abc import Iterator

from armdrive.programs.language.syntax import (
    Assign,
    Call,
    Define,
    Do,
    Expression,
    Goto,
    If,
    JointsOf,
    Label,
    Literal,
    Name,
    Remark,
    Repeat,
    Statement,
    Tree,
    Use,
    While,
    bodies,
)
from armdrive.programs.language.words import COMPARES, NEGATIVE, OPERATORS, PARTS

# The indentation of each block.
INDENT = "  "


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
        case Literal():
            return _literal(value, strength)
        case Name():
            return value.name
        case JointsOf():
            angles = (f"{name} {_value(each, COMPARES)}" for name, each in value.angles)
            return f"joints({', '.join(angles)})"
        case Use(name=name) if name in OPERATORS:
            own = OPERATORS[name].strength
            text = _operation(name, own, *value.arguments)
            return f"({text})" if own <= strength else text
        case Use(name=name) if name in PARTS:
            return _value(value.arguments[0], _PART) + name
        case Use():
            return f"{value.name}({_listed(value.arguments)})"


_PART = next(iter(PARTS.values())).strength


def _operation(name: str, own: int, first: Expression, second: Expression | None = None) -> str:
    if second is None:
        sign = "-" if name == NEGATIVE else f"{name} "
        return f"{sign}{_value(first, own - 1)}"
    if isinstance(second, Literal) and isinstance(second.value, bool):
        name = {"==": "is", "!=": "is not"}.get(name, name)
    left_bound = own if own == COMPARES else own - 1
    return f"{_value(first, left_bound)} {name} {_value(second, own)}"


def _literal(value: Literal, strength: int) -> str:
    match value.value:
        case bool(on):
            return "on" if on else "off"
        case str(text):
            return '"' + text.replace('"', '""') + '"'
        case amount:
            written = _percent(amount) if value.percent else _decimal(amount)
            return f"({written})" if strength == _PART else written


def _percent(fraction: float) -> str:
    for text in (_decimal(round(fraction * 100.0, 9)), _decimal(fraction * 100.0)):
        if float(text) / 100.0 == fraction:
            return f"{text}%"
    return _decimal(fraction)


def _decimal(value: float) -> str:
    text = repr(float(value))
    return text.removesuffix(".0")
