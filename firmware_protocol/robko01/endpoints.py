"""Both ends of the SUPER protocol: requests from the host, answers from the arm. No clock, no I/O.

At most one request is unanswered, and no input from the other end raises.
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
    decode_request,
    encode_answer,
    encode_request,
)


class Endpoint:
    """The common part of both ends: the received frames, and the request without an answer."""

    def __init__(self, *, counts_check: bool = False) -> None:
        self._counts_check = counts_check
        self._frames = FrameSplitter(counts_check=counts_check)
        self._request: Request | None = None

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the other end in any chunks."""
        self._frames.feed(data)

    def silence(self) -> None:
        """Report that the line has been quiet for longer than any pause within a frame.

        The incomplete frame is abandoned, and its bytes are searched for other frames. A host calls
        this before `forget`; the firmware has nothing like it.
        """
        self._frames.silence()

    def forget(self) -> Request | None:
        """Drop the unanswered request and return it."""
        request, self._request = self._request, None
        return request

    def discard(self) -> None:
        """Discard all received bytes and unread events; the unanswered request stays."""
        self._frames.discard()


# The host's end. An answer matches if it has the request's operation, began to arrive after the
# request was sent and, for a `Ping`, returns its bytes. Any other answer is `Stray`; bytes that are
# not an answer are `Unreadable`. Neither changes the state.


@message()
class Answered:
    """A request and its answer; `answer.status` is the outcome."""

    request: Request
    answer: Answer


Event: TypeAlias = Answered | Stray | Unreadable


class Host(Endpoint):
    """The host's protocol machine. Raises `LocalProtocolError` if misused.

    The arm silently drops frames that it cannot parse, so the caller must call `forget` after a
    timeout.
    """

    def __init__(self, *, counts_check: bool = False) -> None:
        super().__init__(counts_check=counts_check)
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
        data = encode_request(request, counts_check=self._counts_check)
        self._request, self._sent_at = request, self._frames.received
        return data

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

    def forget(self) -> Request | None:
        """Stop waiting for the answer, after a timeout, and return the request.

        The arm may or may not have executed it. A late answer is `Stray`, unless the next
        request has the same operation: then only a `Ping`, whose bytes differ, shows the
        difference. So send a `Ping` with unique bytes next: answers come in the order of the
        requests, so no late answer follows the answer to the `Ping`. Send `FLUSH` first, in case
        the arm waits for the rest of a corrupt frame.
        """
        return super().forget()

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


# The arm's end, which handles one request at a time. The owner sends the answer or drops the
# request (`forget`), as the firmware does with unimplemented operations.

DeviceEvent: TypeAlias = Request | Unreadable
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
        if not isinstance(frame, SuperFrame):
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
