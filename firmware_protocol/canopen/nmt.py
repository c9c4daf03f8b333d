"""NMT and SYNC: what a master orders nodes to become, and how a node says what it is.

Deadlines are the callers': there is no clock here. How long a heartbeat may be missing is told to
the device by an entry of object 1016, to be chosen there what happens then (6007).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from firmware_protocol.canopen.cob import NODE_MAX, Service, checked_node, cob_id, opened, sized
from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.frames import Frame

ALL_NODES = 0
HEARTBEAT_MAX_MS = 0xFFFF
"""The longest period of objects 1016 and 1017."""
_TOGGLE = 0x80  # node guarding's bit, of those who answered a remote frame


class NmtCommand(IntEnum):
    """What a master orders."""

    START = 0x01
    STOP = 0x02
    PRE_OPERATIONAL = 0x80
    RESET_NODE = 0x81
    """The device begins anew, as after power on."""
    RESET_COMMUNICATION = 0x82
    """Its communication alone begins anew."""


class NodeState(IntEnum):
    """What a node says it is."""

    BOOTING = 0x00
    """Said once, by a node that has just begun: the boot-up message."""
    STOPPED = 0x04
    OPERATIONAL = 0x05
    PRE_OPERATIONAL = 0x7F


SPEAKS: dict[NodeState, frozenset[str]] = {
    NodeState.BOOTING: frozenset(),
    NodeState.STOPPED: frozenset(("nmt", "heartbeat")),
    NodeState.PRE_OPERATIONAL: frozenset(("nmt", "heartbeat", "sdo", "sync", "emcy")),
    NodeState.OPERATIONAL: frozenset(("nmt", "heartbeat", "sdo", "sync", "emcy", "pdo")),
}
"""Which services a node in a state takes part in: CiA 301, relation of states and objects."""


@dataclass(frozen=True, slots=True)
class Nmt:
    """An order to one node, or to `ALL_NODES`. Nobody answers it."""

    command: NmtCommand
    node: int = ALL_NODES

    def __post_init__(self) -> None:
        if not isinstance(self.command, NmtCommand):
            raise BadField("command", self.command, "an NmtCommand")
        whole("node", self.node, ALL_NODES, NODE_MAX)

    @property
    def frame(self) -> Frame:
        """The frame that orders it."""
        return Frame(cob_id(Service.NMT), bytes((self.command, self.node)))

    @classmethod
    def read(cls, frame: Frame) -> Nmt:
        """Read a frame; raises `RemoteProtocolError`."""
        opened(frame, Service.NMT)
        command, node = sized(frame, 2, 2)
        try:
            return cls(NmtCommand(command), node)
        except ValueError:
            raise RemoteProtocolError(f"no NMT order: {command:02x} to {node}") from None


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """A node is alive, and what it is. The boot-up message is the one with `BOOTING`."""

    node: int
    state: NodeState

    def __post_init__(self) -> None:
        checked_node(self.node)
        if not isinstance(self.state, NodeState):
            raise BadField("state", self.state, "a NodeState")

    @property
    def booted(self) -> bool:
        """Whether the node has just begun: whatever it was told before is forgotten."""
        return self.state is NodeState.BOOTING

    @property
    def frame(self) -> Frame:
        """The frame that says so."""
        return Frame(cob_id(Service.HEARTBEAT, self.node), bytes((self.state,)))

    @classmethod
    def read(cls, frame: Frame) -> Heartbeat:
        """Read a frame; raises `RemoteProtocolError`. The bit of node guarding is left out."""
        _, node = opened(frame, Service.HEARTBEAT)
        (byte,) = sized(frame, 1, 1)
        try:
            return cls(node, NodeState(byte & ~_TOGGLE))
        except ValueError:
            raise RemoteProtocolError(f"node {node} has no state {byte:02x}") from None


@dataclass(frozen=True, slots=True)
class HeartbeatWatch:
    """An entry of object 1016: the device watches that node, and reacts after so much silence.

    0 ms watches nothing. What it does then is for a drive in 6007.
    """

    node: int
    silence_ms: int

    def __post_init__(self) -> None:
        checked_node(self.node)
        whole("silence_ms", self.silence_ms, 0, HEARTBEAT_MAX_MS)

    @property
    def value(self) -> int:
        """What is written to the object."""
        return self.node << 16 | self.silence_ms

    @classmethod
    def of(cls, value: int) -> HeartbeatWatch | None:
        """Read the object's value; None where it watches nobody."""
        whole("value", value, 0, 0xFFFF_FFFF)
        node, silence_ms = value >> 16 & 0xFF, value & HEARTBEAT_MAX_MS
        return cls(node, silence_ms) if 1 <= node <= NODE_MAX and silence_ms else None


# A device's end of NMT: one table of its states, and what it says of them.

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


# SYNC: the beat by which devices take over what PDOs brought them, and answer with theirs.

COUNTER_MAX = 240
"""Where the counter of SYNC begins anew at 1, at the latest (object 1019)."""


@dataclass(frozen=True, slots=True)
class Sync:
    """One beat; with a counter where object 1019 asks for one."""

    counter: int | None = None

    def __post_init__(self) -> None:
        if self.counter is not None:
            whole("counter", self.counter, 1, COUNTER_MAX)

    @property
    def frame(self) -> Frame:
        """The frame of it."""
        return Frame(cob_id(Service.SYNC), b"" if self.counter is None else bytes((self.counter,)))

    def after(self, overflow: int = COUNTER_MAX) -> Sync:
        """Return the next beat; a counter begins anew at 1 behind `overflow`, 2 to 240."""
        if self.counter is None:
            return self
        return Sync(self.counter % whole("overflow", overflow, 2, COUNTER_MAX) + 1)

    @classmethod
    def read(cls, frame: Frame) -> Sync:
        """Read a frame; raises `RemoteProtocolError`."""
        opened(frame, Service.SYNC)
        data = sized(frame, 0, 1)
        try:
            return cls(data[0] if data else None)
        except BadField as error:  # of what came, not of what we chose
            raise RemoteProtocolError(f"SYNC: {error}") from None
