"""A Robko 01 that is not there: the arm's end of its SUPER protocol on a simulated physical arm.

Everything that was seen of the AVR firmware is repeated, and what public sources say of the ESP32
retrofit. Where a habit is unknown the harsher one is built: after power-up the motors are off,
motors that are switched off in mid-motion are counted on though nothing turns, and `Clear` ends
a motion dead.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from armdrive.sim.device import SimBase
from armdrive.sim.robko01.box import RobkoBox, RobkoDrive, RobkoQuirks
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import Json, Saved
from kinematics.spaces import Motors

BAUD = 115_200


class SimRobko(SimBase):
    """The board, the arm, and the person beside them; see `RobkoQuirks` for what differs."""

    title: ClassVar[str] = "Robko 01"
    _drive: RobkoDrive

    def __init__(
        self,
        world: World | None = None,
        *,
        habits: RobkoQuirks | None = None,
        baud: int | None = BAUD,
    ) -> None:
        world = world or World()
        habits = habits or RobkoQuirks()
        world.energised = False
        super().__init__(world, RobkoDrive(world, habits), baud)
        self._box = RobkoBox(self._drive, habits, self.said, lambda: self.inputs_set)

    @property
    def habits(self) -> RobkoQuirks:
        """What kind of board it is."""
        return self._box.habits

    @property
    def busy(self) -> bool:
        """Whether a request is unanswered or a motion under way."""
        return self._box.unanswered or self.moving

    @property
    def registers(self) -> Motors:
        """The positions that it reports: they know only what was commanded, and have wrapped."""
        return self._box.registers

    @property
    def enabled(self) -> bool:
        """Whether the board takes motions."""
        return self._box.enabled

    @property
    def outputs(self) -> int:
        """The output byte."""
        return self._box.outputs

    @property
    def dropped(self) -> int:
        """How many pieces of bytes it has dropped in silence, since power-up."""
        return self._box.dropped

    def details(self) -> dict[str, Json]:
        """Return the board, its outputs and whether its motors are on."""
        return {
            "board": self.habits.board,
            "enabled": self.enabled,
            "outputs": self.outputs,
            "dropped": self.dropped,
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

    # The box.

    def _hear(self, data: bytes) -> None:
        self._box.receive(data, self.now_s)

    def _due_s(self) -> float:
        return min(super()._due_s(), self._box.due_s)

    def _happen(self) -> None:
        super()._happen()
        self._box.happen(self.now_s)

    def _motion_ended(self) -> None:
        """Do nothing: whoever wants to know has to ask."""

    def _forget(self) -> None:
        self._drive.rack.restart()
        self._box = RobkoBox(self._drive, self.habits, self.said, lambda: self.inputs_set)

    def _known(self) -> dict[str, Json]:
        return {"enabled": self.enabled, "outputs": self.outputs}

    def _recall_known(self, saved: Saved) -> None:
        self._box.enabled = self.world.energised = saved.flag("enabled")
        self._box.outputs = saved.whole("outputs", 0, 255)
