"""SDO, the service that reads and writes objects: messages, abort codes and segments."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Self, TypeAlias

from firmware_protocol.canopen.objects import Place
from firmware_protocol.canopen.services import Service, cob_id, is_for
from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError, whole
from firmware_protocol.events import UnreadableFrame
from firmware_protocol.fields import message, some_bytes, whole_from
from firmware_protocol.frames import Frame


class AbortCode(IntEnum):
    """The abort codes of CiA 301 with their descriptions; devices may send others."""

    words: str

    def __new__(cls, code: int, words: str) -> Self:
        """Make an integer member with a description."""
        one = int.__new__(cls, code)
        one._value_, one.words = code, words
        return one

    TOGGLE = 0x0503_0000, "the toggle bit did not alternate: a frame was lost or came twice"
    TIMED_OUT = 0x0504_0000, "the transfer took too long"
    COMMAND = 0x0504_0001, "this is no command here and now"
    BLOCK_SIZE = 0x0504_0002, "the block has no valid size"
    SEQUENCE_NUMBER = 0x0504_0003, "the block has no valid sequence number"
    CRC = 0x0504_0004, "the block's CRC is wrong"
    OUT_OF_MEMORY = 0x0504_0005, "there is more of it than memory"
    ACCESS = 0x0601_0000, "the object cannot be accessed so"
    WRITE_ONLY = 0x0601_0001, "the object can only be written"
    READ_ONLY = 0x0601_0002, "the object can only be read"
    NO_OBJECT = 0x0602_0000, "there is no such object"
    NOT_MAPPABLE = 0x0604_0041, "the object cannot be mapped into this PDO"
    PDO_TOO_LONG = 0x0604_0042, "the mapped objects are too many or too long for a PDO"
    PARAMETERS = 0x0604_0043, "the parameters do not go together"
    INTERNAL = 0x0604_0047, "the device does not go together with itself"
    HARDWARE = 0x0606_0000, "a hardware error prevents it"
    LENGTH = 0x0607_0010, "the object has another length"
    TOO_LONG = 0x0607_0012, "the value is too long for the object"
    TOO_SHORT = 0x0607_0013, "the value is too short for the object"
    NO_SUB_INDEX = 0x0609_0011, "the object has no such sub-index"
    VALUE = 0x0609_0030, "the value is not allowed"
    VALUE_TOO_HIGH = 0x0609_0031, "the value is too high"
    VALUE_TOO_LOW = 0x0609_0032, "the value is too low"
    MAXIMUM_BELOW_MINIMUM = 0x0609_0036, "the maximum would be below the minimum"
    NO_RESOURCE = 0x060A_0023, "what is needed for it is not available"
    GENERAL = 0x0800_0000, "an error of no particular kind"
    NOT_STORED = 0x0800_0020, "the value cannot be transferred or stored"
    LOCAL_CONTROL = 0x0800_0021, "the device is controlled locally"
    DEVICE_STATE = 0x0800_0022, "the device's present state does not allow it"
    NO_DICTIONARY = 0x0800_0023, "the device has no object dictionary"
    NO_DATA = 0x0800_0024, "there is no data"


def abort_words(code: int) -> str:
    """Return the description of an abort code."""
    known = (each.words for each in AbortCode if each == code)
    return next(known, f"abort code {code:08X}, which CiA 301 does not have")


# The messages of SDO client and server.

SEGMENT_MAX = 7
# Most bytes that an initiating frame itself can carry.
EXPEDITED_MAX = 4

_EXPEDITED, _SIZED = 0x02, 0x01


@message()
class Content:
    """The content of an initiating frame: up to four bytes, or the number of bytes to follow.

    `size` is None if the frame does not contain it; there are then always four bytes.
    """

    data: bytes | None
    size: int | None

    def __post_init__(self) -> None:
        if self.size is not None:
            whole("size", self.size, 0 if self.data is None else 1, 0xFFFF_FFFF)
        expected = EXPEDITED_MAX if self.size is None else self.size
        if self.data is not None and not len(self.data) == expected <= EXPEDITED_MAX:
            raise BadField("data", self.data, "1 to 4 bytes of that size, or 4 without a size")

    @property
    def flags(self) -> int:
        """The low bits of the command byte."""
        spare = 0 if self.data is None else EXPEDITED_MAX - len(self.data)
        return spare << 2 | _EXPEDITED * (self.data is not None) | _SIZED * (self.size is not None)

    @property
    def packed(self) -> bytes:
        """The last four bytes."""
        if self.data is None:
            return (self.size or 0).to_bytes(4, "little")
        return self.data.ljust(EXPEDITED_MAX, b"\0")

    @classmethod
    def read(cls, command: int, packed: bytes) -> Content:
        """Decode a command byte and the last four bytes."""
        if not command & _SIZED:
            return cls(packed if command & _EXPEDITED else None, None)
        if not command & _EXPEDITED:
            return cls(None, int.from_bytes(packed, "little"))
        size = EXPEDITED_MAX - (command >> 2 & 3)
        return cls(packed[:size], size)


@message()
class StartUpload:
    """The client requests an object."""

    place: Place


@message()
class StartDownload:
    """The client begins to write an object."""

    place: Place
    content: Content


@message()
class Upload:
    """The server begins to send an object."""

    place: Place
    content: Content


@message()
class DownloadStarted:
    """The server has accepted a `StartDownload`."""

    place: Place


@message()
class NextSegment:
    """The client requests the next segment of an upload."""

    toggle: bool


@message(data=some_bytes(SEGMENT_MAX))
class Segment:
    """A segment of data, from either side."""

    toggle: bool
    data: bytes
    last: bool


@message()
class SegmentTaken:
    """The server has accepted a segment."""

    toggle: bool


@message(code=whole_from(0, 0xFFFF_FFFF))
class Abort:
    """Either side aborts the transfer."""

    place: Place
    code: int

    @property
    def words(self) -> str:
        """The reason, in words."""
        return abort_words(self.code)


Request: TypeAlias = StartUpload | StartDownload | NextSegment | Segment | Abort
Response: TypeAlias = Upload | DownloadStarted | Segment | SegmentTaken | Abort


# The eight bytes of SDO frames, requests and responses, both ways.
#
#     CLIENT                          SERVER
#     40 ii ii ss  upload             4x ii ii ss       its data, or its size
#     60, 70       next segment       0x, 1x            seven bytes at most, bit 0: the last
#     2x ii ii ss  download           60 ii ii ss       taken
#     0x, 1x       a segment          20, 30            taken
#     80 ii ii ss  abort, code        80 ii ii ss       abort, code
#
# Bit 4 toggles in all segment frames. Block transfers are not supported.
# Source: CiA 301, SDO protocols.

# Bytes in every SDO frame.
SDO_SIZE = 8

_KIND = 0xE0
_TOGGLE, _LAST = 0x10, 0x01
_SEGMENT, _ABORT = 0x00, 0x80
_DOWNLOAD, _UPLOAD, _NEXT = 0x20, 0x40, 0x60  # sent by a client
_SEGMENT_TAKEN, _DATA, _TAKEN = 0x20, 0x40, 0x60  # sent by a server


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
    """Decode a client's message. Raises `RemoteProtocolError`."""
    kind = _kind(data)
    if kind not in _REQUESTS:
        raise RemoteProtocolError(f"no SDO request begins with {data[0]:02x} here")
    return _REQUESTS[kind](data)


