"""What differs from one Robko 01 to another, as the section [robko01] of an arm file."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

from armdrive.text.toml import check_settings, setting


@dataclass(frozen=True, slots=True)
class RobkoBoard:
    """What is taken of a board where the arm file says nothing.

    A motor has a chance to make a step every `step_chance_s` (0: whenever it wants). Firmware
    that does not obey speeds moves every axis at `max_rate_hz`.
    """

    acceleration_steps_s2: float
    max_rate_hz: float
    step_chance_s: float
    obeys_speed: bool = True


BOARDS: Mapping[str, RobkoBoard] = MappingProxyType(
    {
        # seen in a processor simulator: one bus for eight addresses, one of them a millisecond
        "avr": RobkoBoard(700.0, 125.0, 0.008),
        # the retrofit's own build: robko01/robko01_retrofit_fw include/ApplicationConfiguration.h
        # whose main.cpp sets the top speeds once, and never from a request
        "esp32": RobkoBoard(75.0, 100.0, 0.0, obeys_speed=False),
    }
)


@dataclass(frozen=True, slots=True)
class RobkoSettings:
    """The board and what is unverified of it; None takes the value of its row in `BOARDS`."""

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
    speed_doubt: float = setting(
        1.5,
        "how many times slower the arm may be, until it has been measured",
        low=1.0,
        high=20.0,
    )
    watchdog_s: float = setting(
        0.0,
        "the firmware stops after this long without a request; 0: it has no watchdog",
        low=0.0,
        high=3600.0,
    )
    resets_on_open: bool = setting(False, "whether opening the port restarts the board")
    boot_s: float = setting(2.0, "the first answer takes at most this long", low=0.0, high=30.0)
    answer_margin_s: float = setting(0.25, "added to every deadline", low=0.03, high=10.0)
    counts_check: bool = setting(False, "the firmware counts the check bytes into the length")

    def __post_init__(self) -> None:
        check_settings(self, "robko01")

    @property
    def known(self) -> RobkoBoard:
        """The board's numbers, as the file has them or else the table."""
        taken = BOARDS[self.board]
        given = {name: getattr(self, name) for name in _OF_BOARD}
        return replace(taken, **{key: each for key, each in given.items() if each is not None})


_OF_BOARD = ("acceleration_steps_s2", "max_rate_hz", "step_chance_s")


# How a Robko 01 paces its motors: real rates, how long motions last, how far they stray.
#
# Steps, seconds. Every axis runs a trapezoid of its own, all with one acceleration. On a board
# that gives a motor only a chance to make a step every so often, steps come in whole multiples of
# that: the rates are 1/chance, half of it, a third of it, and so on, and nothing in between.

_ROUNDING = 1e-9
SLOWEST_HZ = 1.0
"""Speeds are whole steps a second."""
SPARE = 3
"""Chances that may go by unused: before the first step, and on either side of the ramps."""
SLACK_S = 0.1
"""What a look at the motors may be early or late."""
TOLD_BY_S = 0.1
"""Shorter motions say more about the wire than about the motors."""


