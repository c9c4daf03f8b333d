"""The tree of a program: what was written, line by line, comments and blank lines included.

Two trees are the same where they say the same: marks are not compared, nor does it matter how
anything was spaced or in which spelling of a word.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

from armdrive.errors import BadRequest
from armdrive.programs.language.values import slot_of
from armdrive.programs.language.words import WORDS, Slot, ValueKind
from armdrive.programs.problems import SourceMark

# What has a value in a program: the nodes that lines are made with.
#
# Numbers are as written: mm, deg, s. Marks are not compared.

NOWHERE = SourceMark(1)
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
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Truth:
    """`on` or `off`, also written `true` and `false`."""

    value: bool
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class TextValue:
    """A text between quotes."""

    value: str
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)

    def __post_init__(self) -> None:
        one_line(self.value)


@dataclass(frozen=True, slots=True)
class Name:
    """A variable, a parameter, a point of the program, or one of the arm's own book."""

    name: str
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Unary:
    """`-` or `not` before a value. A negative number is a `Number`, see `negative`."""

    sign: str
    value: Expression
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Binary:
    """Two values and what stands between them: `+ - * / == != < <= > >= and or`."""

    left: Expression
    sign: str
    right: Expression
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class FieldOf:
    """A part of a place: `pick.x`."""

    value: Expression
    name: str
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Use:
    """A function with its arguments: `above(pick, 30)`."""

    name: str
    arguments: tuple[Expression, ...] = ()
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class JointsOf:
    """A place in joint angles, deg: `joints(base 0, shoulder 40, ...)`."""

    angles: tuple[tuple[str, Expression], ...]
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


Expression: TypeAlias = (
    Number | Truth | TextValue | Name | Unary | Binary | FieldOf | Use | JointsOf
)


def negative(value: Expression, mark: SourceMark = NOWHERE) -> Expression:
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


