"""Steppers that turn together: where each one stands at any moment, without ticking.

Half-steps, seconds, half-steps a second. The rack counts what was commanded; whether the arm
could follow is the world's business.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

_ROUNDING = 1e-6
"""The share of a step that may be missing through floating-point rounding."""


@dataclass(frozen=True, slots=True)
class Motion:
    """All motors in proportion: the one with the most steps turns at `rate_hz`."""

    deltas: tuple[int, ...]
    rate_hz: float
    start_s: float
    busiest: int = field(init=False)
    """The steps of the motor that has most of them."""
    done_s: float = field(init=False)
    """When the last step has been made."""

    def __post_init__(self) -> None:
        busiest = max(abs(delta) for delta in self.deltas)
        object.__setattr__(self, "busiest", busiest)
        object.__setattr__(self, "done_s", self.start_s + busiest / self.rate_hz)

    def made(self, now_s: float) -> tuple[int, ...]:
        """Return the steps made by now: of each motor's share only whole steps."""
        busiest = self.busiest
        if now_s >= self.done_s:
            return self.deltas
        count = min(max(math.floor((now_s - self.start_s) * self.rate_hz + _ROUNDING), 0), busiest)
        return tuple(
            (abs(delta) * count // busiest) * (1 if delta > 0 else -1) for delta in self.deltas
        )


class MotorRack:
    """The position counts of all motors, and the motion under way."""

    def __init__(self, counts: Sequence[int]) -> None:
        self._counts = tuple(counts)
        self._motion: Motion | None = None

    @property
    def moving(self) -> bool:
        """Whether a motion is under way, or has ended and not been taken in by `settle`."""
        return self._motion is not None

    @property
    def done_s(self) -> float:
        """When the motion under way ends; infinity while there is none."""
        return math.inf if self._motion is None else self._motion.done_s

    def start(self, deltas: Sequence[int], rate_hz: float, now_s: float) -> None:
        """Begin to turn all motors by `deltas`; a motion under way is cut short."""
        self.stop(now_s)
        self._motion = Motion(tuple(deltas), rate_hz, now_s)

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at a moment."""
        if self._motion is None:
            return self._counts
        made = self._motion.made(now_s)
        return tuple(count + step for count, step in zip(self._counts, made, strict=True))

    def bends(self, start_s: float, end_s: float) -> tuple[float, ...]:  # noqa: ARG002
        """Return nothing: motors in proportion leave no straight way."""
        return ()

    def settle(self, now_s: float) -> None:
        """Take in a motion that has ended."""
        if self.done_s <= now_s:
            self.stop(now_s)

    def stop(self, now_s: float) -> None:
        """End the motion where it is now."""
        self._counts = self.positions(now_s)
        self._motion = None

    def count(self, deltas: Sequence[int]) -> None:
        """Count steps that were made apart from any motion."""
        self._counts = tuple(a + b for a, b in zip(self._counts, deltas, strict=True))

    def zero(self) -> None:
        """Begin to count anew; nothing turns."""
        self._counts = (0,) * len(self._counts)
        self._motion = None
