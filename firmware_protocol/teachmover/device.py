"""The arm's end of the TeachMover dialect: commands in, answers out, no clock, no I/O.

The device handles one command at a time. The outstanding answer is one of four states:

    NOTHING    --command-->            STATUS
    STATUS     --status-->             NOTHING
    STATUS     --DONE to READ-->       REGISTERS   --registers-->     NOTHING
    STATUS     --DONE to QDUMP-->      ROWS        --next command-->  STATUS

In ROWS any number of program rows may be sent, and the next command may be fetched. No input from
the host raises.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.events import Unreadable
from firmware_protocol.lines import LineSplitter
from firmware_protocol.teachmover.messages import (
    AFTER_DONE,
    ATTENTION,
    CR,
    FORMS,
    NOISE,
    Arm,
    Command,
    Due,
    Registers,
    Reply,
    Status,
    decode_command,
    encode_reply,
)


@dataclass(frozen=True, slots=True)
class Ignored:
    """A line without the attention character; it gets no answer."""

    data: bytes


Request: TypeAlias = Command | Unreadable | Ignored
"""`Unreadable` is a line to this device that is no command: answer it with `Status.FAILED`."""


class Device:
    """The protocol machine of a simulated arm. Raises `LocalProtocolError` if misused.

    It is unverified that a real arm ignores lines without its attention character.
    """

    def __init__(self) -> None:
        self._attention = ATTENTION
        self._lines = LineSplitter(CR)
        self._owes = Due.NOTHING
        self._request: Command | Unreadable | None = None

    @property
    def attention(self) -> str:
        """The character that commands currently start with."""
        return self._attention

    @property
    def unanswered(self) -> Command | Unreadable | None:
        """The command that still needs an answer."""
        return self._request

    @property
    def buffered(self) -> int:
        """Number of buffered bytes."""
        return self._lines.buffered

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the host in any chunks."""
        self._lines.feed(data)

    def next_event(self) -> Request | None:
        """Return the next event; None if there is none or an answer is outstanding.

        Lines that arrive before the answer are queued, so that an `Arm` applies to the lines after
        it. To simulate a device that ignores input during a motion, call `discard` at its end.
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
        """Return the bytes of an answer, or of its next part.

        READ is answered with a status and, after DONE, `Registers`; QDUMP with a status and,
        after DONE, any number of rows; everything else with a status only. Raises
        `LocalProtocolError` for other answers. DONE to an `Arm` changes the attention character.
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

    def forget(self) -> Command | Unreadable | None:
        """Drop the unanswered command, as after a loss of power, and return it."""
        request = self._request
        self._owes, self._request = Due.NOTHING, None
        return request

    def discard(self) -> None:
        """Discard the received bytes; the outstanding answer stays outstanding."""
        self._lines.discard()

    def _read(self, line: bytes | Unreadable) -> Request:
        data = line.data if isinstance(line, Unreadable) else line
        body = data.lstrip(NOISE)
        if not body.startswith(self._attention.encode("ascii")):
            return Ignored(data)
        if isinstance(line, Unreadable):
            return line
        try:
            return decode_command(body[1:])
        except RemoteProtocolError as error:
            return Unreadable(line, str(error))

    def _answer(self, status: Status) -> None:
        request = self.forget()
        if status is not Status.DONE or request is None or isinstance(request, Unreadable):
            return
        if isinstance(request, Arm):
            self._attention = request.attention
        self._owes = AFTER_DONE.get(type(request), Due.NOTHING)
        if self._owes is Due.REGISTERS:
            self._request = request
