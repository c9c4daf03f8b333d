"""What simulated drives on one bus do alike, whatever they speak: power, cables, time, switches.

What goes in and comes out are packed frames. A drive does not hear what the others say: only where
two have one id, or a group has the id of a drive, would it matter.
"""

from __future__ import annotations

import abc
import math
from collections.abc import Iterable, Sequence
from typing import Any, Generic, Protocol, TypeVar

from armdrive.errors import BadRequest
from armdrive.sim.bus_outbox import Outbox
from armdrive.sim.device import SwitchState
from armdrive.sim.limit_switch import LimitSwitch
from armdrive.sim.saved import Json
from armdrive.sim.shafts import ShaftDrive
from armdrive.sim.sim_base import SimBase
from armdrive.sim.world import World
from firmware_protocol.frames import Frame, Unpacker
from kinematics.spaces import Motors

COUNT_MOST = 1 << 40


class BusNode(Protocol):
    """One drive, as its box knows it."""

    index: int
    powered: bool
    mute: bool
    plugged: bool
    zero: int
    said: list[bytes]
    switch: LimitSwitch

    @property
    def answer_s(self) -> float:
        """How long it takes to have a frame ready."""

    @property
    def shaft(self) -> int:
        """Where its shaft is."""

    @property
    def counts(self) -> int:
        """Where it says that its shaft is."""

    def fall_silent(self, now_s: float) -> None:
        """Lose power: the shaft is free, and all that was under way is forgotten."""

    def begin(self, now_s: float) -> None:
        """Begin, the power having come."""

    def restart(self, now_s: float) -> None:
        """Begin anew, after a while in which nothing holds the shaft and nobody answers."""


N = TypeVar("N", bound=BusNode)


