"""How a dialect reads and means the program that an arm keeps in its own memory, for its pendant.

The registry's row of a dialect with such a memory carries one `PendantTools`; whoever reads, writes
or makes a pendant's program goes through it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias, TypeVar

from armdrive.config.arm import ArmConfig
from armdrive.storage.points import Point, StepList

P = TypeVar("P")
"""The value of a whole program."""

Origin: TypeAlias = tuple[int, ...] | None
"""What the arm's registers have to be added to, to be motor steps; None where nobody knows it."""


@dataclass(frozen=True, slots=True, eq=False)
class PendantTools(Generic[P]):
    """One dialect's programs: out of the arm's words, out of a file's text, and back.

    `from_words` reads the words of every row, `row` makes the row of a motion to absolute
    registers at a share of the arm's speed. `text` is a program as a file has it, read `when`, with
    what each row means on an arm; `parse` reads such a text, of `largest_bytes` at most, and `view`
    is the same as plain data. `taught_by` makes points and a sequence of a name, with a note.
    """

    from_words: Callable[[Sequence[Sequence[int]], Origin], P]
    row: Callable[[ArmConfig, int, float, tuple[int, ...]], Any]
    parse: Callable[[str], P]
    text: Callable[[ArmConfig, P, str], str]
    view: Callable[[ArmConfig, P], dict[str, Any]]
    taught_by: Callable[[ArmConfig, P, str, str], tuple[dict[str, Point], StepList]]
    largest_bytes: int
