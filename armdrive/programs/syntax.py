"""The tree of a program: what was written, line by line, comments and blank lines included.

Two trees are the same where they say the same: marks are not compared, nor does it matter how
anything was spaced or in which spelling of a word.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from armdrive.programs.acts import Mark
from armdrive.programs.terms import NOWHERE, Expression, one_line


@dataclass(frozen=True, slots=True)
class Remark:
    """A comment on a line of its own; None is a blank line."""

    text: str | None = None
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)

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
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Assign:
    """`height = 30`, or with `point` before it, which says that it is a place."""

    name: str
    value: Expression
    point: bool = False
    note: str = field(default="", kw_only=True)
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Call:
    """A call of a subprogram: `fetch(pick)`."""

    name: str
    arguments: tuple[Expression, ...] = ()
    note: str = field(default="", kw_only=True)
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Label:
    """A place in the program that `goto` leads to: `again:`."""

    name: str
    note: str = field(default="", kw_only=True)
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Goto:
    """Go on at a label of the same block, or of one around it."""

    name: str
    note: str = field(default="", kw_only=True)
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Branch:
    """One way of an `if`: None is the condition of `else`."""

    condition: Expression | None
    body: tuple[Statement, ...]
    note: str = field(default="", kw_only=True)
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class If:
    """`if`, any number of `else if`, perhaps `else`: at least one branch."""

    branches: tuple[Branch, ...]
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class While:
    """As long as the condition holds."""

    condition: Expression
    body: tuple[Statement, ...]
    note: str = field(default="", kw_only=True)
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Repeat:
    """So many times, or for ever; `variable` counts them from 1."""

    count: Expression | None
    body: tuple[Statement, ...]
    variable: str = ""
    note: str = field(default="", kw_only=True)
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Define:
    """A subprogram with its parameters."""

    name: str
    parameters: tuple[str, ...]
    body: tuple[Statement, ...]
    note: str = field(default="", kw_only=True)
    mark: Mark = field(default=NOWHERE, compare=False, kw_only=True)


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
