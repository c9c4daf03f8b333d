"""The device's end of SDO: one client's requests in, responses and events out.

The owner receives `ReadAsked` and `WriteAsked` events and answers them, at once or later, with
`supply`, `accept` or `refuse`. A newer request replaces an older one, as in any device; an answer
to a replaced request sends nothing. No frame on the bus raises.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.canopen.objects import Dictionary, ObjectEntry, Place, Value
from firmware_protocol.canopen.sdo import (
    EVENTS_MAX,
    EXPEDITED_MAX,
    SDO_SIZE,
    SIZE_MAX,
    Abort,
    AbortCode,
    Content,
    DownloadStarted,
    NextSegment,
    Request,
    Response,
    Sending,
    StartDownload,
    StartUpload,
    Upload,
    decode_request,
    encode,
    place_of,
)
from firmware_protocol.canopen.services import Service, checked_node, cob_id, is_for
from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.events import EventQueue, Overrun, UnreadableFrame
from firmware_protocol.fields import message
from firmware_protocol.frames import Frame


@message()
class ReadAsked:
    """The client requests an object."""

    place: Place


@message()
class WriteAsked:
    """The client writes an object; if not `exact`, the four bytes may be longer than the value."""

    place: Place
    data: bytes
    exact: bool = True


Ask: TypeAlias = ReadAsked | WriteAsked
SdoServerEvent: TypeAlias = Ask | UnreadableFrame | Overrun


@dataclass(slots=True)
class _Telling:
    place: Place
    segments: Sending


class SdoServer:
    """The server that gives a client access to a device's objects.

    Clients write numbers only, each in one frame; longer objects can be read.
    """

    def __init__(self, node: int) -> None:
        self._request_id = cob_id(Service.SDO_REQUEST, node)
        self._response_id = cob_id(Service.SDO_RESPONSE, node)
        self._current: Ask | _Telling | None = None
        self._events: EventQueue[SdoServerEvent] = EventQueue(EVENTS_MAX)

    @property
    def asked(self) -> Ask | None:
        """The request that the owner has not answered."""
        return None if isinstance(self._current, _Telling) else self._current

    def receive_frame(self, frame: Frame) -> Frame | None:
        """Process any frame on the bus; return the frame to send next. Never raises."""
        if not is_for(frame, self._request_id):
            return None
        try:
            request = decode_request(frame.data)
        except RemoteProtocolError as error:
            self._events.put(UnreadableFrame(frame, str(error)))
            if len(frame.data) != SDO_SIZE:
                return None
            return self._give_up(place_of(frame.data), AbortCode.COMMAND)  # a block transfer
        return self._hear(request)

    def next_event(self) -> SdoServerEvent | None:
        """Return the next event, or None."""
        return self._events.next()

    def supply(self, ask: ReadAsked, data: bytes) -> Frame | None:
        """Answer a `ReadAsked`; return the frame, or None if the request was replaced."""
        if not isinstance(data, bytes) or len(data) > SIZE_MAX:
            raise BadField("data", data, f"at most {SIZE_MAX} bytes")
        if ask != self.asked:
            return None
        expedited = 1 <= len(data) <= EXPEDITED_MAX
        self._current = None if expedited else _Telling(ask.place, Sending(data))
        return self._frame(Upload(ask.place, Content(data if expedited else None, len(data))))

    def accept(self, ask: WriteAsked) -> Frame | None:
        """Confirm a `WriteAsked`; return the frame, or None if the request was replaced."""
        if ask != self.asked:
            return None
        self._current = None
        return self._frame(DownloadStarted(ask.place))

    def refuse(self, ask: Ask, code: AbortCode) -> Frame | None:
        """Refuse a request; return the abort frame, or None if the request was replaced."""
        return self._give_up(ask.place, code) if ask == self.asked else None

    def _hear(self, request: Request) -> Frame | None:
        match self._current, request:
            case _, StartUpload(place):
                return self._ask(ReadAsked(place))
            case _, StartDownload(place, Content(None)):
                return self._give_up(place, AbortCode.TOO_LONG)
            case _, StartDownload(place, Content(bytes() as data, size)):
                return self._ask(WriteAsked(place, data, size is not None))
            case _Telling() as telling, NextSegment(toggle):
                return self._tell(telling, toggle)
            case current, Abort(place):
                if current is not None and place in (current.place, Place(0)):
                    self._current = None
                return None
            case current, _:
                return self._give_up(current.place if current else Place(0), AbortCode.COMMAND)

    def _tell(self, telling: _Telling, toggle: bool) -> Frame:
        segments = telling.segments
        if toggle != segments.toggle:
            return self._give_up(telling.place, AbortCode.TOGGLE)
        segment = segments.segment
        segments.advance()  # a repeated request is refused: the toggle bit differs in the next
        if segments.done:
            self._current = None
        return self._frame(segment)

    def _ask(self, ask: Ask) -> Frame | None:
        self._current = ask
        self._events.put(ask)
        return None  # the owner sends the response later

    def _give_up(self, place: Place, code: AbortCode) -> Frame:
        self._current = None
        return self._frame(Abort(place, code))

    def _frame(self, response: Response) -> Frame:
        return Frame(self._response_id, encode(response))


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
        if (limits := entry.type.limits) is not None:  # fast path for values from PDOs
            whole(entry.type.name, value, *limits)
        else:
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
        *,
        exact: bool = True,
        refusal: Callable[[Place, Value], AbortCode | None] = lambda _place, _value: None,
    ) -> AbortCode | None:
        """Write a client's bytes; return an abort code or None. Unless `exact`, cut excess off.

        `refusal` says why an object may not have a value of its type.
        """
        entry = self._dictionary.find(place)
        if entry is None:
            return self._missing(place)
        if not entry.access.writable:
            return AbortCode.READ_ONLY
        size = entry.type.size
        if size is not None and len(data) < size:
            return AbortCode.TOO_SHORT
        if size is not None and len(data) > size and exact:
            return AbortCode.TOO_LONG
        value = entry.type.unpack(data, exact=exact)
        refused = refusal(place, value)
        if refused is None:
            try:
                self.put(entry, value)
            except BadField:  # text that is not ASCII
                return AbortCode.VALUE
        return refused

    def answer(self, server: SdoServer, ask: Ask) -> Frame | None:
        """Answer a server's request; return the frame, or None if the request was replaced."""
        if isinstance(ask, ReadAsked):
            told = self.read(ask.place)
            if isinstance(told, AbortCode):
                return server.refuse(ask, told)
            return server.supply(ask, told)
        refusal = self.write(ask.place, ask.data, exact=ask.exact)
        return server.accept(ask) if refusal is None else server.refuse(ask, refusal)

    def _entry(self, place: Place) -> ObjectEntry:
        entry = self._dictionary.find(place)
        if entry is None:
            raise BadField("place", str(place), "an object of this dictionary")
        return entry

    def _missing(self, place: Place) -> AbortCode:
        known = place.index in self._dictionary.indices
        return AbortCode.NO_SUB_INDEX if known else AbortCode.NO_OBJECT
