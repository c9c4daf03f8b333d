"""The master's end of a bus with CiA 402 drives: commands to bytes, and bytes to events.

Each drive uses its first PDOs, both bound to the SYNC: it receives controlword, mode and target,
and transmits statusword, mode and position. No frame on the bus raises; those of other nodes are
ignored.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import TypeAlias

from firmware_protocol.canopen.drives import Controlword, OperationMode, Statusword
from firmware_protocol.canopen.objects import (
    CONTROLWORD,
    MODE,
    MODE_SHOWN,
    POSITION,
    STANDARD,
    STATUSWORD,
    TARGET_POSITION,
    Place,
)
from firmware_protocol.canopen.pdo import Direction, Mapping, Write, first_pdo
from firmware_protocol.canopen.sdo import SdoClient, SdoEvent
from firmware_protocol.canopen.services import (
    Emergency,
    Heartbeat,
    Service,
    Sync,
    cob_id,
    service_of,
)
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.events import UnreadableFrame
from firmware_protocol.fields import message
from firmware_protocol.frames import Frame, Unpacker, pack

COMMAND_PDO = Mapping.of_objects(STANDARD, CONTROLWORD, MODE, TARGET_POSITION)
REPORT_PDO = Mapping.of_objects(STANDARD, STATUSWORD, MODE_SHOWN, POSITION)


@message()
class DriveReport:
    """A drive's report at a SYNC: its state and its position in increments."""

    node: int
    word: Statusword
    mode: int
    position: int


@message()
class SdoAnswered:
    """An event of the transfer with a node."""

    node: int
    event: SdoEvent


HostEvent: TypeAlias = DriveReport | SdoAnswered | Emergency | Heartbeat | UnreadableFrame


def drive_pdos(node: int) -> tuple[Write, ...]:
    """Return the writes that set up a drive's PDOs."""
    return (
        *first_pdo(Direction.RECEIVED, node, COMMAND_PDO),
        *first_pdo(Direction.TRANSMITTED, node, REPORT_PDO),
    )


class Host:
    """Sends commands to the drives and decodes their frames. It has no clock."""

    def __init__(self, nodes: Iterable[int]) -> None:
        self._clients = {node: SdoClient(node) for node in nodes}
        self._unpacker = Unpacker()
        self._events: deque[HostEvent] = deque()
        self._owed = bytearray()

    # -- sending ------------------------------------------------------------------------------

    def command(self, node: int, word: Controlword, mode: OperationMode, target: int) -> bytes:
        """Return a command that a drive obeys from the next SYNC on."""
        data = COMMAND_PDO.pack((word.value, int(mode), target))
        return pack(Frame(cob_id(Service.RPDO1, node), data))

    def sync(self) -> bytes:
        """Return a SYNC: every drive acts on its command and reports."""
        return pack(Sync().frame)

    def upload(self, node: int, place: Place) -> bytes:
        """Begin to read an object."""
        return pack(self._clients[node].upload(place))

    def download(self, node: int, place: Place, data: bytes) -> bytes:
        """Begin to write an object."""
        return pack(self._clients[node].download(place, data))

    def abandon(self, node: int) -> bytes:
        """Abort a transfer; return the frame that informs the node.

        Its events that were not fetched are dropped, or they would pass for the answer to the next
        transfer.
        """
        self._events = deque(
            event
            for event in self._events
            if not (isinstance(event, SdoAnswered) and event.node == node)
        )
        frame = self._clients[node].abandon()
        return b"" if frame is None else pack(frame)

    def owed(self) -> bytes:
        """Return the frames that running transfers need next."""
        data = bytes(self._owed)
        self._owed.clear()
        return data

    # -- receiving ----------------------------------------------------------------------------

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus, in any portions."""
        for frame in self._unpacker.feed(data):
            self._receive(frame)

    def silence(self) -> None:
        """End a half-received record after a silence."""
        for frame in self._unpacker.silence():
            self._receive(frame)

    def next_event(self) -> HostEvent | None:
        """Return the next event, or None."""
        return self._events.popleft() if self._events else None

    def _receive(self, frame: Frame) -> None:
        found = None if frame.extended or frame.remote else service_of(frame.can_id)
        if found is None:
            return
        try:
            self._take(frame, *found)
        except RemoteProtocolError as error:
            self._events.append(UnreadableFrame(frame, str(error)))

    def _take(self, frame: Frame, service: Service, node: int) -> None:
        if service is Service.HEARTBEAT:
            self._events.append(Heartbeat.read(frame))
        elif (client := self._clients.get(node)) is None:
            return
        elif service is Service.TPDO1:
            word, mode, position = REPORT_PDO.unpack(frame.data)
            self._events.append(DriveReport(node, Statusword(word), mode, position))
        elif service is Service.EMCY:
            self._events.append(Emergency.read(frame))
        elif service is Service.SDO_RESPONSE:
            self._answer(client, frame, node)

    def _answer(self, client: SdoClient, frame: Frame, node: int) -> None:
        reply = client.receive_frame(frame)
        if reply is not None:
            self._owed += pack(reply)
        while (event := client.next_event()) is not None:
            self._events.append(SdoAnswered(node, event))
