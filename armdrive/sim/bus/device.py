"""A simulated arm on drives of a bus: a `SimDevice` whose box is the drives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Generic, TypeVar

from armdrive.sim.bus.box import DrivesBox, NodeControls
from armdrive.sim.bus.line import BusLine
from armdrive.sim.bus.node import BusNode
from armdrive.sim.device import SimDevice, SwitchState
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import Json

N = TypeVar("N", bound=BusNode)


class SimDrives(SimDevice, Generic[N]):
    """The drives, the arm, and the person beside them. Input bit n is the switch of drive n."""

    idle_looks: ClassVar[bool]
    """Whether shafts are looked at, too, when a frame leaves and no drive has to do anything."""
    box: DrivesBox[N]

    def __init__(self, world: World, shafts: ShaftDrive, nodes: Sequence[N], bits_s: int) -> None:
        super().__init__(world, shafts, None)
        self.nodes = tuple(nodes)
        self.box = DrivesBox(
            shafts,
            self.nodes,
            self.clock,
            self.said,
            lambda: self.powered,
            idle_looks=self.idle_looks,
        )
        self._controls = NodeControls(self.box, bits_s, lambda: self.powered)

    def line(self) -> BusLine:
        """Make the bus of the drives."""
        return BusLine(self, self._controls.bits_s)

    def drives(self) -> NodeControls:
        """Return what can be done to single drives."""
        return self._controls

    @property
    def inputs(self) -> int:
        """A bit for each drive's limit switch."""
        return self.box.inputs

    def details(self) -> dict[str, Json]:
        """Return the drives one by one, as they would tell it."""
        return {"bits_s": self._controls.bits_s, "drives": self.box.seen()}

    def count_from(self, registers: Sequence[int]) -> None:
        """Have the drives say that they stand there; nothing turns."""
        self.box.count_from(registers)

    def set_input(self, bit: int, on: bool) -> None:
        """Press the limit switch of a drive, or let it go."""
        self.box.press(bit, on)
        super().set_input(bit, on)

    def set_switch(self, axis: int, state: SwitchState) -> None:
        """Have the limit switch of a motor (counted from 0) stick, or free it."""
        self.box.set_switch(axis, state)

    def push(self, steps: Sequence[int]) -> None:
        """Turn motors by force, against their drives: those that hold turn them back at once."""
        super().push(steps)
        self.box.live()

    def reset(self) -> None:
        """Have every drive begin again, and for that time let its shaft go."""
        self.box.reset()
