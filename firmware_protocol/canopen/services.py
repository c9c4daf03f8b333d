"""CAN ids of services and nodes: the predefined connection set of CiA 301.

id = base of the service + node (1 to 127); NMT, SYNC and TIME belong to no node
"""

from __future__ import annotations

from enum import Enum, IntEnum, IntFlag
from typing import Self

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.fields import BYTE, an_instance, message, some_bytes, whole_from
from firmware_protocol.frames import DATA_MAX, Frame

# The highest node number; 0 addresses all nodes, in NMT commands only.
NODE_MAX = 0x7F


class Service(Enum):
    """A service and its base id; the node's number is added unless the id is `common`.

    PDOs are named from the device's side: it transmits TPDOs and receives RPDOs.
    """

    base: int
    common: bool

    def __new__(cls, words: str, base: int, common: bool = False) -> Self:
        """Make a member whose value is its description."""
        one = object.__new__(cls)
        one._value_, one.base, one.common = words, base, common
        return one

    NMT = "nmt", 0x000, True
    SYNC = "sync", 0x080, True
    TIME = "time", 0x100, True
    EMCY = "emcy", 0x080
    TPDO1 = "tpdo1", 0x180
    RPDO1 = "rpdo1", 0x200
    TPDO2 = "tpdo2", 0x280
    RPDO2 = "rpdo2", 0x300
    TPDO3 = "tpdo3", 0x380
    RPDO3 = "rpdo3", 0x400
    TPDO4 = "tpdo4", 0x480
    RPDO4 = "rpdo4", 0x500
    SDO_RESPONSE = "sdo response", 0x580
    SDO_REQUEST = "sdo request", 0x600
    HEARTBEAT = "heartbeat", 0x700


_BY_COMMON = {service.base: service for service in Service if service.common}
_BY_BASE = {service.base: service for service in Service if not service.common}


# The rule of a field that names one node.
ONE_NODE = whole_from(1, NODE_MAX)


def checked_node(node: object) -> int:
    """Return a valid node number, or raise `BadField`."""
    return whole("node", node, 1, NODE_MAX)


def cob_id(service: Service, node: int = 0) -> int:
    """Return a service's id; `node` is 0 for services without a node. Raises `BadField`."""
    if not isinstance(service, Service):
        raise BadField("service", service, "a Service")
    return service.base + (whole("node", node, 0, 0) if service.common else checked_node(node))


def service_of(can_id: int) -> tuple[Service, int] | None:
    """Return the service and node of an id; None if it is not in the set."""
    if can_id in _BY_COMMON:
        return _BY_COMMON[can_id], 0
    service, node = _BY_BASE.get(can_id & ~NODE_MAX), can_id & NODE_MAX
    return None if service is None or not node else (service, node)


def is_for(frame: Frame, can_id: int) -> bool:
    """Return whether a frame is a data frame with this 11-bit id."""
    return frame.can_id == can_id and not frame.extended and not frame.remote


def opened(frame: Frame, *services: Service) -> tuple[Service, int]:
    """Return a frame's service and node. Raises `RemoteProtocolError` for other services."""
    found = None if frame.extended or frame.remote else service_of(frame.can_id)
    if found is None or found[0] not in services:
        words = " or ".join(service.value for service in services)
        raise RemoteProtocolError(f"{frame} is no frame of {words}")
    return found


def sized(frame: Frame, low: int, high: int = DATA_MAX) -> bytes:
    """Return a frame's data if its length is in range, or raise `RemoteProtocolError`."""
    if not low <= len(frame.data) <= high:
        belong = f"{low}" if low == high else f"{low} to {high}"
        raise RemoteProtocolError(f"length {len(frame.data)} where {belong} belong")
    return frame.data


ALL_NODES = 0
# The longest time in objects 1016 and 1017.
HEARTBEAT_MAX_MS = 0xFFFF
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


