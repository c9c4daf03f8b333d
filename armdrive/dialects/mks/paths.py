"""The path of steered MKS drives: where they are on it, and what comes next. Steps, seconds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from armdrive.dialects.bus.paths import PlannedPath

# How much of the past path is kept: drives that lag may still be found there.
KEPT_S = 1.0
# Step widths of the search for a place on the path: first coarse, then fine.
COARSE_S, FINE_S = 0.01, 0.001


@dataclass(frozen=True, slots=True)
class Heading:
    """A motor's next stretch in one direction (0: it stands).

    Its end, when it gets there, and its mean speed on the way.
    """

    direction: int
    end: float
    until_s: float
    speed: float


class SteeredPath(PlannedPath):
    """A planned path that is searched for where the drives are."""

    def nearest_s(self, counts: Sequence[int], early_s: float, late_s: float) -> float:
        """Return the path time, between two times, that fits the motors' counts best.

        Of several it is the earliest: repeating a part is safe, leaving one out is not.
        """
        for step_s in (COARSE_S, FINE_S):  # the second search is around the find of the first
            steps = max(math.ceil((late_s - early_s) / step_s), 1)
            times = [min(early_s + step * step_s, late_s) for step in range(steps + 1)]
            found_s = min(times, key=lambda time_s: self._off(counts, time_s))
            early_s, late_s = max(found_s - step_s, early_s), min(found_s + step_s, late_s)
        return found_s

    def explains(
        self, counts: Sequence[int], margins: Sequence[float], early_s: float, late_s: float
    ) -> bool:
        """Return whether a single path time explains the counts of all motors."""
        # backwards, since drives are hardly ever late by much: the first looks decide
        time_s = late_s
        while time_s > early_s - COARSE_S:
            at_s = max(time_s, early_s)
            found = enumerate(zip(counts, margins, strict=True))
            if all(abs(self.at(motor, at_s) - count) <= most for motor, (count, most) in found):
                return True
            time_s -= COARSE_S
        return False

    def _off(self, counts: Sequence[int], time_s: float) -> float:
        return max(abs(self.at(motor, time_s) - count) for motor, count in enumerate(counts))

    def heading(self, motor: int, from_s: float, until_s: float) -> Heading:
        """Return a motor's next stretch between two times, up to where it turns back."""
        direction, start, end_s = 0, self.at(motor, from_s), from_s
        end = start
        for segment in self._segments:
            if segment.end_s <= from_s:
                continue
            if segment.start_s >= until_s:
                break
            turn = segment.end[motor] - segment.start[motor]
            if turn * direction < 0:
                break
            if turn:
                direction = 1 if turn > 0 else -1
                end_s = min(segment.end_s, until_s)
                end = segment.at(motor, end_s)
        distance = abs(end - start)
        return Heading(direction, end, end_s, distance / (end_s - from_s) if distance else 0.0)

    def fastest(self, motor: int, from_s: float, until_s: float) -> float:
        """Return a motor's greatest speed between two times."""
        speeds = (
            abs(each.end[motor] - each.start[motor]) / (each.end_s - each.start_s)
            for each in self._segments
            if each.end_s > from_s and each.start_s < until_s
        )
        return max(speeds, default=0.0)
