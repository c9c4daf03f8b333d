"""What a speed setting is worth: the table of a controller, and a meter for the truth.

The table from a TeachMover's SP to half-steps a second was never published, so the arm file's
table is an assumption. The meter measures each answer against it, and bursts are shortened where
the arm is slower; until a part of the table has been measured, the arm is taken to be slower by
the doubt that the arm file states.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import pairwise

from armdrive.errors import ArmFileError


@dataclass(frozen=True, slots=True)
class SpeedTable:
    """Pairs of (setting, steps a second), rising in both; settings between are interpolated.

    Raises `ArmFileError`, since the pairs come from an arm file.
    """

    points: tuple[tuple[int, float], ...]
    _rates_hz: tuple[float, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if len(self.points) < 2 or any(
            low[0] >= high[0] or not 0.0 < low[1] < high[1] for low, high in pairwise(self.points)
        ):
            raise ArmFileError(
                "speed_table needs two or more pairs [setting, steps per second], both rising, "
                "for example [[0, 30], [240, 470]]"
            )
        if self.points[-1][0] - self.points[0][0] > MOST_SETTINGS:
            raise ArmFileError(f"speed_table spans more than {MOST_SETTINGS} settings")
        settings = range(self.points[0][0], self.points[-1][0] + 1)
        object.__setattr__(self, "_rates_hz", tuple(map(self.rate_hz, settings)))

    def rate_hz(self, setting: int) -> float:
        """Return the steps a second that the table gives for a setting inside it."""
        (low, low_hz), (high, high_hz) = self._interval(setting)
        return low_hz + (high_hz - low_hz) * (setting - low) / (high - low)

    def setting(self, rate_hz: float) -> int:
        """Return the fastest setting that is no faster than `rate_hz`; the slowest if all are."""
        found = bisect_right(self._rates_hz, rate_hz + 1e-9)
        return self.points[0][0] + max(found - 1, 0)

    def part(self, setting: int) -> int:
        """Return which part of the table a setting lies in, 0 for the slowest."""
        return max(bisect_right([point[0] for point in self.points], setting) - 1, 0)

    def _interval(self, setting: int) -> tuple[tuple[int, float], tuple[int, float]]:
        index = min(self.part(setting), len(self.points) - 2)
        return self.points[index], self.points[index + 1]


@dataclass(slots=True, eq=False)
class SpeedMeter:
    """How much slower than its table the arm is, for each part of the table."""

    table: SpeedTable
    assumed_doubt: float
    _factors: dict[int, float] = field(default_factory=dict)

    def doubt(self, setting: int) -> float:
        """Return the factor by which this setting may be slower than the table says."""
        return self._factors.get(self.table.part(setting), self.assumed_doubt)

    def learn(self, setting: int, expected_s: float, measured_s: float) -> None:
        """Weigh one answer time. Slower is believed at once, faster only bit by bit."""
        if expected_s <= 0.0:
            return
        factor = max(measured_s / expected_s, 1.0)
        part = self.table.part(setting)
        known = self._factors.get(part)
        if expected_s < SHORTEST_MEASURED_S and (known is None or factor > known):
            return  # the wire's own delays make short motions look slower, never faster
        known = factor if known is None else known
        self._factors[part] = max(factor, known + (factor - known) / 4.0)

    def believable(self, setting: int, expected_s: float, measured_s: float) -> bool:
        """Tell whether a motion can have taken that long on this arm as it is known."""
        longest_s = expected_s * self.doubt(setting) * LATE + DELAY_S
        return expected_s * EARLY - CLOCK_S <= measured_s <= longest_s


MOST_SETTINGS = 10_000

SHORTEST_MEASURED_S = 0.04
"""Answers to shorter motions say more about the wire than about the motors."""

EARLY = 0.4
LATE = 1.5
DELAY_S = 0.05
"""What the operating system and an adapter may add to an answer's time."""
CLOCK_S = 0.02
"""What a clock's own steps may take off it."""
