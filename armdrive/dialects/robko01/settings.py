"""The settings of one Robko 01 (section [robko01] of an arm file), and the timing of its motors."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

from armdrive.dialects.speed_table import speed_margin
from armdrive.text.toml import check_settings, setting


@dataclass(frozen=True, slots=True)
class RobkoBoard:
    """A board's defaults, for settings that are not in the arm file.

    The firmware can step a motor only once every `step_chance_s` (0: at any time). Firmware that
    does not obey speeds moves every axis at `max_rate_hz`.
    """

    acceleration_steps_s2: float
    max_rate_hz: float
    step_chance_s: float
    obeys_speed: bool = True


BOARDS: Mapping[str, RobkoBoard] = MappingProxyType(
    {
        # measured in a processor simulator: eight addresses share a bus, one is served per ms
        "avr": RobkoBoard(700.0, 125.0, 0.008),
        # the retrofit's own build: robko01/robko01_retrofit_fw include/ApplicationConfiguration.h
        # whose main.cpp sets the top speeds once and ignores those in requests
        "esp32": RobkoBoard(75.0, 100.0, 0.0, obeys_speed=False),
    }
)


@dataclass(frozen=True, slots=True)
class RobkoSettings:
    """The board and its unverified properties; None means the default from `BOARDS`."""

    board: str = setting("avr", "the firmware's board: avr or esp32", words=tuple(BOARDS))
    acceleration_steps_s2: float | None = setting(
        None, "the board's own unless it was changed", low=10.0, high=100_000.0
    )
    max_rate_hz: float | None = setting(
        None, "the board's highest step rate", low=1.0, high=5_000.0
    )
    step_chance_s: float | None = setting(
        None, "a motor can step once in this time; 0 at any moment", low=0.0, high=0.1
    )
    speed_margin: float = speed_margin(1.5)
    watchdog_s: float = setting(
        0.0,
        "the firmware stops after this long without a request; 0: it has no watchdog",
        low=0.0,
        high=3600.0,
    )
    resets_on_open: bool = setting(False, "whether opening the port restarts the board")
    boot_s: float = setting(2.0, "the first answer takes at most this long", low=0.0, high=30.0)
    answer_margin_s: float = setting(0.25, "added to every deadline", low=0.03, high=10.0)

    def __post_init__(self) -> None:
        check_settings(self, "robko01")

    @property
    def known(self) -> RobkoBoard:
        """The board's properties: from the arm file, or else from `BOARDS`."""
        taken = BOARDS[self.board]
        given = {name: getattr(self, name) for name in _OF_BOARD}
        return replace(taken, **{key: each for key, each in given.items() if each is not None})


_OF_BOARD = ("acceleration_steps_s2", "max_rate_hz", "step_chance_s")


# How a Robko 01 times its steps: the rates it can produce, durations, and path deviation.
#
# Units: steps and seconds. Every axis runs its own trapezoid; all have the same acceleration. A
# board can step a motor only once per `step_chance_s`, at whole multiples of that time, so the only
# possible rates are 1/chance, 1/(2 chance), 1/(3 chance) and so on. A board that can step at any
# time is taken for one with a short chance.

SHORTEST_CHANCE_S = 1e-3
_ROUNDING = 1e-9
SLOWEST_HZ = 1.0  # speeds are whole numbers of steps per second
SPARE = 3  # chances that may pass unused: before the first step, and on either side of the ramps
SLACK_S = 0.1  # timing uncertainty of a position reading
TOLD_BY_S = 0.1  # in a shorter motion, the line's delay outweighs the motors' speed


