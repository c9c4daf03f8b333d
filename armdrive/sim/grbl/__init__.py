"""Builds a simulated GRBL board for an arm, or says why that is impossible.

    firmware   the boards of the family as data: quirks and settings
    orders     what a line or a real-time command does; alarms and restarts
    commands   `$` commands, homing
    board      reports, limits, motion, main loop
    hardware   wiring, outputs, switches, current

A new device has just been switched on, or was reset because its port was opened: its counts are
zero whatever the posture, and it first sends its banner.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

from armdrive.config.arm import ArmConfig
from armdrive.dialects.grbl.settings import BoardAxes, GrblSettings, fitting
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

# The range of a setting per axis: three decimals are stored, and a float holds few more digits.
LEAST, MOST = 0.001, 1e9
# The range in which a board counts steps (gnea/grbl grbl/system.h, sys_position).
FARTHEST_STEPS = 2**31
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
    motors = BoardAxes.of(config)
    limits = motors.expected(device)
    values: dict[int, float] = {
        keys.IDLE_MS: keys.ALWAYS_ON_MS,
        keys.REPORT: MPOS_AND_BUFFERS,
        keys.JUNCTION: limits.junction,
        keys.SOFT_LIMITS: float(device.soft_limits),
        keys.HARD_LIMITS: float(device.hard_limits),
        keys.HOMING: float(device.homing),
        keys.HOMING_DIRECTIONS: 0.0,
        keys.HOMING_SEEK: _up(min(limits.rates) * MINUTE_S * SEEK_SHARE),
        keys.HOMING_FEED: _up(min(limits.rates) * MINUTE_S * FEED_SHARE),
    }
    travels = [_up(travel) for travel in device.travel or map(math.ceil, motors.spans)]
    values[keys.PULL_OFF] = _up(min(travels) * PULL_OFF_SHARE)
    places = switch_places(config, fitting(config), (0,) * len(letters))
    for motor, letter in enumerate(letters):
        axis = axes.index(letter)
        values[keys.HOMING_DIRECTIONS] += (places[motor].way < 0) << axis
        values[keys.STEPS_PER_UNIT + axis] = round(limits.steps_per_unit[motor], 3)
        values[keys.RATE + axis] = _up(limits.rates[motor] * MINUTE_S)
        values[keys.ACCELERATION + axis] = _up(limits.accelerations[motor])
        values[keys.TRAVEL + axis] = travels[motor]
    if config.gripper.kind == "servo" and device.servo == "M3":
        widest = max(device.servo_closed, device.servo_open)
        values[keys.LEAST_SPEED], values[keys.MOST_SPEED] = 0.0, widest
    for number, value in values.items():
        if number >= keys.STEPS_PER_UNIT and not LEAST <= value <= MOST:
            raise ArmFileError(
                f"a GRBL board cannot hold {value:g} as ${number}: correct the motors, speeds, "
                "limits_deg or grbl.unit of the arm file"
            )
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
        name = "spindle" if device.servo == "M3" else f"E{device.servo.partition('E')[2]}"
        return OutputWiring(name, device.servo_closed, device.servo_open, signals=True)
    if config.gripper.kind == "output":
        name, closes = device.outputs[device.gripper_output], device.gripper_closes
        return OutputWiring(name, float(closes), float(not closes))
    return OutputWiring()


def _settings(config: ArmConfig) -> GrblSettings:
    device: GrblSettings = config.device
    return device


def _up(value: float) -> float:
    """Round up to the precision of the board's settings, which is meaningless beyond `MOST`."""
    return math.ceil(value * 1000.0 - 1e-6) / 1000.0 if abs(value) <= MOST else math.inf


# --- The device and its settings ------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class GrblChoices:
    """What can be chosen of a simulated board."""

    firmware: str = setting("mega5x", "the firmware", words=tuple(FIRMWARES))
    axes: str = setting("", "the axes of its build, such as XYZABC; empty: those of the arm")
    factory: bool = setting(False, "factory settings instead of those that the arm needs")
    homing: bool = setting(False, "switch homing on ($22=1), whatever the arm file says")


def _make(config: ArmConfig, world: World, chosen: GrblChoices) -> GrblBoard:
    try:
        return _made(config, world, chosen)
    except OverflowError:
        raise ArmFileError(
            "no motor turns so far: correct limits_deg, homing or steps_per_turn of the arm file"
        ) from None


def _made(config: ArmConfig, world: World, chosen: GrblChoices) -> GrblBoard:
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
