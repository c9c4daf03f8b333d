"""The client's end of SDO: one transfer at a time with one node, frames in, frames and events out.

No frame on the bus raises or prevents the next transfer. There is no clock: the owner keeps a
deadline for the whole transfer and calls `abandon`. The client never retries by itself.

Repeated frames are ignored, because their toggle bit or object differs. A late response is taken
for the answer to a newer transfer of the same object, because nothing in it shows the difference.
So give the server time after abandoning a transfer, or read the object back.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.canopen.cob import Service, cob_id, is_for
from firmware_protocol.canopen.objects import Place
from firmware_protocol.canopen.sdo import (
    EVENTS_MAX,
    EXPEDITED_MAX,
    SIZE_MAX,
    Abort,
    AbortCode,
    Content,
    DownloadStarted,
    NextSegment,
    Receiving,
    Request,
    Response,
    Segment,
    SegmentTaken,
    Sending,
    StartDownload,
    StartUpload,
    Upload,
    abort_words,
    decode_response,
    encode,
)
from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError, whole
from firmware_protocol.frames import Frame
from firmware_protocol.waiting import Overrun, Waiting


@dataclass(frozen=True, slots=True)
class Uploaded:
    """An object was read. If the server sent no length, `exact` is False and `data` has 4 bytes."""

    place: Place
    data: bytes
    exact: bool = True


@dataclass(frozen=True, slots=True)
class Downloaded:
    """An object was written and accepted by the server."""

    place: Place


@dataclass(frozen=True, slots=True)
class Aborted:
    """A transfer was aborted by the server, or by the client after an invalid response."""

    place: Place
    code: int
    by_server: bool

    @property
    def words(self) -> str:
        """The reason, in words."""
        return abort_words(self.code)


@dataclass(frozen=True, slots=True)
class StrayResponse:
    """A readable but unexpected response: repeated, late, or for another client."""

    response: Response


@dataclass(frozen=True, slots=True)
class GarbledResponse:
    """A frame from the server that is not a valid response, and the reason."""

    frame: Frame
    reason: str


SdoEvent: TypeAlias = Uploaded | Downloaded | Aborted | StrayResponse | GarbledResponse | Overrun


@dataclass(slots=True)
class _Reading:
    place: Place
    segments: Receiving | None = None  # set once segments begin


@dataclass(slots=True)
class _Writing:
    place: Place
    segments: Sending | None
    started: bool = False


class SdoClient:
    """The client that reads and writes the objects of one node."""

    def __init__(self, node: int, *, size_max: int = SIZE_MAX) -> None:
        self._request_id = cob_id(Service.SDO_REQUEST, node)
        self._response_id = cob_id(Service.SDO_RESPONSE, node)
        self._size_max = whole("size_max", size_max, EXPEDITED_MAX, 1 << 24)
        self._current: _Reading | _Writing | None = None
        self._events: Waiting[SdoEvent] = Waiting(EVENTS_MAX)

    @property
    def busy(self) -> Place | None:
        """The object of the current transfer."""
        return None if self._current is None else self._current.place

    def upload(self, place: Place) -> Frame:
        """Return the frame that begins to read an object. Raises `LocalProtocolError` if busy."""
        self._must_be_free()
        self._current = _Reading(place)
        return self._frame(StartUpload(place))

    def download(self, place: Place, data: bytes) -> Frame:
        """Return the frame that begins to write an object. Raises `LocalProtocolError` if busy."""
        self._must_be_free()
        if not isinstance(data, bytes) or len(data) > self._size_max:
            raise BadField("data", data, f"at most {self._size_max} bytes")
        expedited = 1 <= len(data) <= EXPEDITED_MAX
        self._current = _Writing(place, None if expedited else Sending(data))
        return self._frame(StartDownload(place, Content(data if expedited else None, len(data))))

    def abandon(self, code: AbortCode = AbortCode.TIMED_OUT) -> Frame | None:
        """Abort the current transfer without an event; return the abort frame for the server."""
        if self._current is None:
            return None
        place, self._current = self._current.place, None
        return self._frame(Abort(place, code))

    def receive_frame(self, frame: Frame) -> Frame | None:
        """Process any frame on the bus; return the frame to send next. Never raises."""
        if not is_for(frame, self._response_id):
            return None
        try:
            response = decode_response(frame.data)
        except RemoteProtocolError as error:
            self._events.put(GarbledResponse(frame, str(error)))
            return None
        request = self._hear(response)
        return None if request is None else self._frame(request)

    def next_event(self) -> SdoEvent | None:
        """Return the next event, or None."""
        return self._events.next()

    def _must_be_free(self) -> None:
        if self._current is not None:
            raise LocalProtocolError(f"the transfer of {self._current.place} is under way")

    def _frame(self, request: Request) -> Frame:
        return Frame(self._request_id, encode(request))

    def _hear(self, response: Response) -> Request | None:
        match self._current, response:
            case (_Reading() | _Writing()) as current, Abort(place, code) if _names(place, current):
                return self._end(Aborted(current.place, code, by_server=True))
            case _Reading(place, None) as reading, Upload(named, content) if named == place:
                return self._begin(reading, content)
            case _Reading(_, Receiving() as segments) as reading, Segment() as segment if (
                segment.toggle == segments.toggle
            ):
                return self._take(reading, segments, segment)
            case _Writing(place, _, False) as writing, DownloadStarted(named) if named == place:
                writing.started = True
                return self._write(writing)
            case _Writing(_, Sending() as segments, True) as writing, SegmentTaken(toggle) if (
                toggle == segments.toggle
            ):
                segments.advance()
                return self._write(writing)
            case _:
                self._events.put(StrayResponse(response))
                return None

    def _begin(self, reading: _Reading, content: Content) -> Request | None:
        if content.data is not None:
            return self._end(Uploaded(reading.place, content.data, content.size is not None))
        if content.size is not None and content.size > self._size_max:
            return self._break(reading, AbortCode.OUT_OF_MEMORY)
        reading.segments = Receiving(content.size, self._size_max)
        return NextSegment(toggle=False)

    def _take(self, reading: _Reading, segments: Receiving, segment: Segment) -> Request | None:
        refusal = segments.take(segment)
        if refusal is not None:
            return self._break(reading, refusal)
        if segment.last:
            return self._end(Uploaded(reading.place, segments.data))
        return NextSegment(segments.toggle)

    def _write(self, writing: _Writing) -> Request | None:
        if writing.segments is None or writing.segments.done:
            return self._end(Downloaded(writing.place))
        return writing.segments.segment

    def _break(self, current: _Reading | _Writing, code: AbortCode) -> Abort:
        self._end(Aborted(current.place, code, by_server=False))
        return Abort(current.place, code)

    def _end(self, event: SdoEvent) -> Request | None:
        self._current = None
        self._events.put(event)
        return None  # the transfer is over


def _names(place: Place, current: _Reading | _Writing) -> bool:
    """Return whether an abort belongs to this transfer.

    During segments some servers name no object. Before the first segment, such an abort is late: it
    answers a repeated frame of the previous transfer.
    """
    in_segments = current.started if isinstance(current, _Writing) else current.segments is not None
    return place == current.place or (in_segments and place == Place(0))
