"""The board's end of the Armdroid dialect: characters in, answers out, no clock, no wire.

One command at a time: after a command's event its answer is owed, and what comes in meanwhile
waits, as it does in the board during a motion. Nothing that the host sends raises.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.armdroid.answers import ANSWER_TO, Answer, Welcome
from firmware_protocol.armdroid.characters import MEANT, Characters
from firmware_protocol.armdroid.commands import Request
from firmware_protocol.armdroid.wire import encode_answer
from firmware_protocol.errors import LocalProtocolError

ROOM_BYTES = 4096
"""How many received characters wait at most; an AVR board with a hardware port has room for 64."""


@dataclass(frozen=True, slots=True)
class Ignored:
    """A character that the sketch does nothing with, CR and LF among them."""

    byte: int


@dataclass(frozen=True, slots=True)
class Overrun:
    """So many characters came while there was no room for them; they are lost."""

    count: int


DeviceEvent: TypeAlias = Request | Ignored | Overrun


class Device:
    """The machine that a simulated arm speaks with. Raises `LocalProtocolError` for its owner.

    A `Clear` or `DropArguments` of the host is seen as what the board makes of it: a `DriveOne`
    of 0 steps or a `DriveNone`. The same holds for other dialects' texts: the `D` in `@READ` is
    a `DriveAll` by the arguments that were kept.
    """

    def __init__(self, room_bytes: int = ROOM_BYTES) -> None:
        self._characters = Characters()
        self._waiting = bytearray()
        self._room_bytes = room_bytes
        self._lost = 0
        self._request: Request | None = None

    @property
    def unanswered(self) -> Request | None:
        """What still needs an answer."""
        return self._request

    @property
    def buffered(self) -> int:
        """How many received characters wait."""
        return len(self._waiting)

    @property
    def arguments(self) -> tuple[int, ...]:
        """The five kept arguments, as `ReportArguments` asks for them."""
        return self._characters.arguments

    @property
    def accumulator(self) -> int:
        """The number that is being received, as `ReportArguments` asks for it."""
        return self._characters.accumulator

    @property
    def clean(self) -> bool:
        """Whether nothing is half received: the next command means what it says."""
        return self._characters.clean

    def receive_data(self, data: bytes) -> None:
        """Take characters from the host, in any portions. What finds no room is lost."""
        room = 0 if self._lost else self._room_bytes - len(self._waiting)
        self._waiting += data[:room]
        self._lost += max(len(data) - room, 0)

    def next_event(self) -> DeviceEvent | None:
        """Return what the next characters say, or None while there are none or an answer is owed.

        `Overrun` stands where the lost characters stood.
        """
        if self._request is not None:
            return None
        used, event = self._read()
        del self._waiting[:used]
        if event is None and self._lost:
            event, self._lost = Overrun(self._lost), 0
        return event

    def send(self, answer: Answer | Welcome) -> bytes:
        """Return the bytes of an answer.

        Raises `LocalProtocolError` where it is not the one that is owed. `Welcome` belongs to no
        command: it begins a session, in which everything half received is forgotten.
        """
        if isinstance(answer, Welcome):
            self._welcome()
            return encode_answer(answer)
        form = None if self._request is None else ANSWER_TO[self._request.letter]
        if form is None or not isinstance(answer, form):
            owed = f"a {form.__name__} is owed" if form else "nothing is owed"
            raise LocalProtocolError(f"{owed}, so a {type(answer).__name__} cannot be sent")
        self._request = None
        return encode_answer(answer)

    def forget(self) -> Request | None:
        """Start anew, as after a loss of power, and return what was unanswered."""
        request, self._request = self._request, None
        self._characters.reset()
        self._waiting.clear()
        self._lost = 0
        return request

    def _read(self) -> tuple[int, DeviceEvent | None]:
        """Take waiting characters up to the first that says something; return how many."""
        for at, byte in enumerate(self._waiting):
            if byte not in MEANT:
                return at + 1, Ignored(byte)
            request = self._characters.take(byte)
            if request is not None:
                self._request = request
                return at + 1, request
        return len(self._waiting), None

    def _welcome(self) -> None:
        if self._request is not None:
            raise LocalProtocolError("an answer is owed: a board says Welcome between commands")
        self._characters.reset()
