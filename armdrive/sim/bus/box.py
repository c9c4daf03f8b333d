"""Several simulated drives on one CAN bus: their time, their power, and what befalls one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Generic, TypeVar

from armdrive.errors import BadRequest, StateFileError
from armdrive.sim.bus.line import Outbox
from armdrive.sim.bus.node import BusNode
from armdrive.sim.device import DeviceBox, DeviceClock, SwitchState
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.world.saved import MEND, Json, Saved
from firmware_protocol.frames import Unpacker
from kinematics.spaces import Motors

COUNT_MOST = 1 << 40
N = TypeVar("N", bound=BusNode)


class DrivesBox(DeviceBox, Generic[N]):
    """All drives of an arm: packed frames go in and come out.

    A drive does not hear what the others say: it would matter only if two drives shared an id, or
    a group had the id of a drive. `idle_looks`: whether the shafts are looked at, too, when a
    frame leaves and no drive has anything to do.
    """

    register_range = (-COUNT_MOST, COUNT_MOST)

    def __init__(
        self,
        shafts: ShaftDrive,
        nodes: Sequence[N],
        clock: DeviceClock,
        said: bytearray,
        has_power: Callable[[], bool],
        *,
        idle_looks: bool,
    ) -> None:
        self.nodes = tuple(nodes)
        self.clock = clock
        self._shafts = shafts
        self._said = said
        self._has_power = has_power
        self._idle_looks = idle_looks
        self._unpacker = Unpacker()
        self._outbox = Outbox()
        self._look_s = self._nodes_due_s = math.inf
        self._dues = [math.inf for _ in self.nodes]
        self.collect()

    # What can be seen.

    @property
    def busy(self) -> bool:
        """Whether a drive carries out an order, or a frame is on its way."""
        return self._outbox.next_s < math.inf or any(node.busy for node in self.nodes)

    @property
    def registers(self) -> Motors:
        """Where the drives say that their shafts are."""
        return Motors(node.motor.counts for node in self.nodes)

    @property
    def inputs(self) -> int:
        """A bit for each drive's limit switch."""
        return sum(node.motor.switch.pressed << node.motor.index for node in self.nodes)

    def seen(self) -> list[Json]:
        """Return the drives one by one, as they would tell it."""
        now_s = self.clock.now_s
        errors = self._shafts.errors(now_s)
        return [node.seen(errors[node.motor.index], now_s) for node in self.nodes]

    def known(self) -> dict[str, Json]:
        """Return what is saved of the drives."""
        return {"drives": [{"powered": node.port.powered, **node.known()} for node in self.nodes]}

    def recall_known(self, saved: Saved) -> None:
        """Know what `known` wrote. Raises `StateFileError`."""
        drives = saved.items("drives")
        if len(drives) != len(self.nodes):
            raise StateFileError(
                f"{len(drives)} drives are saved of an arm that has {len(self.nodes)}; {MEND}"
            )
        for node, item in zip(self.nodes, drives, strict=True):
            one = Saved(item, f"drive {node.motor.index + 1}")
            node.port.powered = one.flag("powered") and self._has_power()
            node.recall(one)
            one.end()

    # What a person does.

    def count_from(self, counts: Sequence[int]) -> None:
        """Have the drives say that they stand there; nothing turns."""
        for node, count in zip(self.nodes, counts, strict=True):
            node.motor.count_from(count)

    def press(self, drive: int, on: bool) -> None:
        """Press the limit switch of a drive, or let it go. Raises `BadRequest`."""
        if not 0 <= drive < len(self.nodes):
            raise BadRequest(f"input bits are 0 to {len(self.nodes) - 1}, not {drive}")
        self.nodes[drive].motor.switch.held = on
        self.live()

    def set_switch(self, drive: int, state: SwitchState) -> None:
        """Have the limit switch of a drive stick, or free it."""
        self.nodes[drive].motor.switch.state = state
        self.live()

    # Time.

    def hear(self, data: bytes) -> None:
        """Let the drives hear the frames that have arrived."""
        for frame in self._unpacker.feed(data):
            ears = [node for node in self.nodes if node.listens(frame.can_id)]
            for node in ears:
                node.hear(frame, self.clock.now_s)
            self.collect(ears)

    def due_s(self) -> float:
        """Tell when a drive does something, looks at its shaft, or a frame is ready."""
        return min(self._nodes_due_s, self._outbox.next_s, self._look_s)

    def happen(self) -> None:
        """Let every drive do what is due, and send what is ready."""
        if self._idle_looks or min(self._nodes_due_s, self._look_s) <= self.clock.now_s:
            self.live()
        self._said += self._outbox.take(self.clock.now_s)

    def live(self) -> None:
        """Let every drive do what is due."""
        if self._has_power():
            self._shafts.look(self.clock.now_s)
            for node in self.nodes:
                node.live(self.clock.now_s)
            self.collect()

    def collect(self, nodes: Iterable[N] | None = None) -> None:
        """Take what drives have to say, and see when they have something to do again."""
        self._look_s = self._shafts.look_s
        for node in self.nodes if nodes is None else nodes:
            port, index = node.port, node.motor.index
            self._dues[index] = node.due_s()
            for data in port.said:
                self._outbox.put(self.clock.now_s + port.answer_s, index, data)
            port.said.clear()
        self._nodes_due_s = min(self._dues)

    def motion_ended(self) -> None:
        """Do nothing: each drive ends its own."""

    # Power.

    def boot(self) -> None:
        """Have every drive begin."""
        for node in self.nodes:
            switch_power(node, True, self.clock.now_s)
        self.collect()

    def forget(self) -> None:
        """Have no drive hold its shaft or know where it is, and lose what is on its way."""
        self._release()
        for node in self.nodes:
            switch_power(node, False, self.clock.now_s)
        self._outbox.clear()
        self._unpacker = Unpacker()

    def reset(self) -> None:
        """Have every drive begin again, and for that time let its shaft go."""
        if self._has_power():
            self._release()
            for node in self.nodes:
                if node.port.powered:
                    node.restart(self.clock.now_s)
            self.collect()

    def _release(self) -> None:
        self._shafts.release(range(len(self.nodes)), self.clock.now_s)


