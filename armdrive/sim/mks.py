"""An arm on MKS SERVO42D/57D drives that is not there: drives on one bus, and what they turn."""

from __future__ import annotations

import math
from typing import ClassVar

from armdrive.errors import BadRequest
from armdrive.sim.drives_box import DrivesBox
from armdrive.sim.mks_answers import report
from armdrive.sim.mks_course import due_s, give_up, happen
from armdrive.sim.mks_file import known_json, recall_known, seen_json
from armdrive.sim.mks_node import Node
from armdrive.sim.mks_obey import obey
from armdrive.sim.saved import Json, Saved
from firmware_protocol.errors import BadField
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import Asked, Code, Mode, SetId, SetMode


class SimMks(DrivesBox[Node]):
    """The drives, the arm, and the person beside them. Input bit n is the IN_1 of drive n."""

    title: ClassVar[str] = "arm on MKS drives"

    @property
    def busy(self) -> bool:
        """Whether a motion is under way or an answer on its way."""
        return self._outbox.next_s < math.inf or any(
            node.under_way is not None for node in self.nodes
        )

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

    # The box.

    def _listens(self, node: Node, frame: Frame) -> bool:
        meant = node.listens_to(frame.can_id)
        return node.plugged and (meant or node.habits.watchdog_hears_all)

    def _bring(self, node: Node, frame: Frame) -> None:
        if node.awake and node.device.bitrate.bits_s == self._bits_s:
            node.heard_s, node.expired = self.now_s, False
            if node.listens_to(frame.can_id):
                node.device.receive_data(pack(frame))
            while (event := node.device.next_event()) is not None:
                if isinstance(event, Asked):
                    if event.request.code is not Code.ABSOLUTE_AXIS:  # a stream minds no shaft
                        self._shafts.look(self.now_s)
                    obey(node, event, self.now_s)

    def _next_of(self, node: Node) -> float:
        return due_s(node)

    def _live_through(self, node: Node) -> None:
        happen(node, self.now_s)
        if node.awake:
            report(node, self.now_s)

    def _seen(self, node: Node, error: int) -> dict[str, Json]:
        return seen_json(node, error, self.now_s)

    def _known(self) -> dict[str, Json]:
        return known_json(self.nodes)

    def _recall_known(self, saved: Saved) -> None:
        recall_known(self.nodes, saved, powered=self.powered)
