"""One MKS drive's end of the bus: requests out of frames, answers into frames, no clock, no motor.

It knows what concerns the bus: its ids, what it replies, which requests its firmware has. What a
request does to a motor, and that motions need a mode on the bus, is its owner's business.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks.answers import Reading, SettingRead, Status
from firmware_protocol.mks.requests import (
    COURSE_CODES,
    Read,
    ReadSetting,
    ReportByItself,
    Request,
    SetBitrate,
    SetGroup,
    SetId,
    SetReplies,
    answer_code,
    needed_for,
)
from firmware_protocol.mks.values import (
    BROADCAST,
    LATEST,
    NODE_DEFAULT,
    Ability,
    Bitrate,
    Outcome,
    ReplyMode,
    Version,
    abilities_of,
)
from firmware_protocol.mks.wire import decode_request, encode
from firmware_protocol.waiting import Overrun, Waiting

WAITING_MAX = 256
"""How many frames wait to be fetched, the newest."""


@dataclass(frozen=True, slots=True)
class Asked:
    """A request, and whether it was put to this drive alone.

    What is put to several is answered by firmware before 1.0.2 alone.
    """

    request: Request
    alone: bool = True


@dataclass(frozen=True, slots=True)
class Ignored:
    """A frame for this drive that it does nothing with, and why."""

    frame: Frame
    reason: str


DeviceEvent: TypeAlias = Asked | Ignored | Overrun


class Device:
    """The machine that a simulated drive speaks with. Raises `LocalProtocolError` for its owner.

    Several requests may be open at once: the owner keeps what it was asked and says later how it
    went. By which id a drive answers a `SetId` is not documented; `new_id_answers`, as a public
    driver's authors tell. Frames to others are nothing to it. Another drive's answers by its own
    id, or its group's, it takes for requests, since nothing in them tells otherwise.
    """

    def __init__(
        self,
        node: int = NODE_DEFAULT,
        firmware: Version = LATEST,
        *,
        group: int | None = None,
        replies: ReplyMode = ReplyMode.FULL,
        bitrate: Bitrate = Bitrate.K500,
        new_id_answers: bool = True,
    ) -> None:
        self._node = SetId(node).node
        self._group = None if group is None else SetGroup(group).node
        self._replies = SetReplies(replies).mode
        self._bitrate = SetBitrate(bitrate).bitrate
        self._abilities = abilities_of(firmware)
        self._firmware = ".".join(map(str, firmware))
        self._new_id_answers = new_id_answers
        self._unpacker = Unpacker()
        self._waiting: Waiting[tuple[Frame, bool]] = Waiting(WAITING_MAX)

    @property
    def node(self) -> int:
        """The drive's own id."""
        return self._node

    @property
    def group(self) -> int | None:
        """The id of its group."""
        return self._group

    @property
    def replies(self) -> ReplyMode:
        """What it says of what it is told to do."""
        return self._replies

    @property
    def bitrate(self) -> Bitrate:
        """The speed at which it listens."""
        return self._bitrate

    @property
    def abilities(self) -> frozenset[Ability]:
        """What its firmware can do."""
        return self._abilities

    @property
    def buffered(self) -> int:
        """How many received bytes are held outside of whole frames."""
        return self._unpacker.buffered

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus, in any portions."""
        for frame in self._unpacker.feed(data):
            self._take(frame)

    def silence(self) -> None:
        """Say that nothing has come for longer than a record pauses."""
        for frame in self._unpacker.silence():
            self._take(frame)

    def next_event(self) -> DeviceEvent | None:
        """Return what was received so far, one event at a time, then None."""
        waiting = self._waiting.next()
        if waiting is None or isinstance(waiting, Overrun):
            return waiting
        frame, alone = waiting
        try:
            request = decode_request(frame)
        except RemoteProtocolError as error:
            return Ignored(frame, str(error))
        needed = needed_for(request)
        if needed is not None and needed not in self._abilities:
            return Ignored(frame, f"firmware {self._firmware} has no {type(request).__name__}")
        return Asked(request, alone)

    def tell(self, asked: Asked, outcome: Outcome) -> bytes:
        """Say how it goes with a request that is no read, at once or later.

        Returns the bytes, none where the drive does not say so. `Outcome.DONE` is what makes a
        `SetId`, `SetGroup`, `SetReplies` or `SetBitrate` take effect here. Raises `BadField` for
        an outcome that the request cannot have, `GoSynchronous` has none.
        """
        request = asked.request
        reading = request.reading if isinstance(request, ReportByItself) else None
        if isinstance(request, Read | ReadSetting):
            raise LocalProtocolError(f"{type(request).__name__} is answered by a reading")
        status = Status(request.code, outcome, reading)
        said = self._speaks_to(asked) and self._says(request, outcome)
        by_id = self._node
        if outcome is Outcome.DONE:
            self._apply(request)
        if isinstance(request, SetId) and self._new_id_answers:
            by_id = self._node
        return pack(encode(by_id, status)) if said else b""

    def answer(self, asked: Asked, reading: Reading | SettingRead) -> bytes:
        """Return the bytes of the answer to a read; none where it was put to several drives."""
        request = asked.request
        kind = SettingRead if isinstance(request, ReadSetting) else Reading
        reads = isinstance(request, Read | ReadSetting) and isinstance(reading, kind)
        if not reads or reading.code is not answer_code(request):
            raise LocalProtocolError(
                f"a {type(reading).__name__} is no answer to {type(request).__name__}"
            )
        return self.report(reading) if self._speaks_to(asked) else b""

    def report(self, reading: Reading | SettingRead) -> bytes:
        """Return the bytes of a reading that is told unasked."""
        return pack(encode(self._node, reading))

    def discard(self) -> None:
        """Forget everything received, as without current."""
        self._unpacker = Unpacker()
        self._waiting.clear()

    def _take(self, frame: Frame) -> None:
        ours = frame.can_id in (BROADCAST, self._node, self._group)
        if ours and not frame.extended and not frame.remote:
            self._waiting.put((frame, frame.can_id == self._node))

    def _speaks_to(self, asked: Asked) -> bool:
        return asked.alone or Ability.SILENT_BROADCAST not in self._abilities

    def _says(self, request: Request, outcome: Outcome) -> bool:
        ends = request.code in COURSE_CODES and outcome in (Outcome.DONE, Outcome.LIMIT_STOP)
        return self._replies is ReplyMode.FULL or (
            self._replies is ReplyMode.IMMEDIATE and not ends
        )

    def _apply(self, request: Request) -> None:
        match request:
            case SetId():
                self._node = request.node
            case SetGroup():
                self._group = request.node
            case SetReplies():
                self._replies = request.mode
            case SetBitrate():
                self._bitrate = request.bitrate
