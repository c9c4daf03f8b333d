"""Steppers as the Armdroid's board turns them: all at one rate, each until its own steps are made.

Steps, seconds. The board looks at its clock all the time and steps every motor that has steps left
as soon as the interval since the last step is over, so a motion begins with a step at once.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

_ROUNDING = 1e-6
"""The share of an interval that may be missing through floating-point rounding."""


class LockstepRack:
    """The counts of all motors, and the motion under way."""

    def __init__(self, counts: Sequence[int]) -> None:
        self._counts = tuple(counts)
        self._deltas: tuple[int, ...] | None = None
        self._interval_s = 1.0
        self._first_s = 0.0
        self.last_step_s = -math.inf

    @property
    def moving(self) -> bool:
        """Whether a motion is under way, or has ended and nobody has called `settle` since."""
        return self._deltas is not None

    @property
    def done_s(self) -> float:
        """When the last step is made; infinity while no motion is under way."""
        if self._deltas is None:
            return math.inf
        return self._step_s(max(map(abs, self._deltas)))

    def start(self, deltas: Sequence[int], interval_s: float, now_s: float) -> None:
        """Begin to turn each motor by its own steps."""
        self.stop(now_s)
        self._deltas, self._interval_s = tuple(deltas), interval_s
        self._first_s = max(now_s, self.last_step_s + interval_s) if any(deltas) else now_s

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at a moment."""
        if self._deltas is None:
            return self._counts
        made = self._made(now_s)
        return tuple(
            count + max(-made, min(delta, made))
            for count, delta in zip(self._counts, self._deltas, strict=True)
        )

    def bends(self, start_s: float, end_s: float) -> list[float]:
        """Return when motors fall out of step, one by one."""
        ends = sorted({self._step_s(abs(delta)) for delta in self._deltas or () if delta})
        return [end for end in ends if start_s < end < end_s]

    def settle(self, now_s: float) -> None:
        """Take in a motion that has ended."""
        if self.done_s <= now_s:
            self.stop(now_s)

    def stop(self, now_s: float) -> None:
        """End the motion dead where it is now."""
        self._counts = self.positions(now_s)
        if made := self._made(now_s):
            self.last_step_s = self._step_s(made)
        self._deltas = None

    def count(self, deltas: Sequence[int]) -> None:
        """Count steps that were made apart from any motion."""
        self._counts = tuple(a + b for a, b in zip(self._counts, deltas, strict=True))

    def zero(self) -> None:
        """Begin to count anew; nothing turns."""
        self._counts = (0,) * len(self._counts)
        self._deltas = None

    def _step_s(self, number: int) -> float:
        """Return when a step is made, the first being number 1; number 0 is made at once."""
        return self._first_s + max(number - 1, 0) * self._interval_s

    def _made(self, now_s: float) -> int:
        """Return how many steps the busiest motor has made."""
        if self._deltas is None or now_s < self._first_s:
            return 0
        count = math.floor((now_s - self._first_s) / self._interval_s + _ROUNDING) + 1
        return min(count, max(map(abs, self._deltas)))
