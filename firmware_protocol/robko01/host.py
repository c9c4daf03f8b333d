"""The host's end of the SUPER protocol: one request out, its answer in, no clock, no wire.

The host waits for nothing, or for the answer to one request. An answer belongs to the request
when it has its operation, began to come in after it was sent and, to a `Ping`, brings its bytes.
Any other answer is `Stray`; bytes that are no answer are `Garbled`. Neither changes the state,
and nothing that the arm sends raises.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.robko01.frames import Frame, Noise, Receiving
from firmware_protocol.robko01.messages import (
    Answer,
    Ping,
    Pong,
    Request,
    decode_answer,
    encode_request,
)


@dataclass(frozen=True, slots=True)
class Answered:
    """A request and its answer; `answer.status` says whether it was done."""

    request: Request
    answer: Answer


@dataclass(frozen=True, slots=True)
class Stray:
    """An answer that nobody waits for, for example the late one to a forgotten request."""

    answer: Answer


@dataclass(frozen=True, slots=True)
class Garbled:
    """Bytes that are no answer of this dialect, and why. Empty where entries were lost."""

    data: bytes
    reason: str


Event: TypeAlias = Answered | Stray | Garbled


class Host(Receiving):
    """The machine that speaks to the arm. Raises `LocalProtocolError` for its owner's mistakes.

    The arm drops what it does not understand in silence, so it is the owner, who has the clock,
    that ends the waiting (`forget`). The same machine serves a stream (`receive_data`) and
    datagrams, of which each is whole frames (`receive_datagram`).
    """

    def __init__(self, *, counts_check: bool = False) -> None:
        super().__init__(counts_check=counts_check)
        self._request: Request | None = None
        self._sent_at = 0

    @property
    def outstanding(self) -> Request | None:
        """The request whose answer has not come yet."""
        return self._request

    def send(self, request: Request) -> bytes:
        """Return the bytes that put a request to the arm.

        Raises `LocalProtocolError` while another is unanswered. Frames that had begun to come
        in before this call are never taken for this request's answer.
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
        """Return what the bytes received so far say, one event at a time, then None."""
        frame = self._frames.next_frame()
        if frame is None:
            return None
        if isinstance(frame, Noise):
            return Garbled(frame.data, frame.reason)
        try:
            answer = decode_answer(frame)
        except RemoteProtocolError as error:
            return Garbled(frame.raw, str(error))
        return self._accept(frame, answer)

    def forget(self) -> Request | None:
        """Wait no longer for an answer, after a timeout, and return the request.

        Whether the arm has done it is unknown. A late answer is `Stray`, unless the next
        request has the same operation: then nothing in the answer tells them apart, but for
        `Ping`, whose bytes do. So make the next request a `Ping` with bytes of its own: answers
        come in the order of the requests, and behind its answer no late one follows. Send
        `FLUSH` before it, in case the arm waits for the rest of a spoilt frame.
        """
        request, self._request = self._request, None
        return request

    def discard(self) -> None:
        """Forget all bytes received and all events not fetched; the next byte begins anew.

        The unanswered request stays unanswered.
        """
        self._frames.discard()

    def _accept(self, frame: Frame, answer: Answer) -> Event:
        request = self._request
        if request is None or frame.start < self._sent_at or not _answers(request, answer):
            return Stray(answer)
        self._request = None
        return Answered(request, answer)


def _answers(request: Request, answer: Answer) -> bool:
    if isinstance(request, Ping) and isinstance(answer, Pong):
        return answer.payload == request.payload
    return answer.op is request.op
