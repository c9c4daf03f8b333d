"""A Robko 01 that is not there: the arm's end of its SUPER protocol on a simulated physical arm.

Everything that was seen of the AVR firmware is repeated, and what public sources say of the ESP32
retrofit. Where a habit is unknown the harsher one is built: after power-up the motors are off,
motors that are switched off in mid-motion are counted on though nothing turns, and `Clear` ends
a motion dead.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from armdrive.sim.device import BoxedDevice
from armdrive.sim.robko01.box import RobkoBox, RobkoDrive, RobkoQuirks
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import Json

BAUD = 115_200


class SimRobko(BoxedDevice):
    """The board, the arm, and the person beside them; see `RobkoQuirks` for what differs."""

    title: ClassVar[str] = "Robko 01"
    box: RobkoBox
    _drive: RobkoDrive

    def __init__(
        self,
        world: World | None = None,
        *,
        quirks: RobkoQuirks | None = None,
        baud: int | None = BAUD,
    ) -> None:
        world = world or World()
        quirks = quirks or RobkoQuirks()
        world.energised = False
        super().__init__(world, RobkoDrive(world, quirks), baud)
        self.box = RobkoBox(self._drive, self.clock, quirks, self.said, lambda: self.inputs_set)

    def details(self) -> dict[str, Json]:
        """Return the board, its outputs and whether its motors are on."""
        return {
            "board": self.box.quirks.board,
            "enabled": self.box.enabled,
            "outputs": self.box.outputs,
            "dropped": self.box.dropped,
        }

    def jog(self, steps: Sequence[int]) -> None:
        """Move by hand of a person at the arm; motors that were off are off again behind it."""
        held = self.world.energised
        super().jog(steps)
        self.world.energised = held

    def reset(self) -> None:
        """Begin the firmware anew: motion stops dead, positions are zero, and the motors off."""
        if self.powered:
            self.power_off()
            self.power_on()
