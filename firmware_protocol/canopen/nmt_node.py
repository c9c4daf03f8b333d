"""A device's end of NMT: one table of its states, and what it says of them."""

from __future__ import annotations

from firmware_protocol.canopen.cob import checked_node
from firmware_protocol.canopen.nmt import ALL_NODES, SPEAKS, Heartbeat, Nmt, NmtCommand, NodeState
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame

_ORDERED = {
    NmtCommand.START: NodeState.OPERATIONAL,
    NmtCommand.STOP: NodeState.STOPPED,
    NmtCommand.PRE_OPERATIONAL: NodeState.PRE_OPERATIONAL,
    NmtCommand.RESET_NODE: NodeState.BOOTING,
    NmtCommand.RESET_COMMUNICATION: NodeState.BOOTING,
}


class NmtNode:
    """The NMT state of a device. It boots until its owner says `booted`, then obeys.

    An order reaches a node in any state but `BOOTING`; a reset brings it back there.
    """

    def __init__(self, node: int) -> None:
        self._node = checked_node(node)
        self._state = NodeState.BOOTING

    @property
    def state(self) -> NodeState:
        """What the node is."""
        return self._state

    @property
    def heartbeat(self) -> Heartbeat:
        """What it says of itself now; its period is its owner's business."""
        return Heartbeat(self._node, self._state)

    def takes(self, service: str) -> bool:
        """Whether it takes part in a service: `sdo`, `pdo`, `sync`, `emcy`, as it is now."""
        return service in SPEAKS[self._state]

    def booted(self) -> Frame:
        """Say that it has begun: it is pre-operational; returns the boot-up message."""
        self._state = NodeState.PRE_OPERATIONAL
        return Heartbeat(self._node, NodeState.BOOTING).frame

    def receive_frame(self, frame: Frame) -> NmtCommand | None:
        """Obey an order; returns it, or None where the frame is none for this node."""
        try:
            order = Nmt.read(frame)
        except RemoteProtocolError:
            return None
        if order.node not in (ALL_NODES, self._node) or self._state is NodeState.BOOTING:
            return None
        self._state = _ORDERED[order.command]
        return order.command
