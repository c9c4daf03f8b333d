"""CAN ids of services and nodes: the predefined connection set of CiA 301.

id = base of the service + node (1 to 127); NMT, SYNC and TIME belong to no node
"""

from __future__ import annotations

from enum import Enum
from typing import Self

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.frames import DATA_MAX, Frame

NODE_MAX = 0x7F
"""The highest node number; 0 addresses all nodes, in NMT commands only."""


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
        raise RemoteProtocolError(f"{len(frame.data)} bytes where {belong} belong")
    return frame.data