def switch_power(node: BusNode, on: bool, now_s: float) -> None:
    """Give a drive its supply, or take it away."""
    if not on:
        node.forget(now_s)
    node.port.powered = on
    if on:
        node.begin(now_s)


class NodeControls:
    """What a fault or a person does to one drive; drives are counted from 0, as the motors.

    `collect` is told whose drive has changed. All raise `BadRequest` for a drive that there is not.
    """

    def __init__(self, box: DrivesBox[Any], bits_s: int, has_power: Callable[[], bool]) -> None:
        self.bits_s = bits_s
        """The speed of the bus."""
        self._nodes: tuple[BusNode, ...] = box.nodes
        self._clock = box.clock
        self._collect = box.collect
        self._has_power = has_power

    def mute(self, drive: int, on: bool) -> None:
        """Have a drive say nothing, while it hears and obeys; or speak again."""
        self.node(drive).port.mute = on

    def plug(self, drive: int, on: bool) -> None:
        """Plug a drive's CAN cable in, or pull it: it neither hears nor says anything then."""
        self.node(drive).port.plugged = on

    def withhold_done(self, drive: int, on: bool) -> None:
        """Have a drive not say that a motion is done, or say it again."""
        self.node(drive).port.withheld = on

    def power(self, drive: int, on: bool) -> None:
        """Take a drive's supply away, and what it holds comes down; or give it back."""
        node = self.node(drive)
        if not on or (self._has_power() and not node.port.powered):
            switch_power(node, on, self._clock.now_s)
        self._collect()

    def reset(self, drive: int) -> None:
        """Have a drive's firmware begin again, in motion or not."""
        if self.node(drive).port.powered:
            self.node(drive).restart(self._clock.now_s)
            self._collect()

    def set_id(self, drive: int, node: int) -> int:
        """Give a drive an id, another one's perhaps; return the old."""
        before = self.node(drive).set_id(node, self._clock.now_s)
        if self.node(drive).port.booting:  # a kind that begins to talk anew has something to do
            self._collect()
        return before

    def set_mode(self, drive: int, mode: int) -> int:
        """Give a drive a mode, as at its own keys; return the old."""
        before = self.node(drive).set_mode(mode, self._clock.now_s)
        self._collect()
        return before

    def node(self, drive: int) -> BusNode:
        """Return a drive."""
        if not 0 <= drive < len(self._nodes):
            raise BadRequest(f"drives are numbered 0 to {len(self._nodes) - 1}, not {drive}")
        return self._nodes[drive]
