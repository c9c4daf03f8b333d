"""An arm on MKS SERVO42D/57D drives that is not there: its drives on one bus, and what they turn.

What goes in and comes out are packed frames. A drive does not hear what the others say: only where
two have one id, or a group has the id of a drive, would it matter.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

from armdrive.errors import BadRequest
from armdrive.sim.device import SwitchState
from armdrive.sim.mks_answers import report
from armdrive.sim.mks_course import due_s, give_up, happen
from armdrive.sim.mks_drive import ClosedLoopDrive
from armdrive.sim.mks_file import known_json, recall_known, seen_json
from armdrive.sim.mks_node import Node
from armdrive.sim.mks_obey import obey
from armdrive.sim.mks_outbox import Outbox
from armdrive.sim.saved import Json, Saved
from armdrive.sim.sim_base import SimBase
from armdrive.sim.world import World
from firmware_protocol.errors import BadField
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks import Asked, Code, Mode, SetId, SetMode
from kinematics.spaces import Motors

COUNT_MOST = 1 << 40


class SimMks(SimBase):
    """The drives, the arm, and the person beside them. Input bit n is the IN_1 of drive n."""

    title: ClassVar[str] = "arm on MKS drives"
    _drive: ClosedLoopDrive

    def __init__(
        self, world: World, drive: ClosedLoopDrive, nodes: Sequence[Node], bits_s: int
    ) -> None:
        super().__init__(world, drive, None)
        self.nodes = tuple(nodes)
        self._bits_s = bits_s
        self._unpacker = Unpacker()
        self._outbox = Outbox()
        self._look_s = self._nodes_due_s = math.inf
        self._boot()

    # What can be seen.

    @property
    def busy(self) -> bool:
        """Whether a motion is under way or an answer on its way."""
        return self._outbox.next_s < math.inf or any(
            node.under_way is not None for node in self.nodes
        )

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
        errors, now_s = self._drive.errors(self.now_s), self.now_s
        drives: list[Json] = [seen_json(each, errors[each.index], now_s) for each in self.nodes]
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
        self._drive.release(range(len(self.nodes)), self.now_s)
        for node in self.nodes:
            node.fall_silent(self.now_s)
            node.powered = False
        super().power_off()

    def reset(self) -> None:
        """Have every drive begin anew, and for that time let its shaft go."""
        if self.powered:
            self._drive.release(range(len(self.nodes)), self.now_s)
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

    def set_drive_id(self, drive: int, node: int) -> int:
        """Give a drive an id, another one's perhaps; return the old. Raises `BadRequest`."""
        one = self._node(drive)
        try:
            setting = SetId(node)
        except BadField as error:
            raise BadRequest(str(error)) from None
        before = one.flash.of(SetId).node
        one.flash.put(setting)
        one.remake()
        return before

    def set_drive_mode(self, drive: int, mode: int) -> int:
        """Give a drive a mode, as at its own keys; return the old. Raises `BadRequest`."""
        one, modes = self._node(drive), [*Mode]
        if mode not in modes:
            raise BadRequest(f"modes are {int(modes[0])} to {int(modes[-1])}, not {mode}")
        before = one.mode
        give_up(one, self.now_s)
        one.point.hold(one.point.at(self.now_s))
        one.flash.put(SetMode(Mode(mode)))
        self._collect()
        return before

    def withhold_done(self, drive: int, withheld: bool) -> None:
        """Have a drive not say that a motion is done, or say it again."""
        node = self._node(drive)
        node.says_done = node.habits.says_done and not withheld

    def _node(self, drive: int) -> Node:
        if not 0 <= drive < len(self.nodes):
            raise BadRequest(f"drives are numbered 0 to {len(self.nodes) - 1}, not {drive}")
        return self.nodes[drive]

    # The box.

    def _hear(self, data: bytes) -> None:
        for frame in self._unpacker.feed(data):
            for node in self.nodes:
                self._bring(node, frame)
        self._collect()

    def _bring(self, node: Node, frame: Frame) -> None:
        """Let a drive hear a frame, if it is awake and listens at the bus's speed."""
        meant = node.listens_to(frame.can_id)
        if not (node.plugged and (meant or node.habits.watchdog_hears_all)):
            return
        if node.awake and node.device.bitrate.bits_s == self._bits_s:
            node.heard_s, node.expired = self.now_s, False
            if meant:
                node.device.receive_data(pack(frame))
            while (event := node.device.next_event()) is not None:
                if isinstance(event, Asked):
                    if event.request.code is not Code.ABSOLUTE_AXIS:  # a stream minds no shaft
                        self._drive.look(self.now_s)
                    obey(node, event, self.now_s)

    def _due_s(self) -> float:
        return min(self._nodes_due_s, self._outbox.next_s, self._look_s)

    def _happen(self) -> None:
        self._live()
        self.said += self._outbox.take(self.now_s)

    def _live(self) -> None:
        """Let every drive do what is due."""
        if self.powered:
            self._drive.look(self.now_s)
            for node in self.nodes:
                happen(node, self.now_s)
                if node.awake:
                    report(node, self.now_s)
            self._collect()

    def _collect(self) -> None:
        """Take what the drives have to say, and see when they have something to do again."""
        self._look_s = self._drive.look_s
        self._nodes_due_s = min(map(due_s, self.nodes))
        for node in self.nodes:
            for data in node.said:
                self._outbox.put(self.now_s + node.habits.answer_s, node.index, data)
            node.said.clear()

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

    def _known(self) -> dict[str, Json]:
        return known_json(self.nodes)

    def _recall_known(self, saved: Saved) -> None:
        recall_known(self.nodes, saved, powered=self.powered)

    def _register_range(self) -> tuple[int, int]:
        return -COUNT_MOST, COUNT_MOST
