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
    config: ArmConfig, saved: object = None, *, blocks: Iterable[Block] = (), speed_error: float = 0.0
) -> Twin:
    """Build the twin of an arm: as it was saved, or as one finds it in the morning.

    Raises `StateFileError` where what was saved fits no such arm.
    """
    body = ArmBody.of_preset(config.model)
    registers: tuple[int, ...] | None = None
    if saved is None:
        world = World(body, blocks=blocks)
    else:
        data = Saved(saved, "simulated arm")
        world = world_from_json(data.anything(WORLD), body)
        registers = data.wholes(REGISTERS, len(world.motors), -(1 << 15), (1 << 15) - 1)
        data.end()
    baud = config.connection.baud
    device = SimTeachMover(
        world, speed_error=speed_error, baud=baud, grip_bit=config.teachmover.grip_bit
    )
    if registers is not None:
        device.count_from(registers)
    return Twin(world, device, MemoryLink(device, baud), SimulatedOperator(world))
