"""A board's settings against the arm file: what differs, what it does to motion, what mends it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from armdrive.controllers.grbl_axes import Axes
from armdrive.controllers.grbl_plan import Limits
from armdrive.controllers.grbl_settings import GrblSettings
from armdrive.controllers.settings import Difference
from firmware_protocol.grbl import Variant
from firmware_protocol.grbl.words import write_number

Told = Mapping[int | str, str]
"""A board's settings as it tells them, by key."""

ALWAYS_ON = 255
MPOS_AND_BUFFER = 3
STEPS_PER_UNIT, RATES, ACCELERATIONS, TRAVEL = 100, 110, 120, 130
REPORT, JUNCTION, INCHES, SOFT_LIMITS, HARD_LIMITS, HOMING = 10, 11, 13, 20, 21, 22
SAME = 1e-3
"""Settings are reported with three decimals."""
BARELY = 0.02
"""So much slower than expected goes unmentioned."""


def idle_key(settings: GrblSettings, variant: Variant, told: Told) -> int | str:
    """Return the key of the setting that keeps the motors on: FluidNC has a path for it."""
    word = settings.idle_key
    if not word:
        return "/stepping/idle_ms" if variant is Variant.FLUIDNC and 1 not in told else 1
    return int(word) if word.isdigit() else word


@dataclass(frozen=True, slots=True)
class Comparison:
    """What is expected of one board: `board` is the order of its axes, as its settings count."""

    settings: GrblSettings
    axes: Axes
    board: str
    told: Told
    idle: int | str = 1

    def number(self, key: int) -> float | None:
        """Return a setting as a number, None where the board tells none."""
        try:
            value = float(self.told.get(key, ""))
        except ValueError:
            return None
        return value if math.isfinite(value) else None

    def limits(self) -> Limits:
        """Return what the board's axes can really do; what it does not tell is as expected."""
        expected = self.axes.expected(self.settings)
        return replace(
            expected,
            rates=tuple(
                (self._of_axis(RATES, index) or rate * 60.0) / 60.0
                for index, rate in enumerate(expected.rates)
            ),
            accelerations=tuple(
                self._of_axis(ACCELERATIONS, index) or slope
                for index, slope in enumerate(expected.accelerations)
            ),
            junction=self.number(JUNCTION) or expected.junction,
        )

    def differences(self) -> Iterator[Difference]:
        """Give what differs from the arm file, with the line that mends it."""
        yield from self._idle()
        yield from self._reports()
        yield from self._axes()
        junction = self.axes.expected(self.settings).junction
        found = self.number(JUNCTION)
        if found is not None and abs(found - junction) > junction * SAME + SAME:
            yield _difference(JUNCTION, found, junction, "the corner rounding", must=False)
        yield from self._switches()

    def _idle(self) -> Iterator[Difference]:
        found = self.told.get(self.idle)
        try:
            on = found is not None and float(found) == ALWAYS_ON
        except ValueError:
            on = False
        if not on:
            yield Difference(
                f"${self.idle} (motors on while standing)",
                found or "not told",
                str(ALWAYS_ON),
                f"${self.idle}={ALWAYS_ON}",
            )

    def _reports(self) -> Iterator[Difference]:
        mask = self.number(REPORT)
        if mask is not None and int(mask) & MPOS_AND_BUFFER != MPOS_AND_BUFFER:
            wanted = int(mask) | MPOS_AND_BUFFER
            yield _difference(REPORT, mask, wanted, "what reports tell")
        inches = self.number(INCHES)
        if inches:
            yield _difference(INCHES, inches, 0, "reports in inches")

    def _axes(self) -> Iterator[Difference]:
        expected = self.axes.expected(self.settings)
        for index, letter in enumerate(self.axes.letters):
            steps, wanted = self._of_axis(STEPS_PER_UNIT, index), expected.steps_per_unit[index]
            if steps is not None and abs(steps - wanted) > SAME:
                yield self._of(STEPS_PER_UNIT, index, steps, wanted, f"steps a unit of {letter}")
            rate, wanted = self._of_axis(RATES, index), expected.rates[index] * 60.0
            if rate is not None and rate < wanted * (1.0 - BARELY):
                what = f"the fastest rate of {letter}: motion is slower than asked"
                yield self._of(RATES, index, rate, wanted, what, must=False)
            slope, wanted = self._of_axis(ACCELERATIONS, index), expected.accelerations[index]
            if slope is not None and slope < wanted * (1.0 - BARELY):
                what = f"the acceleration of {letter}: motion starts and stops more slowly"
                yield self._of(ACCELERATIONS, index, slope, wanted, what, must=False)
            if self.settings.travel and self.settings.soft_limits:
                travel, wanted = self._of_axis(TRAVEL, index), self.settings.travel[index]
                if travel is not None and abs(travel - wanted) > SAME:
                    what = f"the travel of {letter}"
                    yield self._of(TRAVEL, index, travel, wanted, what, must=False)

    def _switches(self) -> Iterator[Difference]:
        for key, wanted, what in (
            (SOFT_LIMITS, self.settings.soft_limits, "soft limits"),
            (HARD_LIMITS, self.settings.hard_limits, "hard limits"),
            (HOMING, self.settings.homing, "homing"),
        ):
            found = self.number(key)
            if found is not None and bool(found) != wanted:
                yield _difference(key, found, int(wanted), what, must=False)

    def _of_axis(self, group: int, index: int) -> float | None:
        return self.number(group + self.board.index(self.axes.letters[index]))

    def _of(
        self, group: int, index: int, found: float, wanted: float, what: str, *, must: bool = True
    ) -> Difference:
        key = group + self.board.index(self.axes.letters[index])
        return _difference(key, found, wanted, what, must=must)


def _difference(
    key: int, found: float, wanted: float, what: str, *, must: bool = True
) -> Difference:
    rounded = math.ceil(wanted * 1000.0 - 1e-6) / 1000.0
    expected = write_number(rounded)
    return Difference(f"${key} ({what})", write_number(found), expected, f"${key}={expected}", must)
