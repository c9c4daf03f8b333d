"""Several simulated drives on one CAN bus: their time, their power, and faults of one drive.

`node` is one drive's motor, switch, supply and quirks, `line` the bus itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any, Generic, TypeVar

from armdrive.errors import BadRequest
from armdrive.sim.bus.line import BusLine
from armdrive.sim.bus.node import BusNode, NodePort, switch_power
from armdrive.sim.device import Board
from armdrive.sim.mechanics.motors import SwitchState
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.wire import TimeQueue
from armdrive.sim.world import World
from armdrive.sim.world.saved import Json, unfit
from firmware_protocol.frames import Frame
from kinematics.spaces import Motors
from kinematics.text import counted

COUNT_MOST = 1 << 40  # more than any shaft ever counts
N = TypeVar("N", bound=BusNode)


class DrivesBoard(Board, Generic[N]):
    """All drives of an arm in the place of one board: frames go in and come out.

    Input bit n is the switch of drive n. Drives do not receive each other's frames: that would
    matter only if two drives shared an id, or a group had the id of a drive.
    """

    register_range = (-COUNT_MOST, COUNT_MOST)
    message = tuple

    def __init__(self, world: World, shafts: ShaftDrive, nodes: Sequence[N], bits_s: int) -> None:
        super().__init__(world, shafts, None)
        self.nodes = tuple(nodes)
        self.input_bits = len(self.nodes)
        self._shafts = shafts
        self._outbox: TimeQueue[Frame] = TimeQueue()
        """The frames that drives prepare. Those of drives with one id pass one after the other."""
        self._dues = [math.inf for _ in self.nodes]
        """When each drive acts next."""
        self._changed = list(self.nodes)
        """The drives whose times may have changed since they were asked."""
        self._drives_due_s = math.inf
        """When a drive acts next, or its shaft is due."""
        for node in self.nodes:
            node.port.send = partial(self._prepare, node.port)
        self.outgoing = []
        self.bits_s = bits_s
        """The bit rate of the bus."""
        self.line = partial(BusLine, bitrate=bits_s)

    # What can be seen.

    @property
    def busy(self) -> bool:
        """Whether a drive is carrying out an order, or a frame is on its way."""
        return self._outbox.next_s < math.inf or any(node.busy for node in self.nodes)

    @property
    def registers(self) -> Motors:
        """The shaft positions that the drives report."""
        return Motors(node.motor.counts for node in self.nodes)

    @property
    def inputs(self) -> int:
        """A bit for each drive's limit switch."""
        return sum(node.motor.switch.pressed << node.motor.index for node in self.nodes)

    def details(self) -> dict[str, Json]:
        """Return each drive's data, as the drive would report it."""
        errors = self._shafts.errors(self.now_s)
        seen: list[Json] = [node.seen(errors[node.motor.index], self.now_s) for node in self.nodes]
        return {"bits_s": self.bits_s, "drives": seen}

    def known(self) -> Any:
        """Return what is saved of the drives."""
        return self.saved_as(drives=tuple(node.known() for node in self.nodes))

    def recall_known(self, saved: Any) -> None:
        """Restore what `known` returned. Raises `StateFileError`."""
        if len(saved.drives) != len(self.nodes):
            raise unfit(
                f"{counted(len(saved.drives), 'drive is', 'drives are')} saved of an arm that has "
                f"{len(self.nodes)}"
            )
        for node, one in zip(self.nodes, saved.drives, strict=True):
            node.port.powered = one.powered and self.powered
            node.recall(one)

    # What a person does.

    def count_from(self, registers: Sequence[int]) -> None:
        """Set the drives' counts; nothing turns."""
        for node, count in zip(self.nodes, registers, strict=True):
            node.motor.count_from(count)

    def set_input(self, bit: int, on: bool) -> None:
        """Press or release the limit switch of a drive. Raises `BadRequest`."""
        super().set_input(bit, on)
        self.set_switch(bit, SwitchState.CLOSED if on else SwitchState.FREE)

    def set_switch(self, axis: int, state: SwitchState) -> None:
        """Make the limit switch of a motor (counted from 0) stick, or free it."""
        self.nodes[axis].motor.switch.state = state
        self._live()

    def moved_by_hand(self, *, counted: bool) -> None:
        """Let drives that hold turn their shafts back at once if they were turned by force."""
        if not counted:
            self._live()

    # Time.

    def receive(self, message: tuple[Frame, ...]) -> None:
        """Pass the frames that have arrived to the drives that listen for them."""
        now_s = self.now_s
        for frame in message:
            for node in self.nodes:
                if node.listens(frame.can_id):
                    node.receive(frame, now_s)
                    self._changed.append(node)

    def due_s(self) -> float:
        """Return when a drive or its shaft is due, or a frame is ready."""
        if self._changed:
            for node in self._changed:
                self._dues[node.motor.index] = node.due_s()
            self._changed.clear()
            self._drives_due_s = min(*self._dues, self._shafts.look_s)
        return min(self._drives_due_s, self._outbox.next_s)

    def happen(self) -> None:
        """Let every drive do what is due, and send the frames that are ready."""
        if self._drives_due_s <= self.now_s:
            self._live()
        self.outgoing += self._outbox.due(self.now_s)

    def _prepare(self, port: NodePort, frame: Frame) -> None:
        """Put a frame on the bus as soon as a drive has it ready."""
        self._outbox.put(self.now_s + port.answer_s, frame)

    def _live(self) -> None:
        """Let every drive do what is due."""
        if self.powered:
            self._shafts.look(self.now_s)
            for node in self.nodes:
                node.live(self.now_s)
            self._changed += self.nodes

    # Power.

    def boot(self) -> None:
        """Start every drive."""
        for node in self.nodes:
            switch_power(node, True, self.now_s)
        self._changed += self.nodes

    def forget(self) -> None:
        """Release every shaft, forget every position, and drop the frames on their way."""
        self._shafts.release_all(self.now_s)
        for node in self.nodes:
            switch_power(node, False, self.now_s)
        self._outbox.clear()  # what a drive had ready to send dies with its supply

    def reset(self) -> None:
        """Restart every drive; until it has started, its shaft is free."""
        if self.powered:
            self._shafts.release_all(self.now_s)
            for node in self.nodes:
                if node.port.powered:
                    node.restart(self.now_s)
            self._changed += self.nodes

    # What a fault or a person does to one drive, counted from 0 like the motors. What is written in
    # its `port` needs no more than that.

    def node(self, drive: int) -> N:
        """Return a drive, which the caller may change. Raises `BadRequest` if there is none."""
        if not 0 <= drive < len(self.nodes):
            raise BadRequest(f"drives are numbered 0 to {len(self.nodes) - 1}, not {drive}")
        self._changed.append(self.nodes[drive])
        return self.nodes[drive]

    def switch_drive(self, drive: int, on: bool) -> None:
        """Switch a drive's supply off, so that its load sags; or on again."""
        node = self.node(drive)
        if not on or (self.powered and not node.port.powered):
            switch_power(node, on, self.now_s)

    def reset_drive(self, drive: int) -> None:
        """Restart a drive's firmware, in motion or not."""
        node = self.node(drive)
        if node.port.powered:
            node.restart(self.now_s)
