"""The limit switch at the input of a simulated drive: pressed from a physical place on."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from armdrive.sim.device import SwitchState
from armdrive.sim.shafts import ShaftDrive

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig


class LimitSwitch:
    """A switch on the shaft of one motor, at a count and beyond in a direction."""

    def __init__(self, drive: ShaftDrive[Any], motor: int, at: int, way: int) -> None:
        self.at = at
        self.way = way
        self.state = SwitchState.FREE
        self.held = False
        """Whether somebody presses it."""
        self._drive = drive
        self._motor = motor

    @property
    def pressed(self) -> bool:
        """Whether the drive sees it pressed."""
        if self.state is not SwitchState.FREE:
            return self.state is SwitchState.CLOSED
        return self.held or (self._drive.shafts[self._motor] - self.at) * self.way >= 0


def switches(config: ArmConfig, drive: ShaftDrive[Any], *, behind: int = 0) -> list[LimitSwitch]:
    """Return the limit switches: so many counts behind where homing ends by the arm file.

    Where the file tells no such posture, they are at the upper end of each motor's travel.
    """
    turning = drive.world.body.transmission
    if config.homing is not None:
        homed = config.homing
        places = [*turning.to_motors(homed.joints, homed.opening_mm)]
    else:
        places = [_highest(config, row) for row in turning.matrix]
        places = [
            place + math.ceil(motor.offset_steps)
            for place, motor in zip(places, turning.motors, strict=True)
        ]
    return [LimitSwitch(drive, motor, at + behind, 1) for motor, at in enumerate(places)]


def _highest(config: ArmConfig, row: tuple[float, ...]) -> int:
    bounds = [(one.low_rad, one.high_rad) for one in config.model.arm.limits]
    bounds.append(config.model.gripper_range_mm)
    ends = (max(share * low, share * high) for share, (low, high) in zip(row, bounds, strict=False))
    return math.ceil(sum(ends))
