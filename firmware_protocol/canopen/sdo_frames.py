"""The eight bytes of SDO frames, requests and responses, both ways.

    CLIENT                          SERVER
    40 ii ii ss  upload             4x ii ii ss       its data, or its size
    60, 70       next segment       0x, 1x            seven bytes at most, bit 0: the last
    2x ii ii ss  download           60 ii ii ss       taken
    0x, 1x       a segment          20, 30            taken
    80 ii ii ss  abort, code        80 ii ii ss       abort, code

Bit 4 of what has to do with segments toggles. Block transfers are not spoken.
Source: CiA 301, SDO protocols.
"""

from __future__ import annotations

from collections.abc import Callable

from firmware_protocol.canopen.sdo_messages import (
    SEGMENT_MAX,
    Abort,
    Content,
    DownloadStarted,
    NextSegment,
    Place,
    Request,
    Response,
    Segment,
    SegmentTaken,
    StartDownload,
    StartUpload,
    Upload,
)
from firmware_protocol.errors import RemoteProtocolError

SDO_SIZE = 8
"""Bytes of every SDO frame."""

_KIND = 0xE0
_TOGGLE, _LAST = 0x10, 0x01
_SEGMENT, _ABORT = 0x00, 0x80
_DOWNLOAD, _UPLOAD, _NEXT = 0x20, 0x40, 0x60  # of a client
_SEGMENT_TAKEN, _DATA, _TAKEN = 0x20, 0x40, 0x60  # of a server


def encode(message: Request | Response) -> bytes:
    """Return the eight bytes of a message."""
    match message:
        case StartUpload(place):
            return bytes((_UPLOAD,)) + place.packed + bytes(4)
        case StartDownload(place, content):
            return bytes((_DOWNLOAD | content.flags,)) + place.packed + content.packed
        case Upload(place, content):
            return bytes((_DATA | content.flags,)) + place.packed + content.packed
        case DownloadStarted(place):
            return bytes((_TAKEN,)) + place.packed + bytes(4)
        case NextSegment(toggle):
            return bytes((_NEXT | _TOGGLE * toggle,)).ljust(SDO_SIZE, b"\0")
        case SegmentTaken(toggle):
            return bytes((_SEGMENT_TAKEN | _TOGGLE * toggle,)).ljust(SDO_SIZE, b"\0")
        case Segment(toggle, data, last):
            spare = SEGMENT_MAX - len(data)
            command = _SEGMENT | _TOGGLE * toggle | spare << 1 | _LAST * last
            return (bytes((command,)) + data).ljust(SDO_SIZE, b"\0")
        case Abort(place, code):
            return bytes((_ABORT,)) + place.packed + code.to_bytes(4, "little")


def decode_request(data: bytes) -> Request:
    """Read what a client sends; raises `RemoteProtocolError`."""
    kind = _kind(data)
    if kind not in _REQUESTS:
        raise RemoteProtocolError(f"no SDO request begins with {data[0]:02x} here")
    return _REQUESTS[kind](data)


def decode_response(data: bytes) -> Response:
    """Read what a server sends; raises `RemoteProtocolError`."""
    kind = _kind(data)
    if kind not in _RESPONSES:
        raise RemoteProtocolError(f"no SDO response begins with {data[0]:02x} here")
    return _RESPONSES[kind](data)


def place_of(data: bytes) -> Place:
    """Return the object that the bytes of an initiating frame name."""
    return Place(int.from_bytes(data[1:3], "little"), data[3])


def _kind(data: bytes) -> int:
    if len(data) != SDO_SIZE:
        raise RemoteProtocolError(f"{len(data)} bytes where an SDO frame has {SDO_SIZE}")
    return data[0] & _KIND


def _toggle(data: bytes) -> bool:
    return bool(data[0] & _TOGGLE)


def _content(data: bytes) -> Content:
    return Content.read(data[0], data[4:])


def _segment(data: bytes) -> Segment:
    size = SEGMENT_MAX - (data[0] >> 1 & 7)
    return Segment(_toggle(data), data[1 : 1 + size], bool(data[0] & _LAST))


def _abort(data: bytes) -> Abort:
    return Abort(place_of(data), int.from_bytes(data[4:], "little"))


_REQUESTS: dict[int, Callable[[bytes], Request]] = {
    _UPLOAD: lambda data: StartUpload(place_of(data)),
    _DOWNLOAD: lambda data: StartDownload(place_of(data), _content(data)),
    _NEXT: lambda data: NextSegment(_toggle(data)),
    _SEGMENT: _segment,
    _ABORT: _abort,
}
_RESPONSES: dict[int, Callable[[bytes], Response]] = {
    _DATA: lambda data: Upload(place_of(data), _content(data)),
    _TAKEN: lambda data: DownloadStarted(place_of(data)),
    _SEGMENT_TAKEN: lambda data: SegmentTaken(_toggle(data)),
    _SEGMENT: _segment,
    _ABORT: _abort,
}
