"""A simulated twin: an arm's world, its controller and the wire to it, for one process."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from armdrive.sim.blocks import Block
from armdrive.sim.body import ArmBody
from armdrive.sim.operator import SimulatedOperator
from armdrive.sim.saved import Saved
from armdrive.sim.teachmover import SimTeachMover
from armdrive.sim.world import World
from armdrive.sim.world_file import world_from_json, world_to_json
from armdrive.transports.memory import MemoryLink

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig

REGISTERS = "registers"
WORLD = "world"
REGISTER_RANGE = (-(1 << 15), (1 << 15) - 1)


@dataclass(frozen=True, slots=True)
class Twin:
    """The simulated counterpart of a connected arm. `world` is the physical truth."""

    world: World
    device: SimTeachMover
    link: MemoryLink
    operator: SimulatedOperator

    def save(self) -> dict[str, Any]:
        """Return the world and the controller's registers as plain data."""
        return {WORLD: world_to_json(self.world), REGISTERS: list(self.device.registers)}


def make_twin(
    config: ArmConfig,
    saved: object = None,
    *,
    blocks: Iterable[Block] = (),
    speed_error: float = 0.0,
) -> Twin:
    """Build the twin of an arm: as it was saved, or as one finds it in the morning.

    Raises `StateFileError` where what was saved fits no such arm.
    """
    body = ArmBody.of_preset(config.model)
    if saved is None:
        device = _device(config, World(body, blocks=blocks), speed_error)
    else:
        data = Saved(saved, "simulated arm")
        world = world_from_json(data.anything(WORLD), body)
        device = _device(config, world, speed_error)
        device.count_from(data.wholes(REGISTERS, len(world.motors), *REGISTER_RANGE))
        data.end()
    link = MemoryLink(device, config.connection.baud)
    return Twin(device.world, device, link, SimulatedOperator(device.world))


def make_device(config: ArmConfig, *, speed_error: float = 0.0) -> SimTeachMover:
    """Build the simulated device alone, for a process of its own."""
    return _device(config, World(ArmBody.of_preset(config.model)), speed_error)


def _device(config: ArmConfig, world: World, speed_error: float) -> SimTeachMover:
    return SimTeachMover(
        world,
        speed_error=speed_error,
        baud=config.connection.baud,
        grip_bit=config.teachmover.grip_bit,
    )
