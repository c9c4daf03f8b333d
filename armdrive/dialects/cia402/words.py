"""CANopen frames described in words, with the node that they concern in front.

A PDO does not state its contents. It is decoded by its length: as armdrive maps its drives' PDOs,
or as CiA 402 maps a drive's first PDOs by default.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.dialects.bus.words import (
    FrameDescription,
    FrameKind,
    PackedFrames,
    addressed,
    shown,
)
from armdrive.dialects.bus.words import words as frame_words
from armdrive.dialects.cia402.objects import (
    held_words,
    object_words,
    register_words,
    value_words,
)
from armdrive.dialects.words import Describer, Message, Sentences, Weight, wording
from firmware_protocol.canopen.objects import (
    CONTROLWORD,
    MODE,
    MODE_SHOWN,
    POSITION,
    STANDARD,
    STATUSWORD,
    TARGET_POSITION,
    Place,
    Value,
)
from firmware_protocol.canopen.pdo import PDO_SERVICES, Direction
from firmware_protocol.canopen.pdo import Mapping as PdoMapping
from firmware_protocol.canopen.sdo import (
    Abort,
    Content,
    DownloadStarted,
    NextSegment,
    Segment,
    SegmentTaken,
    StartDownload,
    StartUpload,
    Upload,
    decode_request,
    decode_response,
)
from firmware_protocol.canopen.services import (
    MAKERS_BYTES,
    Emergency,
    Heartbeat,
    Nmt,
    NmtCommand,
    NodeState,
    Service,
    Sync,
    opened,
    service_of,
)
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, pack

RECEIVED, TRANSMITTED = (PDO_SERVICES[direction] for direction in Direction)
# The services of a master; nodes use the others.
OF_MASTER = frozenset((Service.NMT, Service.SYNC, Service.TIME, Service.SDO_REQUEST, *RECEIVED))
_PDO_PLACES: tuple[tuple[Service, tuple[Place, ...]], ...] = (
    (Service.RPDO1, (CONTROLWORD, MODE, TARGET_POSITION)),
    (Service.TPDO1, (STATUSWORD, MODE_SHOWN, POSITION)),
    (Service.RPDO1, (CONTROLWORD,)),
    (Service.RPDO2, (CONTROLWORD, MODE)),
    (Service.RPDO3, (CONTROLWORD, TARGET_POSITION)),
    (Service.TPDO1, (STATUSWORD,)),
    (Service.TPDO2, (STATUSWORD, MODE_SHOWN)),
    (Service.TPDO3, (STATUSWORD, POSITION)),
)


@dataclass(frozen=True, slots=True)
class PdoWords:
    """Process data: its objects and their values, empty if the mapping is unknown."""

    service: Service
    data: bytes
    values: Mapping[Place, Value]


@dataclass(frozen=True, slots=True)
class ReadFrame:
    """A readable frame: its service, the node that it concerns (0: all or none), its message."""

    service: Service
    node: int
    message: object

    @property
    def who(self) -> str:
        """The node as text; empty if there is none."""
        return str(self.node) if self.node else "all" if self.service is Service.NMT else ""


def read_frame(frame: Frame) -> ReadFrame:
    """Decode a frame of the predefined connection set. Raises `RemoteProtocolError`."""
    service, node = opened(frame, *Service)
    if service is Service.NMT:
        order = Nmt.read(frame)
        return ReadFrame(service, order.node, order)
    return ReadFrame(service, node, _READERS[service](frame))


def _pdo(service: Service) -> Callable[[Frame], PdoWords]:
    def read(frame: Frame) -> PdoWords:
        mapping = _MAPPINGS.get((service, len(frame.data)))
        if mapping is None:
            return PdoWords(service, frame.data, {})
        places = (entry.place for entry in mapping.entries)
        values = dict(zip(places, mapping.unpack(frame.data), strict=True))
        return PdoWords(service, frame.data, values)

    return read


def _mappings() -> Mapping[tuple[Service, int], PdoMapping]:
    found = {}
    for service, places in _PDO_PLACES:
        mapping = PdoMapping.of_objects(STANDARD, *places)
        found[service, mapping.size] = mapping
    return MappingProxyType(found)


_MAPPINGS = _mappings()
_READERS: Mapping[Service, Callable[[Frame], object]] = MappingProxyType(
    {
        Service.SYNC: Sync.read,
        Service.TIME: lambda frame: f"the time of day: {frame.data.hex(' ')}",
        Service.EMCY: Emergency.read,
        Service.HEARTBEAT: Heartbeat.read,
        Service.SDO_REQUEST: lambda frame: decode_request(frame.data),
        Service.SDO_RESPONSE: lambda frame: decode_response(frame.data),
        **{service: _pdo(service) for service in (*RECEIVED, *TRANSMITTED)},
    }
)


# -- sentences -----------------------------------------------------------------------------------

_ORDERS = {
    NmtCommand.START: "start: become operational",
    NmtCommand.STOP: "stop: take part in nothing but heartbeats and orders",
    NmtCommand.PRE_OPERATIONAL: "become pre-operational",
    NmtCommand.RESET_NODE: "restart",
    NmtCommand.RESET_COMMUNICATION: "restart communication",
}
_NODE_STATES = {
    NodeState.BOOTING: "boot-up: it has restarted",
    NodeState.STOPPED: "heartbeat: stopped",
    NodeState.OPERATIONAL: "heartbeat: operational",
    NodeState.PRE_OPERATIONAL: "heartbeat: pre-operational",
}


def _emergency(message: Emergency) -> str:
    makers = f", the maker's {message.detail.hex(' ')}"
    detail = "" if message.detail == bytes(MAKERS_BYTES) else makers
    kinds = f" ({register_words(message.register)})" if message.register else ""
    return f"EMCY {message.code:04X}, {message.words}{kinds}{detail}"


def _content(place: Place, content: Content) -> str:
    if content.data is None:
        return "begins" if content.size is None else f"begins, {content.size} bytes"
    return held_words(place, content.data)


def _segment(message: Segment) -> str:
    text = message.data.rstrip(b"\0").decode("ascii", "replace")
    shown = repr(text) if text and text.isprintable() else message.data.hex(" ") or "nothing"
    return f"segment {shown}{', the last' if message.last else ''}"


def _process_data(message: PdoWords) -> str:
    if not message.values:
        return f"{message.service.name} {message.data.hex(' ') or 'without data'}"
    return "; ".join(
        f"{_SHORT.get(place, '')} {value_words(place, value)}".lstrip()
        for place, value in message.values.items()
    )


_SHORT = {MODE: "mode", MODE_SHOWN: "mode", TARGET_POSITION: "target", POSITION: "at"}

SENTENCES: Sentences = MappingProxyType(
    {
        Nmt: lambda message: _ORDERS[message.command],
        Heartbeat: lambda message: _NODE_STATES[message.state],
        Sync: lambda _: "SYNC",
        Emergency: _emergency,
        StartUpload: lambda message: f"read {object_words(message.place)}",
        StartDownload: lambda message: (
            f"write {object_words(message.place)}: {_content(message.place, message.content)}"
        ),
        Upload: lambda message: (
            f"{object_words(message.place)}: {_content(message.place, message.content)}"
        ),
        DownloadStarted: lambda message: f"{object_words(message.place)} is written",
        NextSegment: lambda _: "the next segment",
        Segment: _segment,
        SegmentTaken: lambda _: "the segment is received",
        Abort: lambda message: f"{object_words(message.place)} aborted: {message.words}",
        PdoWords: _process_data,
    }
)


# Describing the traffic on a bus, one frame at a time.
#
# An id identifies the service and the node. Segments of a long object do not name the object: it is
# that of the node's last transfer that was seen to begin.

_SEGMENTS = (NextSegment, Segment, SegmentTaken)


class CanopenFrameDescriber:
    """Describes frames one after the other, and remembers the objects being transferred."""

    def __init__(self) -> None:
        self._transfers: dict[int, Place] = {}

    def describe(self, frame: Frame) -> FrameDescription:
        """Describe a frame. Never raises."""
        known = None if frame.extended or frame.remote else service_of(frame.can_id)
        service, node = known or (None, 0)
        command = "" if service is None else service.value
        try:
            read = read_frame(frame)
        except RemoteProtocolError as error:
            words = _unreadable(frame, service, error)
            return FrameDescription(frame, FrameKind.UNKNOWN, command, words, node)
        kind = FrameKind.REQUEST if read.service in OF_MASTER else FrameKind.ANSWER
        return FrameDescription(frame, kind, command, self._words(read), read.node)

    def _words(self, read: ReadFrame) -> str:
        message = read.message
        if isinstance(message, StartUpload | StartDownload):
            self._transfers[read.node] = message.place
        words = wording(message, SENTENCES)
        place = self._transfers.get(read.node)
        if isinstance(message, _SEGMENTS) and place is not None:
            words = f"{words}, of {object_words(place)}"
        who = f"node {read.node}" if read.node else read.who
        return addressed(who, words)


def _unreadable(frame: Frame, service: Service | None, error: RemoteProtocolError) -> str:
    if service is not None:
        return f"perhaps {service.value}: {error}"
    kind = "remote" if frame.remote else "extended" if frame.extended else "its id"
    return f"not of CANopen's predefined ids ({kind})"


# Frames as messages of a recording, and how each is compared.

# Objects by which a device describes itself.
_OF_ITSELF = frozenset((0x1000, 0x1002, 0x1003, 0x1008, 0x1009, 0x100A, 0x1018, 0x6502))
# Objects that depend on the moment; only rest positions have to agree.
_PASSING = frozenset((0x6041, 0x6061, 0x6064, 0x606C, 0x60F4))
# The bytes of an SDO frame that identify the service and the object.
_PLACE = 4


def weighed(frame: Frame) -> Message:
    """Return a frame as a message, compared by its service and its object."""
    data = pack(frame)
    try:
        read = read_frame(frame)
    except RemoteProtocolError:
        return Message(data, Weight.ANSWER)
    message = read.message
    if isinstance(message, Heartbeat):
        return Message(data, Weight.BANNER if message.booted else Weight.PASSING)
    if read.service in TRANSMITTED:
        return Message(data, Weight.PASSING)
    if isinstance(message, Upload) and message.place.index in _OF_ITSELF:
        return Message(data, Weight.SELF)
    if isinstance(message, Upload) and message.place.index in _PASSING:
        return Message(data, Weight.PASSING)
    kind = frame.data[: 2 if read.service is Service.EMCY else _PLACE]
    return Message(data, Weight.MOMENT, frame.can_id.to_bytes(2, "big") + kind)


def words(data: bytes) -> object:
    """Return what frames of either side mean. Raises `RemoteProtocolError`."""
    return frame_words(data, _read, SENTENCES)


def _read(frame: Frame) -> tuple[str, object]:
    read = read_frame(frame)
    return read.who, read.message


TALK = Describer(lambda: PackedFrames(weighed), words, words, shown, SENTENCES)