@message(command=an_instance(NmtCommand, "an NmtCommand"), node=whole_from(ALL_NODES, NODE_MAX))
class Nmt:
    """A command to one node or to `ALL_NODES`. There is no answer."""

    command: NmtCommand
    node: int = ALL_NODES

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


@message(node=ONE_NODE, state=an_instance(NodeState, "a NodeState"))
class Heartbeat:
    """A sign of life with the node's state. With `BOOTING` it is the boot-up message."""

    node: int
    state: NodeState

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


@message(node=ONE_NODE, silence_ms=whole_from(0, HEARTBEAT_MAX_MS))
class HeartbeatWatch:
    """An entry of object 1016: a node to monitor, and its heartbeat timeout.

    0 ms switches the monitoring off. On a drive, object 6007 sets the reaction.
    """

    node: int
    silence_ms: int

    @property
    def value(self) -> int:
        """The value to write to the object."""
        return self.node << 16 | self.silence_ms

    @classmethod
    def of(cls, value: int) -> HeartbeatWatch | None:
        """Decode the object's value; None if no node is monitored."""
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

    @property
    def communicates(self) -> bool:
        """Whether SDO and EMCY are available in this state. PDOs are in `OPERATIONAL` alone."""
        return self._state in (NodeState.PRE_OPERATIONAL, NodeState.OPERATIONAL)

    def booted(self) -> Frame:
        """Enter pre-operational after a start; return the boot-up message."""
        self._state = NodeState.PRE_OPERATIONAL
        return Heartbeat(self._node, NodeState.BOOTING).frame

    def failed(self) -> None:
        """Leave operation for pre-operational, as after a communication error."""
        if self._state is NodeState.OPERATIONAL:
            self._state = NodeState.PRE_OPERATIONAL

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


@message()
class Sync:
    """A SYNC message. A counter in it (object 1019), as another master may send, is ignored."""

    @property
    def frame(self) -> Frame:
        """The CAN frame."""
        return Frame(cob_id(Service.SYNC))

    @classmethod
    def read(cls, frame: Frame) -> Sync:
        """Decode a frame. Raises `RemoteProtocolError`."""
        opened(frame, Service.SYNC)
        sized(frame, 0, 1)
        return cls()


# The meanings of the CiA 301 and CiA 402 error codes, in EMCY frames and in object 603F.
#
# The first digits are the class of the error, the others specify it. A code without a row of its
# own is described by the row of its class.

# The error of a drive that missed its master's heartbeat; it has stopped and holds.
HEARTBEAT_MISSING = 0x8130