def decode_response(data: bytes) -> Response:
    """Decode a server's message. Raises `RemoteProtocolError`."""
    kind = _kind(data)
    if kind not in _RESPONSES:
        raise RemoteProtocolError(f"no SDO response begins with {data[0]:02x} here")
    return _RESPONSES[kind](data)


def place_of(data: bytes) -> Place:
    """Return the object named in an initiating frame."""
    return Place(int.from_bytes(data[1:3], "little"), data[3])


def _kind(data: bytes) -> int:
    if len(data) != SDO_SIZE:
        raise RemoteProtocolError(f"length {len(data)} where an SDO frame has {SDO_SIZE}")
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


# The greatest object that is transferred, in bytes. Names are the longest.
SIZE_MAX = 1024


@message()
class Uploaded:
    """An object was read. If the server sent no length, `exact` is False and `data` has 4 bytes."""

    place: Place
    data: bytes
    exact: bool = True


@message()
class Downloaded:
    """An object was written and accepted by the server."""

    place: Place


@message()
class Aborted:
    """A transfer was aborted by the server, or by the client after an invalid response."""

    place: Place
    code: int

    @property
    def words(self) -> str:
        """The reason, in words."""
        return abort_words(self.code)


@message()
class StrayResponse:
    """A readable but unexpected response: repeated, late, or for another client."""

    response: Response


SdoEvent: TypeAlias = Uploaded | Downloaded | Aborted | StrayResponse | UnreadableFrame


@dataclass(slots=True)
class _Transfer:
    """A transfer of an object; its data once it is read in segments.

    `size` is the announced number of bytes, None if the server announced none.
    """

    place: Place
    reads: bool
    data: bytearray | None = None
    size: int | None = None
    toggle: bool = False


