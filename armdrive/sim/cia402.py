"""An arm on CiA 402 drives that is not there: its drives on one bus, and what they turn."""

from __future__ import annotations

import math
from typing import ClassVar

from armdrive.errors import BadRequest
from armdrive.sim.cia402_course import set_mode
from armdrive.sim.cia402_errors import say
from armdrive.sim.cia402_file import known_json, recall_known, seen_json
from armdrive.sim.cia402_node import Node
from armdrive.sim.cia402_reacting import react
from armdrive.sim.cia402_states import fault
from armdrive.sim.cia402_talk import hear, listens_to, minds_shaft, tell_changes
from armdrive.sim.cia402_watch import due_s, live
from armdrive.sim.drives_box import DrivesBox
from armdrive.sim.saved import Json, Saved
from firmware_protocol.canopen import MODE, NODE_MAX, OperationMode
from firmware_protocol.frames import Frame


class SimCia402(DrivesBox[Node]):
    """The drives, the arm, and the person beside them. Input bit n is the switch of drive n."""

    title: ClassVar[str] = "arm on CiA 402 drives"

    @property
    def busy(self) -> bool:
        """Whether a motion is under way or a frame on its way."""
        return self.moving or self._outbox.next_s < math.inf

    def set_drive_id(self, drive: int, node: int) -> int:
        """Give a drive a node id, another one's perhaps; return the old. Raises `BadRequest`.

        As by its switches: its communication begins anew with it.
        """
        one = self._node(drive)
        if not 1 <= node <= NODE_MAX:
            raise BadRequest(f"node ids are 1 to {NODE_MAX}, not {node}")
        before = one.number
        react(one, self.now_s)
        one.renew_talk(node, self.now_s)
        self._collect()
        return before

    def set_drive_mode(self, drive: int, mode: int) -> int:
        """Give a drive a mode, as by its maker's program; return the old. Raises `BadRequest`."""
        one, modes = self._node(drive), [*OperationMode]
        if mode not in modes:
            raise BadRequest(f"modes are {', '.join(str(int(each)) for each in modes)}, not {mode}")
        before = one.mode
        one.keep(MODE, mode)
        set_mode(one, mode, self.now_s)
        self._collect()
        return before

    def withhold_done(self, drive: int, withheld: bool) -> None:
        """Have a drive not say that a target is reached, or say it again."""
        self._node(drive).withheld = withheld

    def ail_drive(self, drive: int, code: int) -> None:
        """Have something be wrong with a drive: it fails, until it is mended and reset."""
        node = self._node(drive)
        if node.powered:
            node.ailing.add(code)
            fault(node, code, self.now_s)
            self._collect()

    def mend_drive(self, drive: int, code: int) -> None:
        """Have what was wrong with a drive be right again; its fault is to be reset yet."""
        node = self._node(drive)
        node.ailing.discard(code)
        if not node.ailing:
            node.machine.mend()

    def warn_drive(self, drive: int, code: int) -> None:
        """Have a drive say an EMCY that changes nothing."""
        say(self._node(drive), code)
        self._collect()

    # The box.

    def _found(self) -> None:
        for node in self.nodes:
            node.nmt.booted()  # it has said so long ago

    def _listens(self, node: Node, frame: Frame) -> bool:
        return listens_to(node, frame.can_id)

    def _bring(self, node: Node, frame: Frame) -> None:
        if minds_shaft(node, frame.can_id):
            self._shafts.look(self.now_s)
            live(node, self.now_s)
        hear(node, frame, self.now_s)
        tell_changes(node, self.now_s)

    def _happen(self) -> None:
        if min(self._nodes_due_s, self._look_s) <= self.now_s:
            super()._happen()
        else:  # a frame is ready, and no drive has anything to do
            self.said += self._outbox.take(self.now_s)

    def _next_of(self, node: Node) -> float:
        return due_s(node)

    def _live_through(self, node: Node) -> None:
        live(node, self.now_s)

    def _seen(self, node: Node, error: int) -> dict[str, Json]:
        return seen_json(node, error, self.now_s)

    def _known(self) -> dict[str, Json]:
        return known_json(self.nodes)

    def _recall_known(self, saved: Saved) -> None:
        recall_known(self.nodes, saved, powered=self.powered)
