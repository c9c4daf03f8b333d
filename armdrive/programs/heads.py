"""The lines that begin, divide and end a block, as they are before it is put together."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

from armdrive.programs.acts import Mark
from armdrive.programs.terms import (
    NOWHERE,
    Expression,
)


@dataclass(frozen=True, slots=True)
class IfHead:
    """`if CONDITION`."""

    condition: Expression
    note: str = ""
    mark: Mark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class Else:
    """`else`, or `else if CONDITION`."""

    condition: Expression | None
    mark: Mark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class WhileHead:
    """`while CONDITION`."""

    condition: Expression
    note: str = ""
    mark: Mark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class RepeatHead:
    """`repeat COUNT as NAME`."""

    count: Expression | None
    variable: str
    note: str = ""
    mark: Mark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class DefineHead:
    """`define NAME(PARAMETERS)`."""

    name: str
    parameters: tuple[str, ...]
    note: str = ""
    mark: Mark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class End:
    """`end`."""

    mark: Mark = field(default=NOWHERE)


@dataclass(frozen=True, slots=True)
class Unread:
    """The head of a block that could not be read: its block is left out, and so is its `end`."""

    mark: Mark = field(default=NOWHERE)


Opening: TypeAlias = IfHead | WhileHead | RepeatHead | DefineHead | Unread
Head: TypeAlias = Opening | Else | End
