"""Make a simulated device again from what `to_json` wrote."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from armdrive.sim.body import ArmBody
from armdrive.sim.device import SimDevice
from armdrive.sim.saved import Saved
from armdrive.sim.world import World
from armdrive.sim.world_file import world_from_json

D = TypeVar("D", bound=SimDevice)


def recalled(
    data: object, make: Callable[[World], D], body: ArmBody | None = None, *, what: str = "device"
) -> D:
    """Make the world and the device again; `StateFileError` for what no such device has saved."""
    saved = Saved(data, what)
    device = make(world_from_json(saved.table("world").data, body))
    device.recall(saved)
    saved.end()
    return device
