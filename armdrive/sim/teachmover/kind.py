"""The simulated TeachMover's row: how it is made for an arm, and its settings."""

from __future__ import annotations

from armdrive.config.arm import ArmConfig
from armdrive.dialects.teachmover.controller import TeachMoverSettings
from armdrive.sim.device import Option, Options
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.teachmover.device import SimTeachMover
from armdrive.sim.world.arm import World


def _make(config: ArmConfig, world: World, options: Options) -> SimTeachMover:
    settings: TeachMoverSettings = config.device
    return SimTeachMover(
        world,
        baud=config.connection.baud,
        grip_bit=settings.grip_bit,
        speed_error=options.number("speed_error"),
        keeps_input_while_moving=options.flag("keeps_input_while_moving"),
        delay_unit_s=options.number("delay_unit_s"),
    )


KIND = SimDeviceKind(
    title="TeachMover",
    device=SimTeachMover,
    make=_make,
    options=(
        Option("speed_error", 0.0, "0.2: motors a fifth slower than the driver's table says"),
        Option("keeps_input_while_moving", False, "keeps what comes in during a motion"),
        Option("delay_unit_s", 0.001, "seconds that one count of @DELAY is worth"),
    ),
)
