"""How a dialect reads and interprets the pendant program in an arm's own memory.

The registry entry of such a dialect carries one `PendantTools`. All code that reads, writes or
creates a pendant's program goes through it.
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
"""The motor steps at register zero; None if they are unknown."""


@dataclass(frozen=True, slots=True, eq=False)
class PendantTools(Generic[P]):
    """One dialect's programs, converted from the arm's memory, from a file, and back.

    `from_words` decodes the words of every row; `row` creates the row of a motion to absolute
    registers at a share of the arm's speed. `text` returns a program as a file, with the time at
    which it was read and the meaning of each row; `parse` reads such a file of at most
    `largest_bytes`; `view` returns it as plain data. `taught_by` creates points and a sequence with
    a name and a note.
    """

    from_words: Callable[[Sequence[Sequence[int]], Origin], P]
    row: Callable[[ArmConfig, int, float, tuple[int, ...]], Any]
    parse: Callable[[str], P]
    text: Callable[[ArmConfig, P, str], str]
    view: Callable[[ArmConfig, P], dict[str, Any]]
    taught_by: Callable[[ArmConfig, P, str, str], tuple[dict[str, Point], StepList]]
    largest_bytes: int
