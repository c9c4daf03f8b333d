"""The shafts of a simulated arm's MKS drives."""

from __future__ import annotations

from armdrive.sim.mks_motor import SetPoint
from armdrive.sim.shafts import ShaftDrive
from armdrive.sim.world import World
from firmware_protocol.mks import COUNTS_PER_TURN, SPEED_MAX_RPM

MAKES_UP = SPEED_MAX_RPM / 60.0 * COUNTS_PER_TURN
"""Counts a second: no drive makes up for what it has lost faster than it turns."""


class ClosedLoopDrive(ShaftDrive[SetPoint]):
    """Six loops and one arm."""

    def __init__(self, world: World) -> None:
        super().__init__(world, [SetPoint(count) for count in world.motors], MAKES_UP)
