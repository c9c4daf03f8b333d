"""Things that a simulated GRBL board does bit by bit: generators that yield until when they wait.

Infinity means "until something has happened": such a script looks again after every event.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, TypeAlias, TypeVar

from firmware_protocol.grbl import Error, LineReceived, Ok, Realtime

if TYPE_CHECKING:
    from armdrive.sim.grbl_board import Board

T = TypeVar("T")
Script: TypeAlias = Generator[float, None, Ok | Error]
"""A line at work; it returns its answer."""
Boot: TypeAlias = Generator[float, None, None]
"""A start."""


@dataclass(frozen=True, slots=True)
class Makers:
    """What a board is made to do with lines, real-time commands and its two kinds of alarms."""

    line: Callable[[Board, LineReceived], Script]
    order: Callable[[Board, Realtime], None]
    critical: Callable[[Board, int], None]
    fail: Callable[[Board, int], None]


class Task(Generic[T]):
    """One script at a time, or none."""

    def __init__(self) -> None:
        self.until_s = math.inf
        self._script: Generator[float, None, T] | None = None

    @property
    def active(self) -> bool:
        """Whether a script is at work."""
        return self._script is not None

    def begin(self, script: Generator[float, None, T], now_s: float) -> None:
        """Take up a script, which takes its first step by `step`."""
        self._script, self.until_s = script, now_s

    def ready(self, now_s: float) -> bool:
        """Tell whether the script wants to go on, or to look."""
        waits = self.until_s > now_s and not math.isinf(self.until_s)
        return self._script is not None and not waits

    def step(self) -> tuple[T] | None:
        """Let the script go on; return what it returned when it is at its end."""
        script = self._script
        if script is None:
            return None
        try:
            self.until_s = next(script)
        except StopIteration as end:
            if self._script is script:  # which may have begun another one
                self.end()
            return (end.value,)
        return None

    def end(self) -> None:
        """Leave the script."""
        if self._script is not None:
            self._script.close()
        self._script, self.until_s = None, math.inf
