"""NMT and SYNC: a master's commands to nodes, and the nodes' boot-up messages and heartbeats.

There is no clock here; callers keep the deadlines. Object 1016 sets how long a device tolerates a
missing heartbeat, and object 6007 sets the reaction.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from firmware_protocol.canopen.cob import NODE_MAX, Service, checked_node, cob_id, opened, sized
from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.frames import Frame

ALL_NODES = 0
HEARTBEAT_MAX_MS = 0xFFFF
"""The longest time in objects 1016 and 1017."""
_TOGGLE = 0x80  # used by node guarding's answers to remote frames


class NmtCommand(IntEnum):
    """A master's command."""

    START = 0x01
    STOP = 0x02
    PRE_OPERATIONAL = 0x80
    RESET_NODE = 0x81
    """Restart the device, as after power-on."""
    RESET_COMMUNICATION = 0x82
    """Restart only the communication."""


class NodeState(IntEnum):
    """A node's state."""

    BOOTING = 0x00
    """Sent once after a start: the boot-up message."""
    STOPPED = 0x04
    OPERATIONAL = 0x05
    PRE_OPERATIONAL = 0x7F


SPEAKS: dict[NodeState, frozenset[str]] = {
    NodeState.BOOTING: frozenset(),
    NodeState.STOPPED: frozenset(("nmt", "heartbeat")),
    NodeState.PRE_OPERATIONAL: frozenset(("nmt", "heartbeat", "sdo", "sync", "emcy")),
    NodeState.OPERATIONAL: frozenset(("nmt", "heartbeat", "sdo", "sync", "emcy", "pdo")),
}
"""The services available in each state, by CiA 301."""


@dataclass(frozen=True, slots=True)
class Nmt:
    """A command to one node or to `ALL_NODES`. There is no answer."""

    command: NmtCommand
    node: int = ALL_NODES

    def __post_init__(self) -> None:
        if not isinstance(self.command, NmtCommand):
            raise BadField("command", self.command, "an NmtCommand")
        whole("node", self.node, ALL_NODES, NODE_MAX)

    @property
    def frame(self) -> Frame:
        """The CAN frame."""
        return Frame(cob_id(Service.NMT), bytes((self.command, self.node)))

    @classmethod
    def read(cls, frame: Frame) -> Nmt:
        """Decode a frame. Raises `RemoteProtocolError`."""
        opened(frame, Service.NMT)
        command, node = sized(frame, 2, 2)
        try:
            return cls(NmtCommand(command), node)
        except ValueError:
            raise RemoteProtocolError(f"no NMT order: {command:02x} to {node}") from None


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """A sign of life with the node's state. With `BOOTING` it is the boot-up message."""

    node: int
    state: NodeState

    def __post_init__(self) -> None:
        checked_node(self.node)
        if not isinstance(self.state, NodeState):
            raise BadField("state", self.state, "a NodeState")

    @property
    def booted(self) -> bool:
        """Whether the node has just started and lost its earlier set-up."""
        return self.state is NodeState.BOOTING

    @property
    def frame(self) -> Frame:
        """The CAN frame."""
        return Frame(cob_id(Service.HEARTBEAT, self.node), bytes((self.state,)))

    @classmethod
    def read(cls, frame: Frame) -> Heartbeat:
        """Decode a frame, ignoring node guarding's toggle bit. Raises `RemoteProtocolError`."""
        _, node = opened(frame, Service.HEARTBEAT)
        (byte,) = sized(frame, 1, 1)
        try:
            return cls(node, NodeState(byte & ~_TOGGLE))
        except ValueError:
            raise RemoteProtocolError(f"node {node} has no state {byte:02x}") from None


@dataclass(frozen=True, slots=True)
class HeartbeatWatch:
    """An entry of object 1016: a node to monitor, and its heartbeat timeout.

    0 ms switches the monitoring off. On a drive, object 6007 sets the reaction.
    """

    node: int
    silence_ms: int

    def __post_init__(self) -> None:
        checked_node(self.node)
        whole("silence_ms", self.silence_ms, 0, HEARTBEAT_MAX_MS)

    @property
    def value(self) -> int:
        """The value to write to the object."""
        return self.node << 16 | self.silence_ms

    @classmethod
    def of(cls, value: int) -> HeartbeatWatch | None:
        """Decode the object's value; None if no node is monitored."""
        whole("value", value, 0, 0xFFFF_FFFF)
        node, silence_ms = value >> 16 & 0xFF, value & HEARTBEAT_MAX_MS
        return cls(node, silence_ms) if 1 <= node <= NODE_MAX and silence_ms else None


# The device's end of NMT.

_ORDERED = {
    NmtCommand.START: NodeState.OPERATIONAL,
    NmtCommand.STOP: NodeState.STOPPED,
    NmtCommand.PRE_OPERATIONAL: NodeState.PRE_OPERATIONAL,
    NmtCommand.RESET_NODE: NodeState.BOOTING,
    NmtCommand.RESET_COMMUNICATION: NodeState.BOOTING,
}


class NmtNode:
    """The NMT state machine of a device. It boots until the owner calls `booted`.

    Commands act in every state except `BOOTING`; a reset leads back to `BOOTING`.
    """

    def __init__(self, node: int) -> None:
        self._node = checked_node(node)
        self._state = NodeState.BOOTING

    @property
    def state(self) -> NodeState:
        """The node's state."""
        return self._state

    @property
    def heartbeat(self) -> Heartbeat:
        """The current heartbeat message; the owner sends it periodically."""
        return Heartbeat(self._node, self._state)

    def takes(self, service: str) -> bool:
        """Return whether a service (`sdo`, `pdo`, `sync`, `emcy`) is available in this state."""
        return service in SPEAKS[self._state]

    def booted(self) -> Frame:
        """Enter pre-operational after a start; return the boot-up message."""
        self._state = NodeState.PRE_OPERATIONAL
        return Heartbeat(self._node, NodeState.BOOTING).frame

    def receive_frame(self, frame: Frame) -> NmtCommand | None:
        """Obey a command; return it, or None if the frame is not a command to this node."""
        try:
            order = Nmt.read(frame)
        except RemoteProtocolError:
            return None
        if order.node not in (ALL_NODES, self._node) or self._state is NodeState.BOOTING:
            return None
        self._state = _ORDERED[order.command]
        return order.command


# SYNC: the signal on which devices apply received PDOs and send their own.

COUNTER_MAX = 240
"""The highest SYNC counter; after it the counter restarts at 1 (object 1019)."""


@dataclass(frozen=True, slots=True)
class Sync:
    """A SYNC message, with a counter if object 1019 requires one."""

    counter: int | None = None

    def __post_init__(self) -> None:
        if self.counter is not None:
            whole("counter", self.counter, 1, COUNTER_MAX)

    @property
    def frame(self) -> Frame:
        """The CAN frame."""
        return Frame(cob_id(Service.SYNC), b"" if self.counter is None else bytes((self.counter,)))

    def after(self, overflow: int = COUNTER_MAX) -> Sync:
        """Return the next SYNC; a counter restarts at 1 after `overflow` (2 to 240)."""
        if self.counter is None:
            return self
        return Sync(self.counter % whole("overflow", overflow, 2, COUNTER_MAX) + 1)

    @classmethod
    def read(cls, frame: Frame) -> Sync:
        """Decode a frame. Raises `RemoteProtocolError`."""
        opened(frame, Service.SYNC)
        data = sized(frame, 0, 1)
        try:
            return cls(data[0] if data else None)
        except BadField as error:  # the sender chose the value
            raise RemoteProtocolError(f"SYNC: {error}") from None
