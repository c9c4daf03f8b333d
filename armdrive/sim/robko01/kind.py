"""The simulated Robko 01's row: how it is made for an arm, and its settings."""

from __future__ import annotations

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.device import Option, Options
from armdrive.sim.mechanics.motors import checked_error
from armdrive.sim.robko01.box import (
    ACCELERATIONS_STEPS_S2,
    AVR,
    ESP32,
    GRIDS_S,
    TOP_SPEEDS_HZ,
    RobkoQuirks,
)
from armdrive.sim.robko01.device import SimRobko
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world.arm import World

AS_THE_ARM_FILE = "file"


def _make(config: ArmConfig, world: World, options: Options) -> SimRobko:
    chosen = options.text("board")
    board = config.device.board if chosen == AS_THE_ARM_FILE else chosen
    acceleration, watchdog_s = options.number("acceleration"), options.number("watchdog_s")
    if acceleration < 0.0 or watchdog_s < 0.0:
        raise BadRequest("acceleration and watchdog_s must be 0 or above")
    quirks = RobkoQuirks(
        board,
        acceleration or ACCELERATIONS_STEPS_S2[board],
        GRIDS_S[board],
        checked_error(options.number("speed_error")),
        watchdog_s,
        options.flag("rearms"),
        TOP_SPEEDS_HZ[board],
    )
    return SimRobko(world, quirks=quirks, baud=config.connection.baud)


KIND = SimDeviceKind(
    title="Robko 01",
    device=SimRobko,
    make=_make,
    options=(
        Option("board", AS_THE_ARM_FILE, "avr, esp32, or the arm file's", ("file", AVR, ESP32)),
        Option("acceleration", 0.0, "steps/s^2 of every axis; 0: 700 of avr, 75 of esp32"),
        Option("speed_error", 0.0, "0.2: motors a fifth slower than they should be"),
        Option("watchdog_s", 0.0, "seconds without ping, inputs or position; 0: no watchdog"),
        Option("rearms", False, "any frame switches the motors on again, as over UDP"),
    ),
)
