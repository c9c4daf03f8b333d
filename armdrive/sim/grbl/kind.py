"""The simulated GRBL board's row: how it is made for an arm, and its settings."""

from __future__ import annotations

from dataclasses import replace

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.device import Option, Options
from armdrive.sim.grbl.device import SimGrbl
from armdrive.sim.grbl.firmware import FIRMWARES, BoardBuild, BoardSettings
from armdrive.sim.grbl.wiring import (
    board_axes,
    gripper_wiring,
    motor_letters,
    switches,
    well_set_up,
)
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world.arm import World

MOST_COAST = 10.0


def _make(config: ArmConfig, world: World, options: Options) -> SimGrbl:
    firmware = FIRMWARES[options.text("firmware")]
    if options.number("plan_ms") >= 0.0:
        firmware = replace(firmware, plan_s=options.number("plan_ms") / 1000)
    if options.flag("limit_interrupts"):
        firmware = replace(firmware, hard_limits=True)
    coast = options.number("coast")
    if not 0.0 <= coast <= MOST_COAST:
        raise BadRequest(f"coast must be from 0 to {MOST_COAST:g}, not {coast:g}")
    letters = motor_letters(config, len(world.motors))
    axes = board_axes(letters, options.text("axes"))
    values = well_set_up(config, letters, axes)
    wired = switches(config, world, letters, axes, values)
    if options.flag("homing"):
        values[22] = 1.0
    build = BoardBuild(
        firmware,
        axes,
        tuple(axes.index(letter) for letter in letters),
        gripper_wiring(config),
        config.model.gripper_range_mm,
        config.model.gripper_speed_mm_s,
        coast,
        options.flag("resets_on_open"),
    )
    settings = BoardSettings(len(axes), {} if options.flag("factory") else values, firmware.factory)
    return SimGrbl(world, build, settings, wired, config.connection.baud)


KIND = SimDeviceKind(
    title="GRBL board",
    device=SimGrbl,
    make=_make,
    options=(
        Option("firmware", "mega5x", "which one it runs", tuple(FIRMWARES)),
        Option("axes", "", "the axes of its build, XYZABC say; those that are used if left out"),
        Option("factory", False, "settings as it leaves the factory, not as the arm needs them"),
        Option("homing", False, "homing is on ($22=1), whatever the arm file says"),
        Option(
            "limit_interrupts", False, "a build that acts on $21=1 where the usual one does not"
        ),
        Option("resets_on_open", False, "a saved arm is found with its board freshly reset"),
        Option("coast", 1.0, "the arm runs on by this share of the ramp where motors stop dead"),
        Option("plan_ms", -1.0, "milliseconds for each motion; below 0: those of the firmware"),
    ),
)
