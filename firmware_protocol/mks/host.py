"""A host's end of a bus of MKS drives: which request an answer belongs to.

An answer contains a drive and a code, but not its request. So a drive has one open request per
code. A newer one replaces it, and the next answer with this code is taken for its answer, even if
it is a late one to the request before. An open request closes with its first answer.

A drive confirms a new id under that id (zauberzeug/lizard), so its answer belongs to no request. To
learn whether a drive has its new id, ask that id a question.

The answers to motions follow no order that a host could rely on. A motion is "started", later
"done" or "failed", or nothing more is heard of it. When a new target (F5) or a stop replaces a
motion, the drive reports "failed" for the old one and "started" for the new one, in an undocumented
order, according to a public transcription of the manual. So whoever waits for the end of a motion
asks for the state and the position.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError, whole
from firmware_protocol.events import UnreadableFrame
from firmware_protocol.fields import message
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks.answers import Answer, decode_answer, encode
from firmware_protocol.mks.requests import ReadSetting, Request, answer_code
from firmware_protocol.mks.values import NODE_MAX


@message()
class Answered:
    """A drive's answer, and the open request that it closes.

    `request` is None if none is open: the answer is late, reports the end of a motion, or comes
    from a second drive with this id.
    """

    node: int
    answer: Answer
    request: Request | None = None


@message()
class Foreign:
    """A frame from another device on the bus."""

    frame: Frame


Event: TypeAlias = Answered | UnreadableFrame | Foreign


class Host:
    """The host's protocol machine, for several drives. Raises `LocalProtocolError` if misused.

    Input and output are frame records (`firmware_protocol.frames`). No frame on the bus raises. An
    answer is matched on arrival, so that an earlier answer never matches a later request. The host
    speaks to one drive at a time: broadcasts and groups have no answers, so nothing shows which
    drives obeyed. There is no clock: the caller calls `forget` after a timeout.
    """

    def __init__(self, nodes: Iterable[int]) -> None:
        self._open: dict[int, dict[int, Request]] = {
            whole("node", node, 1, NODE_MAX): {} for node in nodes
        }
        self._unpacker = Unpacker()
        self._events: deque[Event] = deque()

    def send(self, node: int, request: Request) -> bytes:
        """Return the bytes of a request to a drive. Raises `LocalProtocolError` for another id."""
        self._of(node)[answer_code(request)] = request
        return pack(encode(node, request))

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus, in any portions."""
        for frame in self._unpacker.feed(data):
            self._events.append(self._hear(frame))

    def silence(self) -> None:
        """Say that nothing has come for longer than a record pauses."""
        for frame in self._unpacker.silence():
            self._events.append(self._hear(frame))

    def next_event(self) -> Event | None:
        """Return what was received so far, one event at a time, then None."""
        return self._events.popleft() if self._events else None

    def forget(self, node: int) -> None:
        """Close a drive's open requests: what it answers from now on belongs to none of them."""
        self._of(node).clear()

    def _of(self, node: int) -> dict[int, Request]:
        if node not in self._open:
            raise LocalProtocolError(f"no drive of this host has the id {node}")
        return self._open[node]

    def _hear(self, frame: Frame) -> Event:
        requests = self._open.get(frame.can_id)
        if requests is None or frame.extended or frame.remote:
            return Foreign(frame)
        asked = requests.get(frame.data[0]) if frame.data else None
        try:
            answer = decode_answer(frame, setting=isinstance(asked, ReadSetting))
        except RemoteProtocolError as error:
            return UnreadableFrame(frame, str(error))
        return Answered(frame.can_id, answer, requests.pop(answer.code, None))
