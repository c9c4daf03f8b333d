"""A simulated arm on CiA 402 drives: a `SimDevice` whose box is the drives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from armdrive.sim.bus.box import DrivesBox, NodeControls
from armdrive.sim.bus.line import BusLine
from armdrive.sim.cia402.node import Cia402Node
from armdrive.sim.device import SimDevice, SwitchState
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import Json


class Cia402Errors:
    """What can be wrong with single drives, counted from 0 as the motors."""

    def __init__(self, box: DrivesBox[Cia402Node]) -> None:
        self._nodes, self._clock, self._collect = box.nodes, box.clock, box.collect

    def ail(self, drive: int, code: int) -> None:
        """Have something be wrong with a drive: it fails, until it is mended and reset."""
        node = self._nodes[drive]
        if node.port.powered:
            node.states.ailing.add(code)
            node.states.fault(code, self._clock.now_s)
            self._collect()

    def mend(self, drive: int, code: int) -> None:
        """Have what was wrong with a drive be right again; its fault is to be reset yet."""
        self._nodes[drive].states.mend(code)

    def warn(self, drive: int, code: int) -> None:
        """Have a drive say an EMCY that changes nothing."""
        self._nodes[drive].say_emcy(code)
        self._collect()


class SimCia402(SimDevice):
    """The drives, the arm, and the person beside them. Input bit n is the switch of drive n."""

    title: ClassVar[str] = "arm on CiA 402 drives"
    box: DrivesBox[Cia402Node]

    def __init__(
        self,
        world: World,
        shafts: ShaftDrive,
        nodes: Sequence[Cia402Node],
        bits_s: int,
    ) -> None:
        super().__init__(world, shafts, None)
        self.nodes = tuple(nodes)
        self.box = DrivesBox(
            shafts, self.nodes, self.clock, self.said, lambda: self.powered, idle_looks=False
        )
        self._controls = NodeControls(self.box, bits_s, lambda: self.powered)
        self._errors = Cia402Errors(self.box)

    def line(self) -> BusLine:
        """Make the bus of the drives."""
        return BusLine(self, self._controls.bits_s)

    def drives(self) -> NodeControls:
        """Return what can be done to single drives."""
        return self._controls

    def errors(self) -> Cia402Errors:
        """Return what can be wrong with single drives."""
        return self._errors

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
