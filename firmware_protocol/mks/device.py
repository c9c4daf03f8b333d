"""The drive's end of an MKS bus: frames to requests, answers to frames, no clock, no motor.

The device handles ids, reply modes, and which requests its firmware supports. The owner simulates
the motor and checks that motions are requested in a bus mode.
"""

from __future__ import annotations

from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.fields import message
from firmware_protocol.frames import Frame
from firmware_protocol.mks.answers import Reading, SettingRead, Status, decode_request, encode
from firmware_protocol.mks.requests import COURSE_CODES, Request, SetId, SetReplies
from firmware_protocol.mks.values import (
    BROADCAST,
    LATEST,
    NODE_DEFAULT,
    Outcome,
    ReplyMode,
    Version,
    abilities_of,
)


@message()
class Asked:
    """A request, and whether it was addressed to this drive only: one to all has no answer."""

    request: Request
    alone: bool = True


class Device:
    """The protocol machine of a simulated drive.

    Several requests may be open at once: the owner keeps them and reports their outcomes later. It
    makes a new device when the id or the replies change, or the power is lost. A `SetId` is
    confirmed under the new id, as the authors of a public driver report (zauberzeug/lizard). The
    device takes another drive's answers with its own id for requests, because nothing in them shows
    the difference.
    """

    def __init__(
        self,
        node: int = NODE_DEFAULT,
        firmware: Version = LATEST,
        *,
        replies: ReplyMode = ReplyMode.FULL,
    ) -> None:
        self.node = SetId(node).node
        """The drive's id."""
        self._replies = SetReplies(replies).mode
        self.abilities = abilities_of(firmware)
        """The firmware's abilities."""

    def hear(self, frame: Frame) -> Asked | None:
        """Return the request in a frame; None if it is for others, unreadable or not supported."""
        if frame.can_id not in (BROADCAST, self.node) or frame.extended or frame.remote:
            return None
        try:
            request = decode_request(frame)
        except RemoteProtocolError:
            return None
        able = request.needs is None or request.needs in self.abilities
        return Asked(request, frame.can_id == self.node) if able else None

    def tell(self, asked: Asked, outcome: Outcome) -> Frame | None:
        """Report the outcome of a request other than a read, at once or later.

        Returns the frame to send, None if the drive does not send this outcome. Raises `BadField`
        for an outcome that the request cannot have.
        """
        request = asked.request
        status = Status(request.code, outcome)
        by_id = self.node
        if isinstance(request, SetId) and outcome is Outcome.DONE:
            by_id = request.node
        return encode(by_id, status) if asked.alone and self._says(request, outcome) else None

    def answer(self, asked: Asked, reading: Reading | SettingRead) -> Frame | None:
        """Return the answer to a read; None if the read was sent to several drives."""
        return encode(self.node, reading) if asked.alone else None

    def _says(self, request: Request, outcome: Outcome) -> bool:
        ends = request.code in COURSE_CODES and outcome in (Outcome.DONE, Outcome.LIMIT_STOP)
        return self._replies is ReplyMode.FULL or (
            self._replies is ReplyMode.IMMEDIATE and not ends
        )