class SdoClient:
    """The client that reads and writes the objects of one node, one transfer at a time.

    No frame on the bus raises or prevents the next transfer. There is no clock: the owner keeps a
    deadline for the whole transfer and calls `abandon`. The client never retries by itself.

    Repeated frames are ignored, because their toggle bit or object differs. A late response is
    taken for the answer to a newer transfer of the same object, because nothing in it shows the
    difference. So give the server time after abandoning a transfer, or read the object back.
    """

    def __init__(self, node: int) -> None:
        self._request_id = cob_id(Service.SDO_REQUEST, node)
        self._response_id = cob_id(Service.SDO_RESPONSE, node)
        self._current: _Transfer | None = None
        self._events: deque[SdoEvent] = deque()

    @property
    def busy(self) -> Place | None:
        """The object of the current transfer."""
        return None if self._current is None else self._current.place

    def upload(self, place: Place) -> Frame:
        """Return the frame that begins to read an object. Raises `LocalProtocolError` if busy."""
        self._must_be_free()
        self._current = _Transfer(place, reads=True)
        return self._frame(StartUpload(place))

    def download(self, place: Place, data: bytes) -> Frame:
        """Return the frame that writes an object: a number, so in one to four bytes.

        Raises `LocalProtocolError` if busy.
        """
        self._must_be_free()
        content = Content(data, len(data))
        self._current = _Transfer(place, reads=False)
        return self._frame(StartDownload(place, content))

    def abandon(self) -> Frame | None:
        """Abort the current transfer without an event; return the abort frame for the server."""
        if self._current is None:
            return None
        place, self._current = self._current.place, None
        return self._frame(Abort(place, AbortCode.TIMED_OUT))

    def receive_frame(self, frame: Frame) -> Frame | None:
        """Process any frame on the bus; return the frame to send next. Never raises."""
        if not is_for(frame, self._response_id):
            return None
        try:
            response = decode_response(frame.data)
        except RemoteProtocolError as error:
            self._events.append(UnreadableFrame(frame, str(error)))
            return None
        request = self._hear(response)
        return None if request is None else self._frame(request)

    def next_event(self) -> SdoEvent | None:
        """Return the next event, or None."""
        return self._events.popleft() if self._events else None

    def _must_be_free(self) -> None:
        if self._current is not None:
            raise LocalProtocolError(f"the transfer of {self._current.place} is under way")

    def _frame(self, request: Request) -> Frame:
        return Frame(self._request_id, encode(request))

    def _hear(self, response: Response) -> Request | None:
        current = self._current
        match response:
            case Abort(place, code) if current and _names(place, current):
                return self._end(Aborted(current.place, code))
            case Upload(place, content) if current and current.reads and place == current.place:
                if current.data is None:
                    return self._begin(current, content)
            case Segment(toggle) if current and current.data is not None:
                if toggle == current.toggle:
                    return self._take(current, current.data, response)
            case DownloadStarted(place) if current and not current.reads and place == current.place:
                return self._end(Downloaded(place))
        self._events.append(StrayResponse(response))
        return None

    def _begin(self, current: _Transfer, content: Content) -> Request | None:
        if content.data is not None:
            return self._end(Uploaded(current.place, content.data, content.size is not None))
        if content.size is not None and content.size > SIZE_MAX:
            return self._break(current, AbortCode.OUT_OF_MEMORY)
        current.data, current.size = bytearray(), content.size
        return NextSegment(toggle=False)

    def _take(self, current: _Transfer, data: bytearray, segment: Segment) -> Request | None:
        data += segment.data
        current.toggle = not current.toggle
        # the announced size shows lost and repeated segments that the toggle bit misses
        if current.size is None and len(data) > SIZE_MAX:
            return self._break(current, AbortCode.OUT_OF_MEMORY)
        if current.size is not None and len(data) > current.size:
            return self._break(current, AbortCode.TOO_LONG)
        if not segment.last:
            return NextSegment(current.toggle)
        if current.size not in (None, len(data)):
            return self._break(current, AbortCode.TOO_SHORT)
        return self._end(Uploaded(current.place, bytes(data)))

    def _break(self, current: _Transfer, code: AbortCode) -> Abort:
        self._end(Aborted(current.place, code))
        return Abort(current.place, code)

    def _end(self, event: SdoEvent) -> Request | None:
        self._current = None
        self._events.append(event)
        return None  # the transfer is over


def _names(place: Place, current: _Transfer) -> bool:
    """Return whether an abort belongs to this transfer.

    During segments some servers name no object. Before the first segment, such an abort is late: it
    answers a repeated frame of the previous transfer.
    """
    return place == current.place or (current.data is not None and place == Place(0))
