"""Which CAN id carries which service of which node: the predefined connection set of CiA 301.

id = base of the service + node, 1 to 127; NMT, SYNC and TIME belong to no node
"""

from __future__ import annotations

from enum import Enum

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.frames import DATA_MAX, Frame

NODE_MAX = 0x7F
"""The highest number of a node; 0 is all of them, in NMT commands alone."""


class Service(Enum):
    """What a frame is for. A PDO is named by the device: it transmits the T, receives the R."""

    NMT = "nmt"
    SYNC = "sync"
    TIME = "time"
    EMCY = "emcy"
    TPDO1 = "tpdo1"
    RPDO1 = "rpdo1"
    TPDO2 = "tpdo2"
    RPDO2 = "rpdo2"
    TPDO3 = "tpdo3"
    RPDO3 = "rpdo3"
    TPDO4 = "tpdo4"
    RPDO4 = "rpdo4"
    SDO_RESPONSE = "sdo response"
    SDO_REQUEST = "sdo request"
    HEARTBEAT = "heartbeat"


COMMON = {Service.NMT: 0x000, Service.SYNC: 0x080, Service.TIME: 0x100}
"""The ids of what belongs to no node."""

BASES = {
    Service.EMCY: 0x080,
    Service.TPDO1: 0x180,
    Service.RPDO1: 0x200,
    Service.TPDO2: 0x280,
    Service.RPDO2: 0x300,
    Service.TPDO3: 0x380,
    Service.RPDO3: 0x400,
    Service.TPDO4: 0x480,
    Service.RPDO4: 0x500,
    Service.SDO_RESPONSE: 0x580,
    Service.SDO_REQUEST: 0x600,
    Service.HEARTBEAT: 0x700,
}
"""What the number of a node is added to."""

_BY_COMMON = {can_id: service for service, can_id in COMMON.items()}
_BY_BASE = {base: service for service, base in BASES.items()}


def checked_node(node: object) -> int:
    """Return the number of one node, or raise `BadField`."""
    return whole("node", node, 1, NODE_MAX)


def cob_id(service: Service, node: int = 0) -> int:
    """Return the id of a service; `node` is 0 for what belongs to none. Raises `BadField`."""
    if service in COMMON:
        whole("node", node, 0, 0)
        return COMMON[service]
    if service not in BASES:
        raise BadField("service", service, "a Service")
    return BASES[service] + checked_node(node)


def service_of(can_id: int) -> tuple[Service, int] | None:
    """Return the service and the node of an id; None where it is none of this set."""
    if can_id in _BY_COMMON:
        return _BY_COMMON[can_id], 0
    service, node = _BY_BASE.get(can_id & ~NODE_MAX), can_id & NODE_MAX
    return None if service is None or not node else (service, node)


def is_for(frame: Frame, can_id: int) -> bool:
    """Whether a frame is a data frame with that id of 11 bits."""
    return frame.can_id == can_id and not frame.extended and not frame.remote


def opened(frame: Frame, *services: Service) -> tuple[Service, int]:
    """Return service and node of a frame that is one of these, or raise `RemoteProtocolError`."""
    found = None if frame.extended or frame.remote else service_of(frame.can_id)
    if found is None or found[0] not in services:
        words = " or ".join(service.value for service in services)
        raise RemoteProtocolError(f"{frame} is no frame of {words}")
    return found


def sized(frame: Frame, low: int, high: int = DATA_MAX) -> bytes:
    """Return the data of a frame of so many bytes, or raise `RemoteProtocolError`."""
    if not low <= len(frame.data) <= high:
        belong = f"{low}" if low == high else f"{low} to {high}"
        raise RemoteProtocolError(f"{len(frame.data)} bytes where {belong} belong")
    return frame.data
