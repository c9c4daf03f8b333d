"""The simulated Armdroid's row: how it is made for an arm, and its settings."""

from __future__ import annotations

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.armdroid.board import ArmdroidBoard
from armdrive.sim.armdroid.device import SimArmdroid
from armdrive.sim.device import Option, Options
from armdrive.sim.mechanics.motors import checked_error
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world.arm import World

_BOARD = ArmdroidBoard()


def _make(config: ArmConfig, world: World, options: Options) -> SimArmdroid:
    """Make it as a program finds it that has just opened its port."""
    device = SimArmdroid(
        world,
        ArmdroidBoard(
            character_s=_within(options, "character_s", 0.0, 1.0),
            room_bytes=options.whole("room_bytes"),
            boot_s=_within(options, "boot_s", 0.0, 60.0),
            greets=options.flag("greets"),
            resets_on_open=options.flag("resets_on_open"),
            speed_error=checked_error(options.number("speed_error")),
        ),
        baud=config.connection.baud,
    )
    if device.box.board.greets:
        device.opened()
    return device


def _within(options: Options, name: str, low: float, high: float) -> float:
    value = options.number(name)
    if not low <= value <= high:
        raise BadRequest(f"{name} must be from {low:g} to {high:g}, not {value:g}")
    return value


KIND = SimDeviceKind(
    title="Armdroid",
    device=SimArmdroid,
    make=_make,
    options=(
        Option("speed_error", 0.0, "0.2: motors a fifth slower than the sketch says"),
        Option("character_s", _BOARD.character_s, "seconds that the board takes for a character"),
        Option("room_bytes", _BOARD.room_bytes, "so many characters wait during a motion"),
        Option("boot_s", _BOARD.boot_s, "seconds that a reset lasts"),
        Option("greets", _BOARD.greets, "native USB: says Welcome to whoever opens its port"),
        Option("resets_on_open", _BOARD.resets_on_open, "begins anew when its port is opened"),
    ),
)
