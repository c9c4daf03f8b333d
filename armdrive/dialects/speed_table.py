"""Convert speed settings to step rates with a table, and measure how far the table is wrong.

The table from a TeachMover's SP to half-steps a second was never published, so the arm file's
table is an assumption. The meter compares each answer with it, and bursts are shortened if the arm
is slower. Until a part of the table has been measured, the arm is assumed to be slower by the
arm file's `speed_margin`. Arms without a table use the meter of a single part.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import itemgetter
from typing import Any

from armdrive.errors import ArmFileError
from armdrive.text.toml import setting


@dataclass(frozen=True, slots=True)
class SpeedTable:
    """Pairs of (setting, steps a second), rising in both.

    Settings between two pairs are `interpolated`, or are never used: some boards round them. Raises
    `ArmFileError`, since the pairs come from an arm file.
    """

    points: tuple[tuple[int, float], ...]
    interpolated: bool = True

    def __post_init__(self) -> None:
        if len(self.points) < 2 or any(
            low[0] >= high[0] or not 0.0 < low[1] < high[1] for low, high in pairwise(self.points)
        ):
            raise ArmFileError(
                "speed_table needs two or more pairs [setting, steps per second], both rising, "
                "for example [[0, 30], [240, 470]]"
            )

    @property
    def settings(self) -> Sequence[int]:
        """The settings that may be used, the slowest first."""
        listed = [setting for setting, _ in self.points]
        return range(listed[0], listed[-1] + 1) if self.interpolated else listed

    @property
    def fastest_hz(self) -> float:
        """The steps a second of the fastest setting."""
        return self.points[-1][1]

    def rate_hz(self, setting: int) -> float:
        """Return the steps a second that the table gives for a setting inside it."""
        (low, low_hz), (high, high_hz) = self._interval(setting)
        return low_hz + (high_hz - low_hz) * (setting - low) / (high - low)

    def setting(self, rate_hz: float) -> int:
        """Return the fastest setting that is no faster than `rate_hz`; the slowest if all are."""
        settings = self.settings
        found = bisect_right(settings, rate_hz + 1e-9, key=self.rate_hz)
        return settings[max(found - 1, 0)]

    def part(self, setting: int) -> int:
        """Return which part of the table a setting lies in, 0 for the slowest."""
        return max(bisect_right(self.points, setting, key=itemgetter(0)) - 1, 0)

    def _interval(self, setting: int) -> tuple[tuple[int, float], tuple[int, float]]:
        index = min(self.part(setting), len(self.points) - 2)
        return self.points[index], self.points[index + 1]


def speed_margin(default: float) -> Any:
    """Declare the key `speed_margin` of a dialect's section, with its default."""
    means = "how many times slower the arm may be, until it has been measured"
    return setting(default, means, low=1.0, high=20.0)


# A motion shorter or longer than these shares of the expected time is not believed: its answer may
# be another command's. The upper share is of the longest time that the meter still allows.
EARLY, LATE = 0.4, 1.5


@dataclass(slots=True)
class PaceMeter:
    """How much slower than computed an arm is. Slower is believed at once, faster step by step.

    Delays of the wire make motions shorter than `shortest_s` look slower, never faster. The
    resolution of a clock may take `early_s` off a motion's time, and an operating system, an
    adapter or a board may add `late_s`.
    """

    assumed_doubt: float
    shortest_s: float
    early_s: float
    late_s: float
    _known: float | None = None

    @property
    def doubt(self) -> float:
        """The factor by which a motion may last longer than computed."""
        return self.assumed_doubt if self._known is None else self._known

    def learn(self, expected_s: float, measured_s: float) -> bool:
        """Learn from one motion; return False if its duration is impossible.

        A motion that seems too short says nothing about the motors: its answer is another one's.
        """
        believable = self.believable(expected_s, measured_s)
        if expected_s <= 0.0 or measured_s < self._shortest_s(expected_s):
            return believable
        factor = max(measured_s / expected_s, 1.0)  # an early answer proves no faster motor
        known = factor if self._known is None else self._known
        # short motions may clear a suspicion, but never raise one
        if expected_s >= self.shortest_s or (self._known is not None and factor < known):
            # slower counts in full; faster by a quarter, because one short time may be chance
            self._known = max(factor, known + (factor - known) / 4.0)
        return believable

    def believable(self, expected_s: float, measured_s: float) -> bool:
        """Return whether a motion can have this duration on this arm, as far as it is known."""
        longest_s = expected_s * self.doubt * LATE + self.late_s
        return self._shortest_s(expected_s) <= measured_s <= longest_s

    def _shortest_s(self, expected_s: float) -> float:
        return expected_s * EARLY - self.early_s


class SpeedMeter:
    """How much slower than its table the arm is, for each part of the table."""

    def __init__(self, table: SpeedTable, assumed_doubt: float) -> None:
        self._table = table
        self._parts = defaultdict[int, PaceMeter](
            lambda: PaceMeter(assumed_doubt, SHORTEST_MEASURED_S, CLOCK_S, DELAY_S)
        )

    def part(self, setting: int) -> PaceMeter:
        """Return the meter of the part of the table that contains a setting."""
        return self._parts[self._table.part(setting)]

    def longest_s(self, steps: float, setting: int) -> float:
        """Return how long these steps take if the arm is as slow as it may be."""
        return steps / self._table.rate_hz(setting) * self.part(setting).doubt

    def timeout_s(self, steps: float, setting: int) -> float:
        """Return how long the end of these steps is awaited."""
        return TIMEOUT_FACTOR * self.longest_s(steps, setting)


# The timeout of a motion, as a multiple of the slowest arm's time. It exceeds `LATE`: an answer,
# even one that is not believed, shows that the arm can be asked where it is.
TIMEOUT_FACTOR = 2.0

# The time of a shorter motion says more about the wire than about the motors.
SHORTEST_MEASURED_S = 0.04
# Delay that the operating system and an adapter may add to an answer.
DELAY_S = 0.05
# Error of a measured time due to the clock's resolution.
CLOCK_S = 0.02
