"""A simulated twin: an arm's world, its controller and the wire to it, for one process."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.sim.blocks import Block
from armdrive.sim.body import ArmBody
from armdrive.sim.operator import SimulatedOperator
from armdrive.sim.saved import Json
from armdrive.sim.teachmover import SimTeachMover
from armdrive.sim.teachmover_file import device_from_json, device_to_json
from armdrive.sim.world import World
from armdrive.transports.memory import MemoryLink

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig


@dataclass(frozen=True, slots=True)
class Twin:
    """The simulated counterpart of a connected arm. `world` is the physical truth."""

    device: SimTeachMover
    link: MemoryLink
    operator: SimulatedOperator

    @property
    def world(self) -> World:
        """The physical arm and what is around it."""
        return self.device.world

    def save(self) -> dict[str, Json]:
        """Return the world and the controller's memory as plain data."""
        return device_to_json(self.device)


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
    device = make_device(config, saved, blocks=blocks, speed_error=speed_error)
    link = MemoryLink(device, config.connection.baud)
    return Twin(device, link, SimulatedOperator(device.world))


def make_device(
    config: ArmConfig,
    saved: object = None,
    *,
    blocks: Iterable[Block] = (),
    speed_error: float = 0.0,
) -> SimTeachMover:
    """Build the simulated device alone, for a process of its own."""
    body = ArmBody.of_preset(config.model)
    baud, grip_bit = config.connection.baud, config.teachmover.grip_bit
    if saved is not None:
        return device_from_json(saved, body, speed_error=speed_error, baud=baud, grip_bit=grip_bit)
    world = World(body, blocks=blocks)
    return SimTeachMover(world, speed_error=speed_error, baud=baud, grip_bit=grip_bit)