@dataclass(frozen=True)
class Pacing:
    """The arithmetic of one board."""

    board: RobkoBoard

    def usable_hz(self, rate_hz: float) -> float:
        """Return the rate that an axis really has, at or below the one wanted.

        Above it on a board that knows only one.
        """
        if not self.board.obeys_speed:
            return self.board.max_rate_hz
        wanted = min(max(rate_hz, SLOWEST_HZ), self.board.max_rate_hz)
        if not self._chance_s:
            return float(math.floor(wanted + _ROUNDING))
        return 1.0 / (self._chances(wanted) * self._chance_s)

    def speeds(self, steps: tuple[int, ...], rate_hz: float) -> tuple[int, ...]:
        """Return what to command, in proportion to the ways, so that no axis ends after the first.

        Rounded upwards: an axis may end early, but never late. One that stays gets 0.
        """
        longest = max(map(abs, steps))
        lead_hz = self._lead_hz(longest, rate_hz)
        return tuple(self._command(lead_hz * abs(each) / longest) if each else 0 for each in steps)

    def lasts_s(self, steps: float, rate_hz: float) -> float:
        """Return how long the axis with most steps takes, at most, ramps included."""
        if steps <= 0.0:
            return 0.0
        lead_hz, ramp = self._lead_hz(steps, rate_hz), self.board.acceleration_steps_s2
        if self._chance_s:
            return self._chance_s * self._turns(math.ceil(steps), self._chances(lead_hz))
        if steps * ramp <= lead_hz**2:
            return 2.0 * math.sqrt(steps / ramp)
        return steps / lead_hz + lead_hz / ramp

    def most_steps(self, time_s: float, rate_hz: float) -> int:
        """Return the most steps that last no longer than a time at a rate; one at least."""
        most = max(math.ceil(time_s * self.usable_hz(rate_hz)), 1)
        return bisect_right(range(2, most + 1), time_s, key=lambda n: self.lasts_s(n, rate_hz)) + 1

    def strays_steps(self, steps: tuple[int, ...], rate_hz: float) -> tuple[float, ...]:
        """Bound how far each axis is from its share of what the longest one has done.

        Of a ramp to v, an axis that ramps to r v makes up to r (1 - r) v^2 / 2a more than its
        share. An axis that was rounded up is ahead by what it has left over when it ends.
        """
        longest = max(map(abs, steps), default=0)
        moving = [abs(each) for each in steps if each]
        if len(moving) < 2:
            return (0.0,) * len(steps)
        lead_hz = self._lead_hz(longest, rate_hz)
        stray = self._stray_by_chances if self._chance_s else self._stray
        ways = [abs(each) for each in steps]
        lead = ways.index(longest)
        return tuple(
            0.0 if axis == lead or not way else min(stray(way, longest, lead_hz), float(way))
            for axis, way in enumerate(ways)
        )

    # -- any rate ---------------------------------------------------------------------------

    def _stray(self, steps: int, longest: int, lead_hz: float) -> float:
        share = steps / longest
        real = self._command(lead_hz * share) / lead_hz
        ramp_steps = lead_hz**2 / (2.0 * self.board.acceleration_steps_s2)
        return real * (1.0 - real) * ramp_steps + steps * (1.0 - share / real) + 1.0

    def _lead_hz(self, steps: float, rate_hz: float) -> float:
        """Return the rate to command of the longest way: none that it cannot come up to."""
        usable_hz = self.usable_hz(rate_hz)
        if self._chance_s or not self.board.obeys_speed:
            return usable_hz
        peak_hz = math.sqrt(steps * self.board.acceleration_steps_s2)
        return max(min(usable_hz, float(math.ceil(peak_hz))), SLOWEST_HZ)

    def _command(self, rate_hz: float) -> int:
        if not self.board.obeys_speed:
            rate_hz = self.board.max_rate_hz
        if self._chance_s:  # a whole multiple of chances that is no slower
            multiple = max(math.floor(1.0 / (rate_hz * self._chance_s) + _ROUNDING), 1)
            rate_hz = 1.0 / (multiple * self._chance_s)
        return max(math.ceil(rate_hz - _ROUNDING), 1)

    # -- a chance now and then --------------------------------------------------------------

    @property
    def _chance_s(self) -> float:
        return self.board.step_chance_s

    def _chances(self, rate_hz: float) -> int:
        """Return how many chances go by from one step to the next at a commanded rate."""
        return max(math.ceil(1.0 / (rate_hz * self._chance_s) - _ROUNDING), 1)

    @cached_property
    def _ramp(self) -> tuple[int, ...]:
        """The chances between one step and the next while an axis speeds up, down to one.

        Step n is due halfway to its place, sqrt((2 n - 1) / a) after the start.
        """
        ramp: list[int] = []
        before_s, number = 0.0, 1
        while not ramp or ramp[-1] > 1:
            due_s = math.sqrt((2 * number - 1) / self.board.acceleration_steps_s2)
            ramp.append(max(math.ceil((due_s - before_s) / self._chance_s - _ROUNDING), 1))
            before_s, number = due_s, number + 1
        return tuple(ramp)

    def _ramp_steps(self, chances: int) -> int:
        """Count the steps that come slower than at the rate of so many chances a step."""
        return next(number for number, each in enumerate(self._ramp) if each <= chances)

    def _turns(self, steps: int, chances: int) -> int:
        """Count the chances from a motion's start to its last step, at most."""
        half = min(self._ramp_steps(chances), (steps + 1) // 2)
        if not half:
            return SPARE + steps * chances
        ramps = 2 * sum(self._ramp[:half]) - self._ramp[0]  # the last step comes before the end
        between = steps - 2 * half + 1
        slowest = self._ramp[half - 1] if between == 1 else chances
        return SPARE + ramps + between * max(chances, slowest)

    def _stray_by_chances(self, steps: int, longest: int, lead_hz: float) -> float:
        share, chances = steps / longest, self._chances(lead_hz)
        real = self._chances(self._command(lead_hz * share)) / chances
        ramp = min(self._ramp_steps(chances), (longest + 1) // 2)
        return (1.0 - 1.0 / real) * ramp + steps * (1.0 - real * share) + 2.0
