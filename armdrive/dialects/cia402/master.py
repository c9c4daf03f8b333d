"""The master's end of a bus of CiA 402 drives: frames out, and what each node says as events.

What goes in and out are records of frames (`firmware_protocol.frames`). Of its PDOs a drive
receives the first, with controlword, mode and target, and transmits the first, with statusword,
mode and position; both belong to the SYNC. Nothing that is on the bus raises.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.canopen import (
    CONTROLWORD,
    MODE,
    MODE_SHOWN,
    POSITION,
    STANDARD,
    STATUSWORD,
    TARGET_POSITION,
    AbortCode,
    Controlword,
    Direction,
    Emergency,
    Heartbeat,
    Mapping,
    Nmt,
    NodeState,
    OperationMode,
    PdoSetup,
    Place,
    SdoClient,
    SdoEvent,
    Service,
    Statusword,
    Sync,
    cob_id,
    service_of,
)
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, Unpacker, pack

RECEIVED = Mapping.of_objects(STANDARD, CONTROLWORD, MODE, TARGET_POSITION)
TRANSMITTED = Mapping.of_objects(STANDARD, STATUSWORD, MODE_SHOWN, POSITION)
TARGET_MAX = (1 << 31) - 1
"""How far from its zero a drive can be sent, in increments."""


@dataclass(frozen=True, slots=True)
class NodeMessage:
    """A drive has said what it is and where, as of a SYNC. Increments."""

    node: int
    word: Statusword
    mode: int
    position: int


@dataclass(frozen=True, slots=True)
class SdoAnswered:
    """Something has come of a transfer with a node."""

    node: int
    event: SdoEvent


@dataclass(frozen=True, slots=True)
class ForeignFrame:
    """A frame that no drive of this arm sends, or that says nothing known."""

    frame: Frame
    reason: str = ""

    def __str__(self) -> str:
        return f"frame {self.frame}{': ' if self.reason else ''}{self.reason}"


Heard: TypeAlias = NodeMessage | SdoAnswered | Emergency | Heartbeat | ForeignFrame


def setups(node: int) -> tuple[PdoSetup, PdoSetup]:
    """Return the PDOs of a drive as they are to be."""
    return (
        PdoSetup(Direction.RECEIVED, 1, node, RECEIVED),
        PdoSetup(Direction.TRANSMITTED, 1, node, TRANSMITTED),
    )


class Cia402Bus:
    """The machine that speaks to the drives. It has no clock."""

    def __init__(self, nodes: Iterable[int]) -> None:
        self._clients = {node: SdoClient(node) for node in nodes}
        self._unpacker = Unpacker()
        self._events: deque[Heard] = deque()
        self._owed = bytearray()

    # -- what is said -------------------------------------------------------------------------

    def command(self, node: int, word: Controlword, mode: OperationMode, target: int) -> bytes:
        """Tell a drive what it shall be and where, from the next SYNC on."""
        data = RECEIVED.pack((word.value, int(mode), target))
        return pack(Frame(cob_id(Service.RPDO1, node), data))

    def sync(self) -> bytes:
        """Have every drive act on what it was told, and say where it is."""
        return pack(Sync().frame)

    def order(self, order: Nmt) -> bytes:
        """Order a node to be operational, say."""
        return pack(order.frame)

    def upload(self, node: int, place: Place) -> bytes:
        """Begin to read an object."""
        return pack(self._clients[node].upload(place))

    def download(self, node: int, place: Place, data: bytes) -> bytes:
        """Begin to write an object."""
        return pack(self._clients[node].download(place, data))

    def abandon(self, node: int) -> bytes:
        """Wait no longer for what comes of a transfer; the node is told.

        What has come of it already and was not fetched is dropped: it would be taken for the
        answer to whatever is asked next.
        """
        self._events = deque(each for each in self._events if not _answers(each, node))
        frame = self._clients[node].abandon(AbortCode.TIMED_OUT)
        return b"" if frame is None else pack(frame)

    def owed(self) -> bytes:
        """Return what the transfers under way have to say next."""
        data = bytes(self._owed)
        self._owed.clear()
        return data

    # -- what is heard ------------------------------------------------------------------------

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus, in any portions."""
        for frame in self._unpacker.feed(data):
            self._hear(frame)

    def silence(self) -> None:
        """Say that nothing has come for longer than a record pauses."""
        for frame in self._unpacker.silence():
            self._hear(frame)

    def next_event(self) -> Heard | None:
        """Return what was received so far, one event at a time, then None."""
        return self._events.popleft() if self._events else None

    def _hear(self, frame: Frame) -> None:
        found = None if frame.extended or frame.remote else service_of(frame.can_id)
        if found is None:
            self._events.append(ForeignFrame(frame))
            return
        service, node = found
        try:
            self._take(frame, service, node)
        except RemoteProtocolError as error:
            self._events.append(ForeignFrame(frame, str(error)))

    def _take(self, frame: Frame, service: Service, node: int) -> None:
        client = self._clients.get(node)
        if service is Service.HEARTBEAT:
            self._events.append(Heartbeat.read(frame))
        elif client is None:
            self._events.append(ForeignFrame(frame))
        elif service is Service.TPDO1:
            word, mode, position = TRANSMITTED.unpack(frame.data)
            told = NodeMessage(node, Statusword(int(word)), int(mode), int(position))
            self._events.append(told)
        elif service is Service.EMCY:
            self._events.append(Emergency.read(frame))
        elif service is Service.SDO_RESPONSE:
            self._answer(client, frame, node)
        else:
            self._events.append(ForeignFrame(frame))

    def _answer(self, client: SdoClient, frame: Frame, node: int) -> None:
        said = client.receive_frame(frame)
        if said is not None:
            self._owed += pack(said)
        while (event := client.next_event()) is not None:
            self._events.append(SdoAnswered(node, event))


def _answers(event: Heard, node: int) -> bool:
    return isinstance(event, SdoAnswered) and event.node == node


# The program's own heartbeat, which drives on a bus mind: they stop when it is missing.
#
# It is said by the loop that also steers, so that a program that was suspended, or hangs, falls
# silent. Beats that were missed are not made up for.


class HeartbeatProducer:
    """When the next heartbeat is due. Seconds."""

    def __init__(self, node: int, period_s: float) -> None:
        self.period_s = period_s
        self.due_s = math.inf
        self.said_s = math.inf
        """When it was said last; infinity before the first."""
        self._data = pack(Heartbeat(node, NodeState.OPERATIONAL).frame)

    @property
    def on(self) -> bool:
        """Whether it beats."""
        return math.isfinite(self.due_s)

    def begin(self, now_s: float) -> None:
        """Beat from now on."""
        if not self.on:
            self.due_s = now_s

    def end(self) -> None:
        """Beat no more."""
        self.due_s = self.said_s = math.inf

    def say(self, now_s: float) -> bytes:
        """Return a heartbeat if it is due."""
        if now_s < self.due_s - 1e-9:
            return b""
        self.due_s = max(self.due_s, now_s - self.period_s / 2.0) + self.period_s
        self.said_s = now_s
        return self._data
