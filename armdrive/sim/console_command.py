"""What a command of the console is, and what it answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.sim.saved import Json

if TYPE_CHECKING:
    from armdrive.sim.console import Console


@dataclass(frozen=True, slots=True)
class Answer:
    """What a command has to say: a sentence for people, or the same and more as data."""

    text: str
    data: Json = None


@dataclass(frozen=True, slots=True)
class ConsoleCommand:
    """One row of the table: how it is called, what follows, what it does."""

    name: str
    arguments: str
    summary: str
    run: Callable[[Console, list[str]], Answer]
    counts: tuple[int, int]
    """The least and the most words that may follow."""

    @property
    def usage(self) -> str:
        """How it is written."""
        return f"{self.name} {self.arguments}".strip()
