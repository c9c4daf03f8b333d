"""The host's end of a bus of MKS drives: requests out, events in, no clock, no wire.

What goes in and out are records of frames (`firmware_protocol.frames`). One host speaks to several
drives. An answer belongs to the request that its drive and its code name; it is matched when it
comes in, so what came before a request never answers it. An answer to a request that was given up
may be taken for that to the next of its code: nothing in it tells them apart.

What is broadcast, or sent to a group, has no answer. Nothing that is on the bus raises.
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
"""How many events wait to be fetched, the newest."""


class Host:
    """The machine that speaks to the drives. Raises `LocalProtocolError` for its owner's mistakes.

    It has no clock: its owner ends the waiting (`forget`), and tells what only a position can tell
    (`settle`), since a drive need not say that a motion is done.
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
        """How many received bytes are held."""
        return self._unpacker.buffered

    def add(self, node: int) -> None:
        """Speak to one more drive."""
        whole("node", node, 1, NODE_MAX)
        self._drives.setdefault(node, Expecting(node))

    def unanswered(self, node: int) -> tuple[Request, ...]:
        """Return the requests to a drive without a first answer; not in the order of sending."""
        return self._drive(node).unanswered

    def under_way(self, node: int) -> tuple[Motion, ...]:
        """Return what a drive said has begun, and not that it ended."""
        return self._drive(node).under_way

    def stored(self, node: int) -> tuple[Motion, ...]:
        """Return what waits in a drive for the synchronous start."""
        return self._drive(node).stored

    def send(self, node: int, request: Request) -> bytes:
        """Return the bytes that put a request to a drive, a group or `BROADCAST`.

        Motions and stops are never refused, nor is an `EmergencyStop`. Raises
        `LocalProtocolError` for an id that is nobody's, for what makes no sense to several
        drives, and while an earlier request whose answer has the same code is unanswered.
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
        """Wait no longer for the first answer to a request to a drive, or for anything of it."""
        drive = self._drive(node)
        if request is None:
            drive.clear()
        else:
            drive.forget(request)

    def settle(self, node: int) -> None:
        """Say that a drive is known to stand: what was under way there has ended.

        Otherwise the next motion would seem to supersede one whose end was never said.
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
        """Find the drive that was given the id by which it answers."""
        for drive in self._drives.values():
            if drive.awaited(Code.NODE) == SetId(node):
                return drive.hear(event.answer)
        return event
