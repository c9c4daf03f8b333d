"""The settings of a simulated GRBL board: `$0` to `$132` and beyond, as its EEPROM holds them.

Source: gnea/grbl doc/markdown/settings.md. Lengths are in the machine's own unit, which the board
takes for mm; rates are stored per minute and accelerations per second squared.
"""

from __future__ import annotations

from collections.abc import Mapping

from armdrive.sim.path_line import PathLimits

IDLE_MS, REPORT, JUNCTION = 1, 10, 11
SOFT_LIMITS, HARD_LIMITS, HOMING, HOMING_DIRECTIONS = 20, 21, 22, 23
HOMING_FEED, HOMING_SEEK, DEBOUNCE_MS, PULL_OFF = 24, 25, 26, 27
INCHES = 13
MOST_SPEED, LEAST_SPEED = 30, 31
STEPS, RATE, ACCELERATION, TRAVEL = 100, 110, 120, 130
ALWAYS_ON_MS = 255
"""The step idle delay that leaves the motors on."""

_WHOLE: Mapping[int, float] = {
    0: 10, 1: 25, 2: 0, 3: 0, 4: 0, 5: 0, 6: 0, 10: 1, 13: 0, 20: 0, 21: 0, 22: 0, 23: 0, 26: 250,
    30: 1000, 31: 0, 32: 0,
}  # fmt: skip
_DECIMAL: Mapping[int, float] = {11: 0.01, 12: 0.002, 24: 25.0, 25: 500.0, 27: 1.0}
_PER_AXIS: Mapping[int, float] = {STEPS: 250.0, RATE: 500.0, ACCELERATION: 10.0, TRAVEL: 200.0}
_SHORTEST_PULSE = 3
_MINUTE_S = 60.0


def factory_values(axes: int) -> dict[int, float]:
    """Return the settings of a board as it leaves the factory."""
    each = {group + axis: value for group, value in _PER_AXIS.items() for axis in range(axes)}
    return {**_WHOLE, **_DECIMAL, **each}


class Settings:
    """The values by their numbers; `values` is what a start finds."""

    def __init__(
        self, axes: int, values: Mapping[int, float], factory: Mapping[int, float] | None = None
    ) -> None:
        self.axes = axes
        self.factory = {**factory_values(axes), **(factory or {})}
        self.values = dict(self.factory)
        self.values.update({number: v for number, v in values.items() if number in self.values})

    def __getitem__(self, number: int) -> float:
        return self.values[number]

    def on(self, number: int) -> bool:
        """Return a setting that is yes or no."""
        return bool(self.values[number])

    def mask(self, number: int, axis: int) -> bool:
        """Return an axis's bit of a mask."""
        return bool(int(self.values[number]) >> axis & 1)

    def axis(self, group: int, axis: int) -> float:
        """Return a setting that each axis has: `STEPS`, say."""
        return self.values[group + axis]

    def per_axis(self, group: int) -> tuple[float, ...]:
        """Return such a setting of all axes."""
        return tuple(self.values[group + axis] for axis in range(self.axes))

    @property
    def motors_stay_on(self) -> bool:
        """Whether the motors keep their current while they stand."""
        return self.values[IDLE_MS] == ALWAYS_ON_MS

    @property
    def idle_s(self) -> float:
        """How long after a motion the motors keep it, unless they keep it always."""
        return self.values[IDLE_MS] / 1000

    def limits(self) -> PathLimits:
        """Return what the planner keeps to."""
        return PathLimits(
            self.per_axis(STEPS),
            tuple(rate / _MINUTE_S for rate in self.per_axis(RATE)),
            self.per_axis(ACCELERATION),
            self.values[JUNCTION],
        )

    def store(self, number: int, value: float) -> int:
        """Write a setting; return 0, or the number of the error with which it is refused."""
        if value < 0:
            return 4
        if number not in self.values:
            return 3
        if number == 0 and value < _SHORTEST_PULSE:
            return 6
        if number == SOFT_LIMITS and value and not self.on(HOMING):
            return 10
        if number >= STEPS and not value:
            return 4  # a real board takes it, and then divides by zero
        self.values[number] = float(int(value)) if number in _WHOLE else value
        if number == HOMING and not value:
            self.values[SOFT_LIMITS] = 0.0
        return 0

    def written(self) -> list[tuple[int, str]]:
        """Return the numbers and values as `$$` lists them."""
        return [
            (number, f"{value:.0f}" if number in _WHOLE else f"{value:.3f}")
            for number, value in sorted(self.values.items())
        ]