class DrivesBox(SimBase, Generic[N]):
    """The drives, the arm, and the person beside them. Input bit n is the switch of drive n."""

    def __init__(
        self, world: World, drive: ShaftDrive[Any], nodes: Sequence[N], bits_s: int
    ) -> None:
        super().__init__(world, drive, None)
        self.nodes = tuple(nodes)
        self._shafts = drive
        self._bits_s = bits_s
        self._unpacker = Unpacker()
        self._outbox = Outbox()
        self._look_s = self._nodes_due_s = math.inf
        self._dues = [math.inf for _ in self.nodes]
        self._found()

    # What a dialect's drives fill in.

    @abc.abstractmethod
    def _listens(self, node: N, frame: Frame) -> bool:
        """Tell whether a drive takes a frame from the bus: it is there, and minds it."""

    @abc.abstractmethod
    def _bring(self, node: N, frame: Frame) -> None:
        """Let a drive hear a frame, if it is awake and listens at the bus's speed."""

    @abc.abstractmethod
    def _next_of(self, node: N) -> float:
        """Tell when a drive next does something by itself, apart from looking at its shaft."""

    @abc.abstractmethod
    def _live_through(self, node: N) -> None:
        """Have a drive do whatever is due by now."""

    @abc.abstractmethod
    def _seen(self, node: N, error: int) -> dict[str, Json]:
        """Return what a drive would tell of itself, so many counts from its set-point."""

    def _found(self) -> None:
        """Have the drives stand as they are found: by default, just begun."""
        self._boot()

    # What can be seen.

    @property
    def registers(self) -> Motors:
        """Where the drives say that their shafts are."""
        return Motors(node.counts for node in self.nodes)

    @property
    def inputs(self) -> int:
        """A bit for each drive's limit switch."""
        return sum(node.switch.pressed << node.index for node in self.nodes)

    def details(self) -> dict[str, Json]:
        """Return the drives one by one, as they would tell it."""
        errors = self._shafts.errors(self.now_s)
        drives: list[Json] = [self._seen(each, errors[each.index]) for each in self.nodes]
        return {"bits_s": self._bits_s, "drives": drives}

    # What a person can do.

    def count_from(self, registers: Sequence[int]) -> None:
        """Have the drives say that they stand there; nothing turns."""
        for node, count in zip(self.nodes, registers, strict=True):
            node.zero = node.shaft - count

    def set_input(self, bit: int, on: bool) -> None:
        """Press the limit switch of a drive, or let it go."""
        if not 0 <= bit < len(self.nodes):
            raise BadRequest(f"input bits are 0 to {len(self.nodes) - 1}, not {bit}")
        super().set_input(bit, on)
        self.nodes[bit].switch.held = on
        self._live()

    def set_switch(self, axis: int, state: SwitchState) -> None:
        """Have the limit switch of a motor (counted from 0) stick, or free it."""
        self._node(axis).switch.state = state
        self._live()

    def push(self, steps: Sequence[int]) -> None:
        """Turn motors by force, against their drives: those that hold turn them back at once."""
        super().push(steps)
        self._live()

    def power_off(self) -> None:
        """Switch off: the arm sags, and the drives forget where they are."""
        self._shafts.release(range(len(self.nodes)), self.now_s)
        for node in self.nodes:
            node.fall_silent(self.now_s)
            node.powered = False
        super().power_off()

    def reset(self) -> None:
        """Have every drive begin anew, and for that time let its shaft go."""
        if self.powered:
            self._shafts.release(range(len(self.nodes)), self.now_s)
            for node in self.nodes:
                self.reset_drive(node.index)

    # The drives one by one.

    def bits_s(self) -> int:
        """Return the speed of the bus."""
        return self._bits_s

    def mute_drive(self, drive: int, mute: bool) -> None:
        """Have a drive say nothing, while it hears and obeys; or speak again."""
        self._node(drive).mute = mute

    def plug_drive(self, drive: int, on: bool) -> None:
        """Plug a drive's CAN cable in, or pull it: it neither hears nor says anything then."""
        self._node(drive).plugged = on

    def power_drive(self, drive: int, on: bool) -> None:
        """Take a drive's supply away, and what it holds comes down; or give it back."""
        node = self._node(drive)
        if not on:
            node.fall_silent(self.now_s)
            node.powered = False
        elif self.powered and not node.powered:
            node.powered = True
            node.begin(self.now_s)
        self._collect()

    def reset_drive(self, drive: int) -> None:
        """Have a drive's firmware begin anew, in motion or not."""
        if self._node(drive).powered:
            self._node(drive).restart(self.now_s)
            self._collect()

    def _node(self, drive: int) -> N:
        if not 0 <= drive < len(self.nodes):
            raise BadRequest(f"drives are numbered 0 to {len(self.nodes) - 1}, not {drive}")
        return self.nodes[drive]

    # The box.

    def _hear(self, data: bytes) -> None:
        for frame in self._unpacker.feed(data):
            ears = [node for node in self.nodes if self._listens(node, frame)]
            for node in ears:
                self._bring(node, frame)
            self._collect(ears)

    def _due_s(self) -> float:
        return min(self._nodes_due_s, self._outbox.next_s, self._look_s)

    def _happen(self) -> None:
        self._live()
        self.said += self._outbox.take(self.now_s)

    def _live(self) -> None:
        """Let every drive do what is due."""
        if self.powered:
            self._shafts.look(self.now_s)
            for node in self.nodes:
                self._live_through(node)
            self._collect()

    def _collect(self, nodes: Iterable[N] | None = None) -> None:
        """Take what drives have to say, and see when they have something to do again."""
        self._look_s = self._shafts.look_s
        for node in self.nodes if nodes is None else nodes:
            self._dues[node.index] = self._next_of(node)
            if node.said:
                for data in node.said:
                    self._outbox.put(self.now_s + node.answer_s, node.index, data)
                node.said.clear()
        self._nodes_due_s = min(self._dues)

    def _motion_ended(self) -> None:
        """Do nothing: each drive ends its own."""

    def _boot(self) -> None:
        for node in self.nodes:
            node.powered = True
            node.begin(self.now_s)
        self._collect()

    def _forget(self) -> None:
        self._outbox.clear()
        self._unpacker = Unpacker()

    def _register_range(self) -> tuple[int, int]:
        return -COUNT_MOST, COUNT_MOST
