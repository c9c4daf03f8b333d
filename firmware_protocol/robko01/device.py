"""The arm's end of the SUPER protocol: requests in, answers out, no clock, no I/O.

The device handles one request at a time. The owner sends the answer or drops the request
(`forget`), as the firmware does with unimplemented operations. No input from the host raises.
"""

from __future__ import annotations

from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.events import Overrun, Unreadable
from firmware_protocol.robko01.frames import Frame
from firmware_protocol.robko01.messages import (
    Answer,
    Endpoint,
    Request,
    decode_request,
    encode_answer,
)

DeviceEvent: TypeAlias = Request | Unreadable | Overrun
"""The firmware silently drops what is no request."""


class Device(Endpoint):
    """The protocol machine of a simulated arm. Raises `LocalProtocolError` if misused.

    After a corrupt frame it finds good frames that the firmware's reader would swallow.
    """

    @property
    def unanswered(self) -> Request | None:
        """The request that still needs an answer."""
        return self._request

    def next_event(self) -> DeviceEvent | None:
        """Return the next request; None if there is none or an answer is outstanding."""
        if self._request is not None:
            return None
        frame = self._frames.next_frame()
        if not isinstance(frame, Frame):
            return frame
        try:
            self._request = decode_request(frame)
        except RemoteProtocolError as error:
            return Unreadable(frame.raw, str(error))
        return self._request

    def send(self, answer: Answer) -> bytes:
        """Return the bytes of the answer to the current request.

        Raises `LocalProtocolError` without a request, or for another operation.
        """
        if self._request is None or answer.op is not self._request.op:
            owed = f"{self._request.op.name} is unanswered" if self._request else "nothing is owed"
            raise LocalProtocolError(f"{owed}, so an answer to {answer.op.name} cannot be sent")
        self._request = None
        return encode_answer(answer, counts_check=self._counts_check)
