"""The arm's end of the SUPER protocol: requests in, answers out, no clock, no wire.

The device takes one request at a time and owes its answer, until it is sent or, as the firmware
does with what it has not implemented, kept back (`forget`). Nothing that the host sends raises.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.robko01.frames import Noise, Receiving
from firmware_protocol.robko01.messages import Answer, Request, decode_request, encode_answer


@dataclass(frozen=True, slots=True)
class Ignored:
    """Bytes that are no request, and why. The firmware drops them in silence: nothing is owed."""

    data: bytes
    reason: str


Heard: TypeAlias = Request | Ignored


class Device(Receiving):
    """The machine that a simulated arm speaks with. Raises `LocalProtocolError` for its owner.

    It finds the good frames behind spoilt ones that the firmware's reader would swallow.
    """

    def __init__(self, *, counts_check: bool = False) -> None:
        super().__init__(counts_check=counts_check)
        self._request: Request | None = None

    @property
    def unanswered(self) -> Request | None:
        """What still needs an answer."""
        return self._request

    def next_event(self) -> Heard | None:
        """Return the next request, or None while there is none or an answer is owed."""
        if self._request is not None:
            return None
        frame = self._frames.next_frame()
        if frame is None:
            return None
        if isinstance(frame, Noise):
            return Ignored(frame.data, frame.reason)
        try:
            self._request = decode_request(frame)
        except RemoteProtocolError as error:
            return Ignored(frame.raw, str(error))
        return self._request

    def send(self, answer: Answer) -> bytes:
        """Return the bytes of the answer that is owed.

        Raises `LocalProtocolError` where none is owed, or one to another operation.
        """
        if self._request is None or answer.op is not self._request.op:
            owed = f"{self._request.op.name} is unanswered" if self._request else "nothing is owed"
            raise LocalProtocolError(f"{owed}, so an answer to {answer.op.name} cannot be sent")
        self._request = None
        return encode_answer(answer, counts_check=self._counts_check)

    def forget(self) -> Request | None:
        """Owe nothing any more, and return what was unanswered."""
        request, self._request = self._request, None
        return request

    def discard(self) -> None:
        """Forget the bytes received; what is owed stays owed."""
        self._frames.discard()
