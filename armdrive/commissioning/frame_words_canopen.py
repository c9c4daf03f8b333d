"""What passes on a CANopen bus, in words: one frame at a time, for whoever listens.

An id tells the service and the node. Segments of a long object do not name it: it is the one of
that node's transfer that was heard to begin.
"""

from __future__ import annotations

from armdrive.commissioning.frame_words import Check, Kind, Said
from armdrive.wording import wording
from armdrive.wording.canopen import OF_MASTER, Told, told
from armdrive.wording.canopen_objects import object_words
from firmware_protocol.canopen.cob import Service, service_of
from firmware_protocol.canopen.sdo_messages import (
    NextSegment,
    Place,
    Segment,
    SegmentTaken,
    StartDownload,
    StartUpload,
)
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame

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
