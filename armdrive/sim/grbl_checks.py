"""Whether a GRBL board can be built and set up as an arm file says, before one is simulated.

The driver checks its own part of the file itself; here stands what the board would trip over.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmFileError
from armdrive.sim.grbl_settings import ACCELERATION, RATE, STEPS, TRAVEL

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig

LEAST, MOST = 0.001, 1e9
"""What a setting of an axis may be: three decimals are stored, and a float has not many more."""
FARTHEST_RAD = 1e4
"""More than a thousand turns of a joint."""
FARTHEST_STEPS = 2**31
"""A board counts steps in so many numbers (gnea/grbl grbl/system.h, sys_position)."""

_AXIS_SETTINGS = {
    STEPS: "steps a unit (steps_per_turn, steps_per_mm, grbl.unit)",
    RATE: "a greatest rate (speeds_deg_s, steps_per_turn, grbl.rates)",
    ACCELERATION: "an acceleration (grbl.accelerations, grbl.ramp_s)",
    TRAVEL: "a travel (limits_deg, grbl.travel)",
}


def check_ranges(config: ArmConfig) -> None:
    """Raise `ArmFileError` for angles that no motor could be driven to, and no sum can hold."""
    named = list(zip(config.model.arm.joint_names, config.model.arm.limits, strict=True))
    angles = [
        (f"limits_deg.{name}", end) for name, one in named for end in (one.low_rad, one.high_rad)
    ]
    if config.homing is not None:
        turned = zip(config.model.arm.joint_names, config.homing.joints, strict=True)
        angles += [(f"homing.joints_deg.{name}", angle) for name, angle in turned]
    for key, angle in angles:
        if not abs(angle) <= FARTHEST_RAD:
            raise ArmFileError(
                f"{key} is {math.degrees(angle):g} degrees, farther than any joint turns"
            )


def check_lists(config: ArmConfig, motors: int) -> None:
    """Raise `ArmFileError` for a list that has not an entry for each motor."""
    for name in ("rates", "accelerations", "travel"):
        given = getattr(config.device, name, ())
        if given and len(given) != motors:
            raise ArmFileError(
                f"grbl.{name} must have {motors} entries, one for each motor, not {len(given)}"
            )


def check_gripper(config: ArmConfig) -> None:
    """Raise `ArmFileError` for a gripper on an output that is none."""
    device: Any = config.device
    outputs = getattr(device, "outputs", ())
    bit = getattr(device, "gripper_output", 0)
    if config.gripper.kind == "output" and not 0 <= bit < len(outputs):
        raise ArmFileError(
            f"grbl.gripper_output is bit {bit}, but grbl.outputs names {len(outputs)} outputs, "
            "which count from 0: name the gripper's"
        )


def check_unit(motor: int, per_unit: float) -> float:
    """Return how many steps a unit has; raise `ArmFileError` where it has next to none."""
    if not LEAST <= per_unit <= MOST:
        raise ArmFileError(
            f'grbl.unit: motor {motor + 1} has {per_unit:g} steps a unit, use "steps"'
        )
    return per_unit


def check_settings(values: Mapping[int, float], letters: str, axes: str) -> None:
    """Raise `ArmFileError` for a setting of an axis that no board can hold."""
    for motor, letter in enumerate(letters):
        for group, what in _AXIS_SETTINGS.items():
            value = values[group + axes.index(letter)]
            if not (math.isfinite(value) and LEAST <= value <= MOST):
                raise ArmFileError(
                    f"a GRBL board cannot hold {value:g} as {what} of motor {motor + 1}: correct "
                    "the arm file"
                )


def check_switch(motor: int, steps: float) -> None:
    """Raise `ArmFileError` for a limit switch farther away than a board can count."""
    if not abs(steps) < FARTHEST_STEPS:
        raise ArmFileError(
            f"motor {motor + 1} would stand at {steps:g} steps at its limit switch, farther than "
            "a board counts: correct homing or limits_deg"
        )
