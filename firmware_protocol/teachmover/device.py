"""The arm's end of the TeachMover dialect: commands in, answers out, no clock, no wire.

The device takes one command at a time. What it owes for the last one is one of four states:

    NOTHING    --command-->            STATUS
    STATUS     --status-->             NOTHING
    STATUS     --DONE to READ-->       REGISTERS   --registers-->     NOTHING
    STATUS     --DONE to QDUMP-->      ROWS        --next command-->  STATUS

In ROWS any number of program rows may be sent, and the next command may be fetched. Nothing that
the host sends raises.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.lines import Dropped, LineSplitter
from firmware_protocol.teachmover.messages import (
    AFTER_DONE,
    ATTENTION,
    FORMS,
    Arm,
    Command,
    Due,
    Registers,
    Reply,
    Status,
    attention_character,
)
from firmware_protocol.teachmover.wire import CR, NOISE, decode_command, encode_reply


@dataclass(frozen=True, slots=True)
class Malformed:
    """A line meant for this device that is no command. Answer it with `Status.FAILED`."""

    line: bytes
    reason: str


@dataclass(frozen=True, slots=True)
class Ignored:
    """A line that does not begin with the attention character; it gets no answer."""

    line: bytes


Request: TypeAlias = Command | Malformed | Ignored


class Device:
    """The machine that a simulated arm speaks with. Raises `LocalProtocolError` for its owner.

    That a real arm stays silent on lines without its attention character is unverified:
    `answers_strangers=True` makes such lines `Malformed`, to be answered.
    """

    def __init__(self, attention: str = ATTENTION, *, answers_strangers: bool = False) -> None:
        self._attention = attention_character(attention)
        self._answers_strangers = answers_strangers
        self._lines = LineSplitter(CR)
        self._owes = Due.NOTHING
        self._request: Command | Malformed | None = None

    @property
    def attention(self) -> str:
        """The character that commands start with now."""
        return self._attention

    @property
    def unanswered(self) -> Command | Malformed | None:
        """What still needs an answer."""
        return self._request

    @property
    def buffered(self) -> int:
        """How many received bytes are held."""
        return self._lines.buffered

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the host, in any portions."""
        self._lines.feed(data)

    def next_event(self) -> Request | None:
        """Return the next line's meaning, or None while there is none or an answer is owed.

        Lines that come in before the answer wait, so that an `Arm` holds for those behind it. A
        device that is deaf during a motion calls `discard` at its end.
        """
        if self._owes in (Due.STATUS, Due.REGISTERS):
            return None
        while (line := self._lines.next_line()) is not None:
            if isinstance(line, bytes) and not line.strip(NOISE):
                continue
            request = self._read(line)
            if not isinstance(request, Ignored):
                self._request, self._owes = request, Due.STATUS
            return request
        return None

    def send(self, reply: Reply) -> bytes:
        """Return the bytes of an answer, or of the next part of one.

        Raises `LocalProtocolError` where the dialect has no such answer: READ is answered with a
        status and, after DONE, with `Registers`; QDUMP with a status and, after DONE, with as
        many rows as there are; everything else with a status alone. The attention character
        changes when DONE answers an `Arm`.
        """
        form, _ = FORMS.get(self._owes, (None, ""))
        if form is None or not isinstance(reply, form):
            owed = f"a {form.__name__} is owed" if form else "nothing is owed"
            raise LocalProtocolError(f"{owed}, so a {type(reply).__name__} cannot be sent")
        if isinstance(reply, Status):
            self._answer(reply)
        elif isinstance(reply, Registers):
            self.forget()
        return encode_reply(reply)

    def forget(self) -> Command | Malformed | None:
        """Owe nothing any more, as after a loss of power, and return what was unanswered."""
        request = self._request
        self._owes, self._request = Due.NOTHING, None
        return request

    def discard(self) -> None:
        """Forget the bytes received; what is owed stays owed."""
        self._lines.discard()

    def _read(self, line: bytes | Dropped) -> Request:
        data = line.start if isinstance(line, Dropped) else line
        body = data.lstrip(NOISE)
        if not body.startswith(self._attention.encode("ascii")):
            return self._stranger(data)
        if isinstance(line, Dropped):
            return Malformed(data, line.reason)
        try:
            return decode_command(body[1:])
        except RemoteProtocolError as error:
            return Malformed(line, str(error))

    def _stranger(self, data: bytes) -> Request:
        if self._answers_strangers:
            return Malformed(data, f"the line does not begin with {self._attention}")
        return Ignored(data)

    def _answer(self, status: Status) -> None:
        request = self.forget()
        if status is not Status.DONE or request is None or isinstance(request, Malformed):
            return
        if isinstance(request, Arm):
            self._attention = request.attention
        self._owes = AFTER_DONE.get(type(request), Due.NOTHING)
        if self._owes is Due.REGISTERS:
            self._request = request
