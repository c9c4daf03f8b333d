"""Builds a simulated GRBL board for an arm, or says why that is impossible.

    firmware   the boards of the family as data: quirks and settings
    orders     what a line or a real-time command does; alarms and restarts
    commands   `$` commands, homing
    board      reports, limits, motion, main loop
    hardware   wiring, outputs, switches, current

Rates, travels and switch positions are computed here from the arm file, independently of the
driver, so that a difference shows. A new device has just been switched on, or was reset because its
port was opened: its counts are zero whatever the posture, and it first sends its banner.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from armdrive.config.arm import ArmConfig
from armdrive.dialects.grbl.settings import GrblSettings, fitting
from armdrive.errors import ArmFileError, BadRequest
from armdrive.sim.grbl.board import GrblBoard
from armdrive.sim.grbl.firmware import FIRMWARES, MINUTE_S, BoardSettings
from armdrive.sim.grbl.hardware import BoardBuild, OutputWiring, Switches
from armdrive.sim.grbl.orders import ROUTINES
from armdrive.sim.mechanics.motors import LimitSwitch, switch_places
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world import World
from armdrive.text.toml import setting
from firmware_protocol.grbl import AXIS_LETTERS, keys
from kinematics.transmission import Transmission

# --- What the board would trip over in an arm file -----------------------------------------------
# What the driver would trip over as well, `fitting` finds.

# The range of a setting per axis: three decimals are stored, and a float holds few more digits.
LEAST, MOST = 0.001, 1e9
# More than a thousand turns of a joint.
FARTHEST_RAD = 1e4
# The range in which a board counts steps (gnea/grbl grbl/system.h, sys_position).
FARTHEST_STEPS = 2**31

_AXIS_SETTINGS = {
    keys.STEPS_PER_UNIT: "steps a unit (steps_per_turn, steps_per_mm, grbl.unit)",
    keys.RATE: "a greatest rate (speeds_deg_s, steps_per_turn, grbl.rates)",
    keys.ACCELERATION: "an acceleration (grbl.accelerations, grbl.ramp_s)",
    keys.TRAVEL: "a travel (limits_deg, grbl.travel)",
}


def _check_ranges(config: ArmConfig) -> None:
    """Raise `ArmFileError` for angles out of reach of any motor, or too large to add up."""
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


def _check_settings(values: Mapping[int, float], letters: str, axes: str) -> None:
    """Raise `ArmFileError` for a per-axis setting that no board can store."""
    for motor, letter in enumerate(letters):
        for group, what in _AXIS_SETTINGS.items():
            value = values[group + axes.index(letter)]
            if not (math.isfinite(value) and LEAST <= value <= MOST):
                raise ArmFileError(
                    f"a GRBL board cannot hold {value:g} as {what} of motor {motor + 1}: correct "
                    "the arm file"
                )


MPOS_AND_BUFFERS = 3
# The speeds of homing, as shares of an axis's own maximum rate.
SEEK_SHARE, FEED_SHARE = 0.5, 0.05
# How far axes back off their switches, as a share of the travel.
PULL_OFF_SHARE = 0.005


def motor_letters(config: ArmConfig) -> str:
    """Return the axis letter of each motor."""
    return _settings(config).axes[: len(fitting(config).motors)]


def board_axes(letters: str, built: str) -> str:
    """Return the axes of the board in its own order: those needed, or those built in."""
    axes = "".join(letter for letter in AXIS_LETTERS if letter in (built or letters))
    if not set(letters) <= set(axes) or set(built) - set(AXIS_LETTERS):
        raise BadRequest(f"a board with the axes {built} has no motors for {letters}")
    return axes


def well_set_up(config: ArmConfig, letters: str, axes: str) -> dict[int, float]:
    """Return the settings of a board that was configured correctly for this arm.

    Raises `ArmFileError` for an arm that no board can be configured for.
    """
    device = _settings(config)
    turning = fitting(config)
    _check_ranges(config)
    per_unit = _steps_per_unit(device, turning)
    rates = device.rates or _rates_hz(config, turning)
    slopes = device.accelerations or tuple(rate / device.ramp_s for rate in rates)
    spans = _spans(config, turning)
    travels = device.travel or tuple(
        math.ceil(span / per) for span, per in zip(spans, per_unit, strict=True)
    )
    values: dict[int, float] = {
        keys.IDLE_MS: keys.ALWAYS_ON_MS,
        keys.REPORT: MPOS_AND_BUFFERS,
        keys.JUNCTION: device.junction_steps / max(per_unit),
        keys.SOFT_LIMITS: float(device.soft_limits),
        keys.HARD_LIMITS: float(device.hard_limits),
        keys.HOMING: float(device.homing),
        keys.HOMING_DIRECTIONS: 0.0,
    }
    places = switch_places(config, turning, (0,) * len(letters))
    for motor, letter in enumerate(letters):
        axis, per = axes.index(letter), per_unit[motor]
        values[keys.HOMING_DIRECTIONS] += (places[motor].way < 0) << axis
        values[keys.STEPS_PER_UNIT + axis] = per
        values[keys.RATE + axis] = _up(rates[motor] / per * MINUTE_S)
        values[keys.ACCELERATION + axis] = _up(slopes[motor] / per)
        values[keys.TRAVEL + axis] = travels[motor]
    slowest = min(rates[motor] / per_unit[motor] for motor in range(len(letters))) * MINUTE_S
    values[keys.HOMING_SEEK] = _up(slowest * SEEK_SHARE)
    values[keys.HOMING_FEED] = _up(slowest * FEED_SHARE)
    values[keys.PULL_OFF] = _up(min(travels) * PULL_OFF_SHARE)
    if config.gripper.kind == "servo" and device.servo == "M3":
        widest = max(device.servo_closed, device.servo_open)
        values[keys.LEAST_SPEED], values[keys.MOST_SPEED] = 0.0, widest
    _check_settings(values, letters, axes)
    return values


def switches(
    config: ArmConfig, world: World, letters: str, axes: str, values: dict[int, float]
) -> Switches:
    """Return the limit switches: a pull-off beyond the posture in which homing ends.

    If the arm file states no such posture, they are at the upper end of each motor's travel.
    """
    turned, turning = [axes.index(letter) for letter in letters], fitting(config)
    pull_offs = [
        round(values[keys.PULL_OFF] * values[keys.STEPS_PER_UNIT + axis]) for axis in turned
    ]
    found: dict[int, LimitSwitch] = {}
    for motor, (at, way) in enumerate(switch_places(config, turning, pull_offs)):
        if not abs(at) < FARTHEST_STEPS:
            raise ArmFileError(
                f"motor {motor + 1} would stand at {at:g} steps at its limit switch, farther "
                "than a board counts: correct homing or limits_deg"
            )
        found[turned[motor]] = LimitSwitch(partial(_stands_at, world, motor), at, way)
    return Switches(found)


def _stands_at(world: World, motor: int) -> int:
    return world.motors[motor]


def gripper_wiring(config: ArmConfig) -> OutputWiring:
    """Return which output moves the fingers, if no motor does."""
    device = _settings(config)
    if config.gripper.kind == "servo":
        shut, wide = device.servo_closed, device.servo_open
        if device.servo == "M3":
            return OutputWiring("spindle", 0, shut, wide)
        return OutputWiring("analog", int(device.servo.partition("E")[2]), shut, wide)
    if config.gripper.kind == "output":
        name, closes = device.outputs[device.gripper_output], device.gripper_closes
        what = "digital" if name.startswith("P") else name
        port = int(name[1:]) if what == "digital" else 0
        return OutputWiring(what, port, float(closes), float(not closes))
    return OutputWiring()


def _settings(config: ArmConfig) -> GrblSettings:
    device: GrblSettings = config.device
    return device


def _steps_per_unit(device: GrblSettings, turning: Transmission) -> tuple[float, ...]:
    """Return steps per degree of each motor (per mm for fingers), or 1 if the unit is a step."""
    if device.unit == "steps":
        return (1.0,) * len(turning.motors)
    found = []
    for motor, one in enumerate(turning.motors):
        per_degree = math.pi / 180 if motor < len(turning.joint_names) else 1.0
        per_unit = round(abs(one.steps_per_unit) * per_degree, 3)
        if not LEAST <= per_unit <= MOST:
            raise ArmFileError(
                f'grbl.unit: motor {motor + 1} has {per_unit:g} steps a unit, use "steps"'
            )
        found.append(per_unit)
    return tuple(found)


def _rates_hz(config: ArmConfig, turning: Transmission) -> tuple[float, ...]:
    """Return how fast each motor turns when all joints that it moves are at full speed.

    No motor gets more than the fastest motor needs for a single joint.
    """
    speeds = (*config.model.joint_speeds_rad_s, config.model.gripper_speed_mm_s)
    parts = [
        [abs(share) * speed for share, speed in zip(row, speeds, strict=False)]
        for row in turning.matrix
    ]
    quickest = max(part for row in parts for part in row)
    return tuple(min(sum(row), quickest) for row in parts)


def _spans(config: ArmConfig, turning: Transmission) -> list[float]:
    """Return how many steps each motor can turn within the joints' ranges."""
    ranges = [(one.low_rad, one.high_rad) for one in config.model.arm.limits]
    ranges.append(config.model.gripper_range_mm)
    return [
        sum(abs(share) * (high - low) for share, (low, high) in zip(row, ranges, strict=False))
        for row in turning.matrix
    ]


