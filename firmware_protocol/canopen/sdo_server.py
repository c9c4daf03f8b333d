"""The device's end of SDO: one client's requests in, responses and events out.

No frame on the bus raises.
"""

from __future__ import annotations

from collections.abc import Callable

from firmware_protocol.canopen.objects import Dictionary, ObjectEntry, Place, Value
from firmware_protocol.canopen.sdo import (
    EXPEDITED_MAX,
    SDO_SIZE,
    SEGMENT_MAX,
    Abort,
    AbortCode,
    Content,
    DownloadStarted,
    NextSegment,
    Request,
    Response,
    Segment,
    StartDownload,
    StartUpload,
    Upload,
    decode_request,
    encode,
    place_of,
)
from firmware_protocol.canopen.services import Service, checked_node, cob_id, is_for
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.frames import Frame


class SdoServer:
    """The server that gives a client access to a device's objects.

    `read` returns an object's bytes, and `write` takes the bytes of one and whether their number is
    exact (else there are four, and the value may be shorter). Both may return why not. Clients
    write numbers only, each in one frame; longer objects can be read.
    """

    def __init__(
        self,
        node: int,
        read: Callable[[Place], bytes | AbortCode],
        write: Callable[[Place, bytes, bool], AbortCode | None],
    ) -> None:
        self._request_id = cob_id(Service.SDO_REQUEST, node)
        self._response_id = cob_id(Service.SDO_RESPONSE, node)
        self._read, self._write = read, write
        self._place, self._left, self._toggle = Place(0), b"", False
        self._telling = False
        """Whether an object is being read in segments: `_left` of it."""

    def receive_frame(self, frame: Frame) -> Frame | None:
        """Process any frame on the bus; return the answer. Never raises."""
        if not is_for(frame, self._request_id) or len(frame.data) != SDO_SIZE:
            return None
        try:
            response = self._answer(decode_request(frame.data))
        except RemoteProtocolError:  # a block transfer
            response = self._give_up(place_of(frame.data), AbortCode.COMMAND)
        return None if response is None else Frame(self._response_id, encode(response))

    def _answer(self, request: Request) -> Response | None:
        match request:
            case StartUpload(place):
                return self._begin(place)
            case StartDownload(place, Content(None)):
                return self._give_up(place, AbortCode.TOO_LONG)
            case StartDownload(place, Content(bytes() as data, size)):
                self._telling = False
                refusal = self._write(place, data, size is not None)
                return DownloadStarted(place) if refusal is None else Abort(place, refusal)
            case NextSegment(toggle) if self._telling:
                return self._next_segment(toggle)
            case Abort(place):
                self._telling = self._telling and place not in (self._place, Place(0))
                return None
        return self._give_up(self._place if self._telling else Place(0), AbortCode.COMMAND)

    def _begin(self, place: Place) -> Response:
        data = self._read(place)
        if isinstance(data, AbortCode):
            return self._give_up(place, data)
        self._telling = not 1 <= len(data) <= EXPEDITED_MAX
        self._place, self._left, self._toggle = place, data, False
        return Upload(place, Content(None if self._telling else data, len(data)))

    def _next_segment(self, toggle: bool) -> Response:
        if toggle != self._toggle:  # a repeated request: the client would miss the next segment
            return self._give_up(self._place, AbortCode.TOGGLE)
        data, self._left = self._left[:SEGMENT_MAX], self._left[SEGMENT_MAX:]
        self._toggle, self._telling = not self._toggle, bool(self._left)
        return Segment(toggle, data, not self._left)

    def _give_up(self, place: Place, code: AbortCode) -> Response:
        self._telling = False
        return Abort(place, code)


# The values of a device's objects, with access by the rules of its dictionary.


class ObjectStore:
    """The values of a device's objects. Reading an object without a value is an abort."""

    def __init__(self, dictionary: Dictionary, node: int) -> None:
        self._dictionary = dictionary
        initial = ((entry.place, entry.initial(checked_node(node))) for entry in dictionary)
        self._values = {place: value for place, value in initial if value is not None}

    def value(self, place: Place) -> Value | None:
        """Return an object's value, or None if it has none. Raises `BadField` if unknown."""
        self._entry(place)
        return self._values.get(place)

    def number(self, place: Place, default: int = 0) -> int:
        """Return an object's integer value, or the default if it has none."""
        value = self._values.get(place)
        return default if value is None else int(value)

    def set(self, place: Place, value: Value) -> None:
        """Set an object from inside the device, regardless of its access. Raises `BadField`."""
        self.put(self._entry(place), value)

    def put(self, entry: ObjectEntry, value: Value) -> None:
        """Set an object that was found in the dictionary, like `set`."""
        entry.type.pack(value)
        self._values[entry.place] = value

    def read(self, place: Place) -> bytes | AbortCode:
        """Return an object's bytes for a client, or the abort code."""
        entry = self._dictionary.find(place)
        if entry is None:
            return self._missing(place)
        if not entry.access.readable:
            return AbortCode.WRITE_ONLY
        value = self._values.get(place)
        return AbortCode.NO_DATA if value is None else entry.type.pack(value)

    def write(
        self,
        place: Place,
        data: bytes,
        exact: bool = True,
        *,
        refusal: Callable[[Place, Value], AbortCode | None] = lambda _place, _value: None,
    ) -> AbortCode | None:
        """Write a number's bytes; return an abort code or None. Unless `exact`, cut excess off.

        `refusal` says why an object may not have a value of its type.
        """
        entry = self._dictionary.find(place)
        if entry is None:
            return self._missing(place)
        if not entry.access.writable:
            return AbortCode.READ_ONLY
        size = entry.type.size or 0
        if len(data) < size:
            return AbortCode.TOO_SHORT
        if len(data) > size and exact:
            return AbortCode.TOO_LONG
        value = entry.type.unpack(data, exact=exact)
        if (refused := refusal(place, value)) is None:
            self.put(entry, value)
        return refused

    def _entry(self, place: Place) -> ObjectEntry:
        entry = self._dictionary.find(place)
        if entry is None:
            raise BadField("place", str(place), "an object of this dictionary")
        return entry

    def _missing(self, place: Place) -> AbortCode:
        known = place.index in self._dictionary.indices
        return AbortCode.NO_SUB_INDEX if known else AbortCode.NO_OBJECT
