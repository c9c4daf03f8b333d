"""The host's end of a bus of MKS drives: requests out, events in, no clock, no I/O.

Input and output are frame records (`firmware_protocol.frames`). One host talks to several drives.
An answer is matched on arrival to the request with the same drive and code, so that an earlier
answer never matches a later request. A late answer after `forget` may be taken for the answer to
the next request with this code, because nothing in it shows the difference.

Requests to a group and broadcasts have no answers. No frame on the bus raises.
"""

from __future__ import annotations

from collections.abc import Iterable

from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError, whole
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks.replies import Event, Expecting, Foreign, Garbled, Stray
from firmware_protocol.mks.requests import (
    GoSynchronous,
    Motion,
    Read,
    ReadSetting,
    Request,
    SetGroup,
    SetId,
)
from firmware_protocol.mks.values import BROADCAST, NODE_MAX, Code
from firmware_protocol.mks.wire import decode_answer, encode
from firmware_protocol.waiting import Waiting

EVENTS_MAX = 256
"""Most queued events; the newest are kept."""


class Host:
    """The host's protocol machine. Raises `LocalProtocolError` if misused.

    There is no clock: the caller calls `forget` after a timeout. A drive need not report the end of
    a motion, so the caller calls `settle` once the position shows that the drive is at rest.
    """

    def __init__(self, nodes: Iterable[int], groups: Iterable[int] = ()) -> None:
        self._drives: dict[int, Expecting] = {}
        self._unpacker = Unpacker()
        self._events: Waiting[Event] = Waiting(EVENTS_MAX)
        for node in nodes:
            self.add(node)
        self._groups = frozenset(whole("groups", group, 1, NODE_MAX) for group in groups)
        if shared := self._groups & self.nodes:
            raise BadField("groups", sorted(shared), "other ids than those of drives")

    @property
    def nodes(self) -> frozenset[int]:
        """The ids of the drives."""
        return frozenset(self._drives)

    @property
    def buffered(self) -> int:
        """Number of buffered bytes."""
        return self._unpacker.buffered

    def add(self, node: int) -> None:
        """Add a drive."""
        whole("node", node, 1, NODE_MAX)
        self._drives.setdefault(node, Expecting(node))

    def unanswered(self, node: int) -> tuple[Request, ...]:
        """Return a drive's requests without a first answer, in no particular order."""
        return self._drive(node).unanswered

    def under_way(self, node: int) -> tuple[Motion, ...]:
        """Return the motions that a drive has reported as started and not as ended."""
        return self._drive(node).under_way

    def stored(self, node: int) -> tuple[Motion, ...]:
        """Return the motions that a drive has stored for the synchronous start."""
        return self._drive(node).stored

    def send(self, node: int, request: Request) -> bytes:
        """Return the bytes of a request to a drive, a group or `BROADCAST`.

        Motions, stops and `EmergencyStop` are never refused. Raises `LocalProtocolError` for an
        unknown id, for a request that several drives cannot take, and while an earlier request is
        unanswered whose answer has the same code.
        """
        data = pack(encode(node, request))
        if isinstance(request, SetGroup) and request.node in self._drives:
            raise LocalProtocolError(f"{request.node} is a drive: its answers would be commands")
        if node == BROADCAST or node in self._groups:
            self._to_many(node, request)
            return data
        drive = self._drive(node)
        if isinstance(request, GoSynchronous):
            raise LocalProtocolError("GoSynchronous is broadcast, or no drive goes")
        drive.send(request)
        if isinstance(request, SetId):
            self.add(request.node)
        return data

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus, in any portions."""
        for frame in self._unpacker.feed(data):
            self._events.put(self._hear(frame))

    def silence(self) -> None:
        """Say that nothing has come for longer than a record pauses."""
        for frame in self._unpacker.silence():
            self._events.put(self._hear(frame))

    def next_event(self) -> Event | None:
        """Return what was received so far, one event at a time, then None."""
        return self._events.next()

    def forget(self, node: int, request: Request | None = None) -> None:
        """Stop waiting for the first answer to one request to a drive, or to all of them."""
        drive = self._drive(node)
        if request is None:
            drive.clear()
        else:
            drive.forget(request)

    def settle(self, node: int) -> None:
        """Report that a drive is known to be at rest, so that its motions have ended.

        Otherwise the next motion would seem to supersede a motion whose end was never reported.
        """
        self._drive(node).settle()

    def _drive(self, node: int) -> Expecting:
        if node not in self._drives:
            raise LocalProtocolError(f"no drive of this host has the id {node}")
        return self._drives[node]

    def _to_many(self, node: int, request: Request) -> None:
        if isinstance(request, Read | ReadSetting | SetId):
            raise LocalProtocolError(f"{type(request).__name__} is put to one drive alone")
        if isinstance(request, GoSynchronous):
            if node != BROADCAST:
                raise LocalProtocolError("GoSynchronous is broadcast, or no drive goes")
            for drive in self._drives.values():
                drive.go()

    def _hear(self, frame: Frame) -> Event:
        drive = self._drives.get(frame.can_id)
        if drive is None or frame.extended or frame.remote:
            return Foreign(frame)
        awaited = drive.awaited(frame.data[0]) if frame.data else None
        try:
            answer = decode_answer(frame, setting=isinstance(awaited, ReadSetting))
        except RemoteProtocolError as error:
            return Garbled(frame, str(error))
        event = drive.hear(answer)
        if isinstance(event, Stray) and answer.code is Code.NODE:
            return self._by_new_id(frame.can_id, event)
        return event

    def _by_new_id(self, node: int, event: Stray) -> Event:
        """Match an answer from the new id of a drive after `SetId`."""
        for drive in self._drives.values():
            if drive.awaited(Code.NODE) == SetId(node):
                return drive.hear(event.answer)
        return event
