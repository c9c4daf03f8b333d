"""Limit switches: one for each motor, at one end of its travel."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import Enum

from armdrive.config.arm import ArmConfig
from kinematics.transmission import Transmission


class SwitchState(Enum):
    """How a limit switch behaves."""

    FREE = "free"
    """Follows the arm; works normally."""
    OPEN = "open"
    """Stuck open: never reads as pressed."""
    CLOSED = "closed"
    """Stuck closed: always reads as pressed."""


class LimitSwitch:
    """A switch that a motor presses, at a position and beyond in a direction.

    It depends on where the motor stands (`position`, in steps), and on no register.
    """

    def __init__(self, position: Callable[[], int], at: int, way: int = 1) -> None:
        self.at, self.way = at, way
        self.state = SwitchState.FREE
        self.held = False
        """Whether a person presses it."""
        self._position = position

    @property
    def pressed(self) -> bool:
        """Whether the controller sees it pressed."""
        if self.state is not SwitchState.FREE:
            return self.state is SwitchState.CLOSED
        return self.held or (self._position() - self.at) * self.way >= 0

    def steps_to(self, way: int) -> int | None:
        """Return how many steps in a direction press it; None if none ever do."""
        if self.pressed:
            return 0
        missing = (self.at - self._position()) * way
        return missing if missing > 0 and self.state is SwitchState.FREE else None


def switch_places(
    config: ArmConfig, turning: Transmission, behind: Sequence[int]
) -> tuple[int, ...]:
    """Return where each motor meets its switch: `behind` steps beyond where homing ends.

    If the arm file does not say where homing ends, the switches are at the upper end of each
    motor's travel.
    """
    if config.homing is not None:
        homed = turning.to_motors(config.homing.joints, config.homing.opening_mm)
        return tuple(at + steps for at, steps in zip(homed, behind, strict=True))
    bounds = [(one.low_rad, one.high_rad) for one in config.model.arm.limits]
    bounds.append(config.model.gripper_range_mm)
    highest = (
        sum(max(share * low, share * high) for share, (low, high) in zip(row, bounds, strict=False))
        for row in turning.matrix
    )
    return tuple(
        math.ceil(most + motor.offset_steps)
        for most, motor in zip(highest, turning.motors, strict=True)
    )
