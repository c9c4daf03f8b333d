"""How an arm's motors are mapped to a board's axes: letters, units, and how fast they turn.

A motion line is relative, in whole motor steps where the board's unit is one: see docs/grbl.md for
why. Its feed stands before its axis words and every number has a sign, so that no lost byte makes
one number out of two words; none but a lost minus makes a way longer.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.controllers.grbl_plan import Limits, Way
from armdrive.controllers.grbl_settings import PINS as PINS
from armdrive.errors import ArmFileError
from firmware_protocol.grbl import AXIS_LETTERS
from kinematics.spaces import Motors

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from armdrive.controllers.grbl_settings import GrblSettings

DECIMALS = 4
"""The decimals of a distance in degrees; a motor step is never finer than that."""
FINEST = 400.0
"""Steps a unit: reports have three decimals, and a step has to show in them."""


@dataclass(frozen=True, slots=True)
class Axes:
    """The axes of an arm's motors, in the motors' order.

    `most_hz` is how fast a motor turns when every joint that it moves is at full speed, and
    `fastest_hz` how fast any motor turns for a single joint: no motion asks for more of a motor,
    where the board grants no motor more.
    """

    letters: str
    steps_per_unit: tuple[float, ...]
    most_hz: tuple[float, ...]
    fastest_hz: float

    @classmethod
    def of(cls, config: ArmConfig) -> Axes:
        """Return those of an arm. Raises `ArmFileError`."""
        settings: GrblSettings = config.device
        transmission = config.model.transmission
        if transmission is None:
            raise ArmFileError("no motor steps are known of this arm: give steps_per_turn")
        count = len(transmission.motors)
        if len(settings.axes) < count:
            raise ArmFileError(
                f"grbl.axes names {len(settings.axes)} axes, but the arm has {count} motors"
            )
        for name in ("rates", "accelerations", "travel"):
            if len(getattr(settings, name)) not in (0, count):
                raise ArmFileError(f"grbl.{name} must have {count} entries, one for each motor")
        per_unit = tuple(
            1.0
            if settings.unit == "steps"
            else _per_degree(abs(motor.steps_per_unit), index, config)
            for index, motor in enumerate(transmission.motors)
        )
        if max(per_unit) > FINEST:
            raise ArmFileError(
                f"grbl.unit: a degree has {max(per_unit):.0f} motor steps, which three decimals "
                'cannot tell apart: use "steps"'
            )
        speeds = (*config.model.joint_speeds_rad_s, config.model.gripper_speed_mm_s)
        turned = [
            [abs(share * speed) for share, speed in zip(row, speeds, strict=False)]
            for row in transmission.matrix
        ]
        return cls(
            settings.axes[:count], per_unit, tuple(map(math.fsum, turned)), max(map(max, turned))
        )

    def expected(self, settings: GrblSettings) -> Limits:
        """Return what the arm file expects of the board."""
        rates_hz = settings.rates or tuple(min(most, self.fastest_hz) for most in self.most_hz)
        slopes = settings.accelerations or tuple(rate / settings.ramp_s for rate in rates_hz)
        return Limits(
            self.steps_per_unit,
            self._in_units(rates_hz),
            self._in_units(slopes),
            settings.junction_steps / max(self.steps_per_unit),
        )

    def _in_units(self, steps: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(count / per for count, per in zip(steps, self.steps_per_unit, strict=True))

    def board(self) -> str:
        """Return the letters of a board that has these axes and no others, in its own order."""
        return "".join(letter for letter in AXIS_LETTERS if letter in self.letters)

    def motors(self, position: tuple[float, ...], board: str) -> Motors:
        """Return whole motor steps out of a board's machine position."""
        placed: Mapping[str, float] = dict(zip(board, position, strict=True))
        return Motors(
            math.floor(placed[letter] * per + 0.5)
            for letter, per in zip(self.letters, self.steps_per_unit, strict=True)
        )

    def words(self, start: Motors, end: Motors) -> str:
        """Return the relative axis words from one absolute position to another.

        They are differences of absolute numbers that were rounded once, so that nothing drifts.
        """
        return "".join(
            f"{letter}{_written(there - here, per)}"
            for letter, here, there, per in zip(
                self.letters,
                self._rounded(start),
                self._rounded(end),
                self.steps_per_unit,
                strict=True,
            )
            if there != here
        )

    def _rounded(self, position: Motors) -> list[int]:
        """Return an absolute position in the last decimal that is written."""
        return [
            count if per == 1.0 else round(count / per * 10**DECIMALS)
            for count, per in zip(position, self.steps_per_unit, strict=True)
        ]


def _per_degree(per_unit: float, index: int, config: ArmConfig) -> float:
    """Return steps a degree of a turning motor; of the gripper's, steps a mm."""
    turning = index < len(config.model.arm.joint_names)
    return math.radians(per_unit) if turning else per_unit


def _written(amount: int, per: float) -> str:
    if per == 1.0:
        return f"{amount:+d}"
    return f"{amount / 10**DECIMALS:+.{DECIMALS}f}".rstrip("0").rstrip(".")


def feed(way: Way) -> str:
    """Return a line's F word, never faster than its speed; without a point where it can be."""
    per_minute = max(way.speed * 60.0, 10.0**-DECIMALS)
    decimals = min(max(3 - math.floor(math.log10(per_minute)), 0), DECIMALS)
    scaled = math.floor(per_minute * 10**decimals + 1e-6)
    text = f"{max(scaled, 1) / 10**decimals:.{decimals}f}"
    return f"F{text.rstrip('0').rstrip('.') if '.' in text else text}"