def _up(value: float) -> float:
    """Round up to the precision of the board's settings."""
    return math.ceil(value * 1000.0 - 1e-6) / 1000.0


# --- The device and its settings ------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class GrblChoices:
    """What can be chosen of a simulated board."""

    firmware: str = setting("mega5x", "the firmware", words=tuple(FIRMWARES))
    axes: str = setting("", "the axes of its build, such as XYZABC; empty: those of the arm")
    factory: bool = setting(False, "factory settings instead of those that the arm needs")
    homing: bool = setting(False, "switch homing on ($22=1), whatever the arm file says")


def _make(config: ArmConfig, world: World, chosen: GrblChoices) -> GrblBoard:
    firmware = FIRMWARES[chosen.firmware]
    letters = motor_letters(config)
    axes = board_axes(letters, chosen.axes)
    values = well_set_up(config, letters, axes)
    wired = switches(config, world, letters, axes, values)
    if chosen.homing:
        values[keys.HOMING] = 1.0
    values = firmware.adapted(values)
    build = BoardBuild(
        firmware,
        axes,
        tuple(axes.index(letter) for letter in letters),
        gripper_wiring(config),
        config.model.gripper_range_mm,
        config.model.gripper_speed_mm_s,
    )
    settings = BoardSettings(len(axes), {} if chosen.factory else values, firmware.factory)
    return GrblBoard(world, build, settings, wired, ROUTINES, config.connection.baud)


KIND = SimDeviceKind(GrblBoard, _make, GrblChoices)
