"""How fast an Armdroid's motors turn, and how far they leave the straight way.

The board steps every motor that has steps left at the same rate, so a motor with few of them is
done early: the way bends. Steps, steps a second, seconds.
"""

from __future__ import annotations

from bisect import bisect_right

from armdrive.controllers.speed import SpeedMeter, SpeedTable
from kinematics.spaces import Motors

_ROUNDING = 1e-9


class StepRates:
    """The speeds that the board is given, and what has been measured of them."""

    def __init__(self, points: tuple[tuple[int, float], ...], doubt: float) -> None:
        self._rates = dict(points)
        self._meter = SpeedMeter(SpeedTable(points), doubt)

    @property
    def fastest_hz(self) -> float:
        """The greatest rate there is."""
        return max(self._rates.values())

    def rpm(self, rate_hz: float) -> int:
        """Return the fastest speed that is no faster than a rate; the slowest if all are."""
        found = bisect_right(list(self._rates.values()), rate_hz + _ROUNDING)
        return list(self._rates)[max(found - 1, 0)]

    def rate_hz(self, rpm: int) -> float:
        """Return the steps a second at one of the speeds."""
        return self._rates[rpm]

    def longest_s(self, steps: float, rpm: int) -> float:
        """Return how long so many steps may take."""
        return steps / self._rates[rpm] * self._meter.doubt(rpm)

    def measured(self, steps: int, rpm: int, *, least_s: float, most_s: float) -> bool:
        """Learn from a motion that took from `least_s` to `most_s`; False where that is no time.

        The first step is made at once, so that all of them take one interval less than there are.
        """
        whole_s = steps / self._rates[rpm]
        believable = any(
            self._meter.believable(rpm, whole_s, took_s) for took_s in (least_s, most_s)
        )
        self._meter.learn(rpm, (steps - 1) / self._rates[rpm], least_s)
        return believable


def straying(steps: Motors) -> tuple[float, ...]:
    """Return how far each motor is ahead, at most, of its share of the way."""
    most = max(steps.largest, 1)
    return tuple(abs(each) * (1.0 - abs(each) / most) for each in steps)