# Sources: CiA 301, table of emergency error codes; CiA 402-2 (IEC 61800-7-201), error codes.
ERROR_WORDS: dict[int, str] = {
    0x0000: "no error any more",
    0x1000: "an error of no particular kind",
    0x2000: "current",
    0x2100: "current at the input",
    0x2200: "current inside the device",
    0x2220: "continuous over-current inside the device",
    0x2300: "current at the output",
    0x2310: "continuous over-current at the output",
    0x2320: "short circuit or earth leakage at the output",
    0x2330: "earth leakage at the output",
    0x2340: "short circuit at the output",
    0x3000: "voltage",
    0x3100: "mains voltage",
    0x3110: "mains voltage too high",
    0x3120: "mains voltage too low",
    0x3130: "a phase of the mains is missing",
    0x3200: "voltage inside the device",
    0x3210: "DC link voltage too high",
    0x3220: "DC link voltage too low",
    0x3300: "output voltage",
    0x4000: "temperature",
    0x4100: "ambient temperature",
    0x4110: "ambient temperature too high",
    0x4120: "ambient temperature too low",
    0x4200: "temperature of the device",
    0x4210: "device too hot",
    0x4220: "device too cold",
    0x4300: "temperature of the drive",
    0x4310: "drive too hot",
    0x4320: "drive too cold",
    0x5000: "hardware of the device",
    0x5100: "supply of the device's electronics",
    0x5112: "24 V supply",
    0x5400: "power section",
    0x5500: "memory of the device",
    0x5510: "RAM",
    0x5520: "ROM or EPROM",
    0x5530: "EEPROM",
    0x6000: "software of the device",
    0x6010: "software reset by a watchdog",
    0x6100: "internal software",
    0x6200: "user software",
    0x6300: "data set",
    0x6310: "parameters were lost",
    0x6320: "a parameter is wrong",
    0x7000: "additional modules",
    0x7100: "power: brake chopper or motor",
    0x7110: "brake chopper",
    0x7120: "motor",
    0x7121: "motor blocked",
    0x7122: "motor or its commutation",
    0x7300: "sensor",
    0x7305: "incremental sensor 1",
    0x7306: "incremental sensor 2",
    0x7310: "speed",
    0x7320: "position",
    0x7500: "communication of a module",
    0x8000: "monitoring",
    0x8100: "communication",
    0x8110: "frames were lost: CAN overrun",
    0x8120: "CAN is error-passive",
    HEARTBEAT_MISSING: "a heartbeat or life guard is missing",
    0x8140: "recovered from bus-off",
    0x8150: "another node sends with its id",
    0x8200: "protocol",
    0x8210: "a PDO was too short to be used",
    0x8220: "a PDO was too long",
    0x8240: "SYNC has another length than was set",
    0x8250: "an expected PDO did not come",
    0x8300: "torque control",
    0x8311: "excess torque",
    0x8331: "torque",
    0x8400: "speed control",
    0x8500: "position control",
    0x8600: "positioning control",
    0x8611: "following error",
    0x8612: "a reference limit was reached",
    0x8700: "synchronisation control",
    0x8800: "winding control",
    0x8900: "process data monitoring",
    0x8A00: "control",
    0x9000: "an external error",
    0xF000: "additional functions",
    0xF001: "deceleration",
    0xFF00: "particular to the device: see its manual",
}

_FIRST_ERROR = 0x100  # 00xx means no error
_CLASSES = (0xFFFF, 0xFFF0, 0xFF00, 0xF000)


class ErrorRegister(IntFlag):
    """The bits of object 1001, also sent in every EMCY."""

    GENERIC = 0x01
    CURRENT = 0x02
    VOLTAGE = 0x04
    TEMPERATURE = 0x08
    COMMUNICATION = 0x10
    DEVICE_PROFILE = 0x20
    MANUFACTURER = 0x80


def error_words(code: int) -> str:
    """Return the most specific description of an error code in the table."""
    if code < _FIRST_ERROR:
        return ERROR_WORDS[0]
    known = (code & mask for mask in _CLASSES if code & mask in ERROR_WORDS and code & mask)
    key = next(known, None)
    return "an error code that CiA 301 and 402 do not have" if key is None else ERROR_WORDS[key]


# Manufacturer-specific bytes in an EMCY.
MAKERS_BYTES = 5


@message(
    node=ONE_NODE,
    code=whole_from(0, 0xFFFF),
    register=BYTE,
    detail=some_bytes(MAKERS_BYTES, exactly=True),
)
class Emergency:
    """A node's error report: code, error register (object 1001), manufacturer-specific bytes."""

    node: int
    code: int
    register: int = 0
    detail: bytes = bytes(MAKERS_BYTES)

    @property
    def over(self) -> bool:
        """Whether the report means that no error remains."""
        return self.code < 0x100

    @property
    def words(self) -> str:
        """The description of the code."""
        return error_words(self.code)

    @property
    def frame(self) -> Frame:
        """The CAN frame."""
        data = self.code.to_bytes(2, "little") + bytes((self.register,)) + self.detail
        return Frame(cob_id(Service.EMCY, self.node), data)

    @classmethod
    def read(cls, frame: Frame) -> Emergency:
        """Decode a frame. Raises `RemoteProtocolError`."""
        _, node = opened(frame, Service.EMCY)
        data = sized(frame, 8, 8)
        return cls(node, int.from_bytes(data[:2], "little"), data[2], data[3:])