@dataclass(frozen=True)
class Pacing:
    """Computes rates, durations and path deviation for one board."""

    board: RobkoBoard

    @property
    def _chance_s(self) -> float:
        return max(self.board.step_chance_s, SHORTEST_CHANCE_S)

    def usable_hz(self, rate_hz: float) -> float:
        """Return the highest rate at or below `rate_hz` that the board can produce.

        A board with a single rate always uses that rate, even if it is higher.
        """
        if not self.board.obeys_speed:
            return self.board.max_rate_hz
        wanted = min(max(rate_hz, SLOWEST_HZ), self.board.max_rate_hz)
        return 1.0 / (self._chances(wanted) * self._chance_s)

    def speeds(self, steps: tuple[int, ...], rate_hz: float) -> tuple[int, ...]:
        """Return the speed to command for each axis, in proportion to its steps.

        Speeds are rounded up, so that no axis arrives after the one with most steps. An axis that
        does not move gets 0.
        """
        longest, lead_hz = max(map(abs, steps)), self.usable_hz(rate_hz)
        return tuple(self._command(lead_hz * abs(each) / longest) if each else 0 for each in steps)

    def lasts_s(self, steps: float, rate_hz: float) -> float:
        """Return the longest time for the axis with most steps, ramps included."""
        if steps <= 0.0:
            return 0.0
        count, chances = math.ceil(steps), self._chances(self.usable_hz(rate_hz))
        half = min(self._ramp_steps(chances), (count + 1) // 2)
        if not half:
            return self._chance_s * (SPARE + count * chances)
        ramps = 2 * sum(self._ramp[:half]) - self._ramp[0]  # the last step comes before the end
        between = count - 2 * half + 1
        slowest = self._ramp[half - 1] if between == 1 else chances
        return self._chance_s * (SPARE + ramps + between * max(chances, slowest))

    def most_steps(self, time_s: float, rate_hz: float) -> int:
        """Return the most steps that fit into a time at a rate; at least one."""
        most = max(math.ceil(time_s * self.usable_hz(rate_hz)), 1)
        return bisect_right(range(2, most + 1), time_s, key=lambda n: self.lasts_s(n, rate_hz)) + 1

    def deviation_steps(self, steps: tuple[int, ...], rate_hz: float) -> tuple[float, ...]:
        """Bound each axis's deviation from its share of the longest axis's progress.

        While the longest axis ramps up, an axis with r times as many steps gets up to (1 - r) of
        the ramp's steps ahead. An axis whose speed was rounded gets ahead or behind as well, most
        of all at its end.
        """
        longest = max(map(abs, steps), default=0)
        lead = next((axis for axis, each in enumerate(steps) if abs(each) == longest), 0)
        lead_hz = self.usable_hz(rate_hz)
        chances = self._chances(self._command(lead_hz))
        ramp = min(self._ramp_steps(chances), (longest + 1) // 2)

        def strays(way: int) -> float:
            share = way / longest
            real = self._chances(self._command(lead_hz * share)) / chances
            off = min(real * share, 1.0 / (real * share))  # 1 if it keeps its share
            return min((1.0 - 1.0 / real) * ramp + way * (1.0 - off) + 2.0, float(way))

        return tuple(
            strays(abs(each)) if each and axis != lead else 0.0 for axis, each in enumerate(steps)
        )

    def _command(self, rate_hz: float) -> int:
        """Return the speed to send for a rate: the next one at or above that the board has."""
        if not self.board.obeys_speed:
            rate_hz = self.board.max_rate_hz
        multiple = max(math.floor(1.0 / (rate_hz * self._chance_s) + _ROUNDING), 1)
        return max(math.ceil(1.0 / (multiple * self._chance_s) - _ROUNDING), 1)

    def _chances(self, rate_hz: float) -> int:
        """Return the number of chances per step at a commanded rate."""
        return max(math.ceil(1.0 / (rate_hz * self._chance_s) - _ROUNDING), 1)

    @cached_property
    def _ramp(self) -> tuple[int, ...]:
        """The number of chances per step while an axis accelerates, until it is one.

        Step n is due halfway to its position, sqrt((2 n - 1) / a) after the start.
        """
        ramp: list[int] = []
        before_s, number = 0.0, 1
        while not ramp or ramp[-1] > 1:
            due_s = math.sqrt((2 * number - 1) / self.board.acceleration_steps_s2)
            ramp.append(max(math.ceil((due_s - before_s) / self._chance_s - _ROUNDING), 1))
            before_s, number = due_s, number + 1
        return tuple(ramp)

    def _ramp_steps(self, chances: int) -> int:
        """Count the steps of the ramp up to a rate, given in chances per step."""
        return next(number for number, each in enumerate(self._ramp) if each <= chances)