@dataclass(frozen=True, slots=True)
class Remark:
    """A comment on a line of its own; None is a blank line."""

    text: str | None = None
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)

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
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Assign:
    """`height = 30`, or with `point` before it, which says that it is a place."""

    name: str
    value: Expression
    point: bool = False
    note: str = field(default="", kw_only=True)
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a subprogram: `fetch(pick)`."""

    name: str
    arguments: tuple[Expression, ...] = ()
    note: str = field(default="", kw_only=True)
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Label:
    """A place in the program that `goto` leads to: `again:`."""

    name: str
    note: str = field(default="", kw_only=True)
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Goto:
    """Go on at a label of the same block, or of one around it."""

    name: str
    note: str = field(default="", kw_only=True)
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class IfBranch:
    """One way of an `if`: None is the condition of `else`."""

    condition: Expression | None
    body: tuple[Statement, ...]
    note: str = field(default="", kw_only=True)
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class If:
    """`if`, any number of `else if`, perhaps `else`: at least one branch."""

    branches: tuple[IfBranch, ...]
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class While:
    """As long as the condition holds."""

    condition: Expression
    body: tuple[Statement, ...]
    note: str = field(default="", kw_only=True)
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Repeat:
    """So many times, or for ever; `variable` counts them from 1."""

    count: Expression | None
    body: tuple[Statement, ...]
    variable: str = ""
    note: str = field(default="", kw_only=True)
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Define:
    """A subprogram with its parameters."""

    name: str
    parameters: tuple[str, ...]
    body: tuple[Statement, ...]
    note: str = field(default="", kw_only=True)
    mark: SourceMark = field(default=NOWHERE, compare=False, kw_only=True)


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


# The lines that begin, divide and end a block, as they are before it is put together.


@dataclass(frozen=True, slots=True)
class IfHead:
    """`if CONDITION`."""

    condition: Expression
    note: str = ""
    mark: SourceMark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class Else:
    """`else`, or `else if CONDITION`."""

    condition: Expression | None
    mark: SourceMark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class WhileHead:
    """`while CONDITION`."""

    condition: Expression
    note: str = ""
    mark: SourceMark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class RepeatHead:
    """`repeat COUNT as NAME`."""

    count: Expression | None
    variable: str
    note: str = ""
    mark: SourceMark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class DefineHead:
    """`define NAME(PARAMETERS)`."""

    name: str
    parameters: tuple[str, ...]
    note: str = ""
    mark: SourceMark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class End:
    """`end`."""

    mark: SourceMark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class Unread:
    """The head of a block that could not be read: its block is left out, and so is its `end`."""

    mark: SourceMark = field(default=NOWHERE)


Opening: TypeAlias = IfHead | WhileHead | RepeatHead | DefineHead | Unread
Head: TypeAlias = Opening | Else | End


# Which names a program's lines set, and which values they use: from the table of words alone.


def slotted(do: Do) -> Iterator[tuple[Expression, Slot]]:
    """Yield the values of a word with their slots; those that belong to none are left out."""
    word = WORDS[do.word]
    known = dict(word.links)
    rows = [(do.arguments, word.slots)]
    rows += [(values, known.get(link, ())) for link, values in do.links]
    for values, slots in rows:
        for index, value in enumerate(values):
            slot = slot_of(slots, index)
            if slot is not None:
                yield value, slot


def set_by(statement: Statement) -> Iterator[tuple[str, SourceMark, ValueKind | None]]:
    """Yield the names that a line itself sets, in lower case, and of which kind it makes them.

    None is the kind of the value that is assigned.
    """
    match statement:
        case Assign():
            yield statement.name.lower(), statement.mark, None
        case Repeat():
            if statement.variable:
                yield statement.variable.lower(), statement.mark, ValueKind.NUMBER
        case Do():
            for value, slot in slotted(statement):
                if slot.sets and isinstance(value, Name):
                    yield value.name.lower(), value.mark, slot.kind


def used_by(statement: Statement) -> Iterator[Expression]:
    """Yield the values that a line itself uses, without the lines within it."""
    match statement:
        case Assign():
            yield statement.value
        case Call():
            yield from statement.arguments
        case While():
            yield statement.condition
        case Repeat():
            if statement.count is not None:
                yield statement.count
        case If():
            for branch in statement.branches:
                if branch.condition is not None:
                    yield branch.condition
        case Do():
            yield from (value for value, slot in slotted(statement) if not slot.sets)


def every(body: tuple[Statement, ...]) -> Iterator[Statement]:
    """Yield every statement of a body and of the blocks within it, in the order of lines."""
    for statement in body:
        yield statement
        for block in bodies(statement):
            yield from every(block)


def subprograms(tree: Tree) -> dict[str, Define]:
    """Return the subprograms by their names in lower case, the first of each name."""
    found: dict[str, Define] = {}
    for statement in tree.body:
        if isinstance(statement, Define):
            found.setdefault(statement.name.lower(), statement)
    return found


def own_names(define: Define | None) -> frozenset[str]:
    """Return the parameters of a subprogram in lower case; none of the program itself."""
    return frozenset(() if define is None else (name.lower() for name in define.parameters))


def scoped(tree: Tree) -> Iterator[tuple[Define | None, Statement]]:
    """Yield every statement with the subprogram that it stands in, None for the program itself."""
    for statement in tree.body:
        define = statement if isinstance(statement, Define) else None
        inner = every((statement,) if define is None else define.body)
        yield from ((define, each) for each in inner if not isinstance(each, Define))


def variables(tree: Tree) -> frozenset[str]:
    """Return the names that the program sets anywhere, parameters left out."""
    return frozenset(
        name
        for define, statement in scoped(tree)
        for name, _, _ in set_by(statement)
        if name not in own_names(define)
    )


def only_shifted(tree: Tree) -> frozenset[str]:
    """Return the names that nothing sets but `shift`: they begin as points of the arm's book."""
    by_others = {
        name
        for define, statement in scoped(tree)
        if not (isinstance(statement, Do) and statement.word == "shift")
        for name, _, _ in set_by(statement)
        if name not in own_names(define)
    }
    return variables(tree) - by_others
