"""The host's end of the SUPER protocol: requests out, answers in. No clock, no I/O.

An answer matches if it has the request's operation, began to arrive after the request was sent and,
for a `Ping`, returns its bytes. Any other answer is `Stray`; bytes that are not an answer are
`Unreadable`. Neither changes the state. At most one request is unanswered, and no input raises.

The arm's end is the simulated board itself: it reads bytes as the firmware does, which loses frames
that `FrameSplitter` would find.
"""

from __future__ import annotations

from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.events import Stray, Unreadable
from firmware_protocol.fields import message
from firmware_protocol.robko01.frames import FrameSplitter, SuperFrame
from firmware_protocol.robko01.messages import (
    Answer,
    Ping,
    Pong,
    Request,
    decode_answer,
    encode_request,
)


@message()
class Answered:
    """A request and its answer; `answer.status` is the outcome."""

    request: Request
    answer: Answer


Event: TypeAlias = Answered | Stray | Unreadable


class Host:
    """The host's protocol machine. Raises `LocalProtocolError` if misused.

    The arm silently drops frames that it cannot parse, so the caller must call `forget` after a
    timeout.
    """

    def __init__(self) -> None:
        self._frames = FrameSplitter()
        self._request: Request | None = None
        self._sent_at = 0

    @property
    def outstanding(self) -> Request | None:
        """The unanswered request."""
        return self._request

    def send(self, request: Request) -> bytes:
        """Return a request's bytes.

        Raises `LocalProtocolError` while another is unanswered. Frames that began to arrive before
        this call are never taken for this request's answer.
        """
        if self._request is not None:
            raise LocalProtocolError(
                f"{self._request.op.name} is unanswered: wait for its Answered, or forget it, "
                f"before sending {request.op.name}"
            )
        data = encode_request(request)
        self._request, self._sent_at = request, self._frames.received
        return data

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the arm in any chunks."""
        self._frames.feed(data)

    def next_event(self) -> Event | None:
        """Return the next event from the bytes received so far, or None."""
        frame = self._frames.next_frame()
        if not isinstance(frame, SuperFrame):
            return frame
        try:
            answer = decode_answer(frame)
        except RemoteProtocolError as error:
            return Unreadable(frame.raw, str(error))
        return self._accept(frame, answer)

    def forget(self) -> None:
        """Stop waiting for the answer, after a timeout.

        The arm may or may not have executed it. A late answer is `Stray`, unless the next
        request has the same operation: then only a `Ping`, whose bytes differ, shows the
        difference. So send a `Ping` with unique bytes next: answers come in the order of the
        requests, so no late answer follows the answer to the `Ping`. Send `FLUSH` first, in case
        the arm waits for the rest of a corrupt frame.
        """
        self._request = None

    def silence(self) -> None:
        """Report that the line has been quiet for longer than any pause within a frame.

        The incomplete frame is abandoned, and its bytes are searched for other frames.
        """
        self._frames.silence()

    def discard(self) -> None:
        """Discard all received bytes and unread events; the unanswered request stays."""
        self._frames.discard()

    def _accept(self, frame: SuperFrame, answer: Answer) -> Event:
        request = self._request
        if request is None or frame.start < self._sent_at or not _answers(request, answer):
            return Stray(answer)
        self._request = None
        return Answered(request, answer)


def _answers(request: Request, answer: Answer) -> bool:
    if isinstance(request, Ping) and isinstance(answer, Pong):
        return answer.payload == request.payload
    return answer.op is request.op
