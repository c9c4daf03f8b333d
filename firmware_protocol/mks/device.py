"""The drive's end of an MKS bus: frames to requests, answers to frames, no clock, no motor.

The device handles ids, reply modes, and which requests its firmware supports. The owner simulates
the motor and checks that motions are requested in a bus mode.
"""

from __future__ import annotations

from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.events import EventQueue, Overrun, UnreadableFrame
from firmware_protocol.fields import message
from firmware_protocol.frames import Frame
from firmware_protocol.mks.answers import Reading, SettingRead, Status, decode_request, encode
from firmware_protocol.mks.requests import (
    COURSE_CODES,
    Read,
    ReadSetting,
    ReportByItself,
    Request,
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
    Outcome,
    ReplyMode,
    Version,
    abilities_of,
)

# Most queued frames; the newest are kept.
WAITING_MAX = 256


@message()
class Asked:
    """A request, and whether it was addressed to this drive only.

    Only firmware before 1.0.2 answers requests to several drives.
    """

    request: Request
    alone: bool = True


DeviceEvent: TypeAlias = Asked | UnreadableFrame | Overrun


class Device:
    """The protocol machine of a simulated drive. Raises `LocalProtocolError` if misused.

    Several requests may be open at once: the owner keeps them and reports their outcomes later. It
    makes a new device when the id, the group or the replies change, or the power is lost.
    Which id a drive uses to answer a `SetId` is not documented; `new_id_answers` selects the new
    one, as the authors of a public driver report. The device ignores frames to other drives. It
    takes another drive's answers with its own id, or its group's, for requests, because nothing in
    them shows the difference.
    """

    def __init__(
        self,
        node: int = NODE_DEFAULT,
        firmware: Version = LATEST,
        *,
        group: int | None = None,
        replies: ReplyMode = ReplyMode.FULL,
        new_id_answers: bool = True,
    ) -> None:
        self._node = SetId(node).node
        self._group = None if group is None else SetGroup(group).node
        self._replies = SetReplies(replies).mode
        self._abilities = abilities_of(firmware)
        self._firmware = ".".join(map(str, firmware))
        self._new_id_answers = new_id_answers
        self._waiting: EventQueue[tuple[Frame, bool]] = EventQueue(WAITING_MAX)

    @property
    def node(self) -> int:
        """The drive's id."""
        return self._node

    @property
    def group(self) -> int | None:
        """The id of the drive's group."""
        return self._group

    @property
    def abilities(self) -> frozenset[Ability]:
        """The firmware's abilities."""
        return self._abilities

    def receive_frame(self, frame: Frame) -> None:
        """Take a frame from the bus; one for other drives, or of another kind, is ignored."""
        ours = frame.can_id in (BROADCAST, self._node, self._group)
        if ours and not frame.extended and not frame.remote:
            self._waiting.put((frame, frame.can_id == self._node))

    def next_event(self) -> DeviceEvent | None:
        """Return the next event, or None."""
        waiting = self._waiting.next()
        if waiting is None or isinstance(waiting, Overrun):
            return waiting
        frame, alone = waiting
        try:
            request = decode_request(frame)
        except RemoteProtocolError as error:
            return UnreadableFrame(frame, str(error))
        needed = needed_for(request)
        if needed is not None and needed not in self._abilities:
            return UnreadableFrame(
                frame, f"firmware {self._firmware} has no {type(request).__name__}"
            )
        return Asked(request, alone)

    def tell(self, asked: Asked, outcome: Outcome) -> Frame | None:
        """Report the outcome of a request other than a read, at once or later.

        Returns the frame to send, None if the drive does not send this outcome. Raises `BadField`
        for an outcome that the request cannot have; `GoSynchronous` has none.
        """
        request = asked.request
        reading = request.reading if isinstance(request, ReportByItself) else None
        if isinstance(request, Read | ReadSetting):
            raise LocalProtocolError(f"{type(request).__name__} is answered by a reading")
        status = Status(request.code, outcome, reading)
        by_id = self._node
        if isinstance(request, SetId) and outcome is Outcome.DONE and self._new_id_answers:
            by_id = request.node
        said = self._speaks_to(asked) and self._says(request, outcome)
        return encode(by_id, status) if said else None

    def answer(self, asked: Asked, reading: Reading | SettingRead) -> Frame | None:
        """Return the answer to a read; None if the read was sent to several drives."""
        request = asked.request
        kind = SettingRead if isinstance(request, ReadSetting) else Reading
        reads = isinstance(request, Read | ReadSetting) and isinstance(reading, kind)
        if not reads or reading.code is not answer_code(request):
            raise LocalProtocolError(
                f"a {type(reading).__name__} is no answer to {type(request).__name__}"
            )
        return self.report(reading) if self._speaks_to(asked) else None

    def report(self, reading: Reading | SettingRead) -> Frame:
        """Return an automatic report."""
        return encode(self._node, reading)

    def _speaks_to(self, asked: Asked) -> bool:
        return asked.alone or Ability.SILENT_BROADCAST not in self._abilities

    def _says(self, request: Request, outcome: Outcome) -> bool:
        ends = request.code in COURSE_CODES and outcome in (Outcome.DONE, Outcome.LIMIT_STOP)
        return self._replies is ReplyMode.FULL or (
            self._replies is ReplyMode.IMMEDIATE and not ends
        )
