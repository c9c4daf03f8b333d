"""What passes on a CANopen bus, in words: one frame at a time, for whoever listens.

An id tells the service and the node. Segments of a long object do not name it: it is the one of
that node's transfer that was heard to begin.
"""

from __future__ import annotations

from armdrive.dialects.bus import words as messages_can
from armdrive.dialects.bus.words import Check, Kind, Said
from armdrive.dialects.cia402.objects import object_words
from armdrive.dialects.cia402.words import OF_MASTER, TRANSMITTED, Told, told
from armdrive.dialects.words import Message, Weight
from armdrive.trace.sentences import wording
from firmware_protocol.canopen.cob import Service, service_of
from firmware_protocol.canopen.nmt import Heartbeat
from firmware_protocol.canopen.sdo_messages import (
    NextSegment,
    Place,
    Segment,
    SegmentTaken,
    StartDownload,
    StartUpload,
    Upload,
)
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, pack

_SEGMENTS = (NextSegment, Segment, SegmentTaken)


class CanopenEar:
    """Hears frames in their order, and knows which objects are being transferred."""

    def __init__(self) -> None:
        self._transfers: dict[int, Place] = {}

    def hear(self, frame: Frame) -> Said:
        """Put a frame into words. Never raises."""
        known = None if frame.extended or frame.remote else service_of(frame.can_id)
        service, node = known or (None, 0)
        command = "" if service is None else service.value
        try:
            read = told(frame)
        except RemoteProtocolError as error:
            words = _unreadable(frame, service, error)
            return Said(frame, Kind.UNKNOWN, command, words, Check.NONE, node)
        kind = Kind.REQUEST if read.service in OF_MASTER else Kind.ANSWER
        return Said(frame, kind, command, self._words(read), Check.NONE, read.node)

    def _words(self, read: Told) -> str:
        message = read.message
        if isinstance(message, StartUpload | StartDownload):
            self._transfers[read.node] = message.place
        words = wording(message)
        place = self._transfers.get(read.node)
        if isinstance(message, _SEGMENTS) and place is not None:
            words = f"{words}, of {object_words(place)}"
        who = f"node {read.node}" if read.node else read.who
        return f"{who}: {words}" if who else words


def _unreadable(frame: Frame, service: Service | None, error: RemoteProtocolError) -> str:
    if service is not None:
        return f"perhaps {service.value}: {error}"
    kind = "remote" if frame.remote else "extended" if frame.extended else "its id"
    return f"not of CANopen's predefined ids ({kind})"


# What CANopen drives say, as messages of a recording: how each frame is weighed, and read.

_OF_ITSELF = frozenset((0x1000, 0x1002, 0x1003, 0x1008, 0x1009, 0x100A, 0x1018, 0x6502))
"""Objects by which a device describes itself."""
_PASSING = frozenset((0x6041, 0x6061, 0x6064, 0x606C, 0x60F4))
"""Objects that tell of a moment; where drives rest is what has to agree."""
_PLACE = 4
"""Bytes of an SDO frame that say what is answered, and of which object."""


def weighed(frame: Frame) -> Message:
    """Return a frame as a message, by its service and its object."""
    data = pack(frame)
    try:
        said = told(frame)
    except RemoteProtocolError:
        return Message(data, Weight.ANSWER)
    message = said.message
    if isinstance(message, Heartbeat):
        return Message(data, Weight.BANNER if message.booted else Weight.PASSING)
    if said.service in TRANSMITTED:
        return Message(data, Weight.PASSING)
    if isinstance(message, Upload) and message.place.index in _OF_ITSELF:
        return Message(data, Weight.SELF)
    if isinstance(message, Upload) and message.place.index in _PASSING:
        return Message(data, Weight.PASSING)
    kind = frame.data[: 2 if said.service is Service.EMCY else _PLACE]
    return Message(data, Weight.MOMENT, frame.can_id.to_bytes(2, "big") + kind)


def words(data: bytes) -> object:
    """Return what frames of either side mean. Raises `RemoteProtocolError`."""
    return messages_can.words(data, _read)


def _read(frame: Frame) -> tuple[str, object]:
    said = told(frame)
    return said.who, said.message
