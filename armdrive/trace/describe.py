"""Bytes of the wire as messages: where each ends, how it is compared, and what it says in words.

One row a dialect. A real board has a version, settings and a moment of its own, so that not all
of what it says can be compared with what a simulated one says.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from armdrive.dialects.armdroid import words as armdroid
from armdrive.dialects.bus import words as messages_can
from armdrive.dialects.cia402 import frames as messages_canopen
from armdrive.dialects.grbl import words as grbl
from armdrive.dialects.mks import frames as messages_mks
from armdrive.dialects.teachmover.controller import FIRST_LINE
from armdrive.dialects.words import Message, Splitter, Weight
from armdrive.tasks import Alert, Event, MoveAlong, MoveBy, Oddity, Registers, Request, Silence
from armdrive.trace.entries import Kind
from armdrive.trace.sentences import wording
from firmware_protocol import robko01
from firmware_protocol.armdroid.wire import decode_answer as armdroid_answer
from firmware_protocol.errors import ProtocolError, RemoteProtocolError
from firmware_protocol.grbl.reports import decode_answer as grbl_answer
from firmware_protocol.lines import LineSplitter
from firmware_protocol.robko01.frames import Frame, FrameSplitter, Noise
from firmware_protocol.robko01.wire import decode_answer as robko01_answer
from firmware_protocol.robko01.wire import decode_request as robko01_request
from firmware_protocol.teachmover.wire import decode_command, decode_reply

LONGEST_LINE = 4096
MOST_LINES = 65536


class Lines:
    """Messages that are lines."""

    def __init__(self, ends: bytes, weigh: Callable[[bytes], Message]) -> None:
        self._lines = LineSplitter(ends, max_length=LONGEST_LINE, max_lines=MOST_LINES)
        self._weigh = weigh

    def feed(self, data: bytes) -> list[Message]:
        """Take bytes; return the lines that have ended."""
        self._lines.feed(data)
        found = []
        while (line := self._lines.next_line()) is not None:
            data = line if isinstance(line, bytes) else line.start
            if data.strip():
                found.append(self._weigh(data.strip()))
        return found


class Frames:
    """Messages that are frames of the SUPER protocol, or noise."""

    def __init__(self) -> None:
        self._frames = FrameSplitter()

    def feed(self, data: bytes) -> list[Message]:
        """Take bytes; return the frames that are whole."""
        self._frames.feed(data)
        found = []
        while (frame := self._frames.next_frame()) is not None:
            found.append(_robko01_message(frame))
        return found


def _robko01_message(frame: Frame | Noise) -> Message:
    if isinstance(frame, Noise):
        return Message(frame.data, Weight.ANSWER)
    if frame.op in (robko01.Op.GET_ROBOT_ID, robko01.Op.SET_ROBOT_ID):
        return Message(frame.raw, Weight.SELF)
    return Message(frame.raw, Weight.MOMENT, bytes((frame.op,)))


def _answer(line: bytes) -> Message:
    return Message(line, Weight.ANSWER)


def _armdroid_message(line: bytes) -> Message:
    if line.startswith(b"Welcome"):
        return Message(line, Weight.BANNER)
    own = line.startswith((b"firmware", b"version", b"interface"))
    return Message(line, Weight.SELF if own else Weight.ANSWER)


def _grbl_message(line: bytes) -> Message:
    if line.startswith(b"<"):
        return Message(line, Weight.PASSING)
    if line.lower().startswith(b"grbl"):
        return Message(line, Weight.BANNER)
    own = line.startswith((b"[", b"$", b">"))
    return Message(line, Weight.SELF if own else Weight.ANSWER)


# -- words ---------------------------------------------------------------------------------------


def _escaped(data: bytes) -> str:
    return data.decode("latin-1").encode("unicode_escape").decode("ascii")


def _hexadecimal(data: bytes) -> str:
    return data.hex(" ")


def _teachmover_request(data: bytes) -> object:
    if data == FIRST_LINE:
        return "moves nothing, and makes an Armdroid harmless that somebody took for a TeachMover"
    return decode_command(data.strip().lstrip(b"@"))


def _robko01_request(data: bytes) -> object:
    return robko01_request(_frame(data))


def _robko01_answer(data: bytes) -> object:
    return robko01_answer(_frame(data))


def _frame(data: bytes) -> Frame:
    """Return the frame at the end of some bytes; what stands before it flushes the reader."""
    splitter = FrameSplitter()
    splitter.feed(data)
    splitter.silence()
    found = None
    while (frame := splitter.next_frame()) is not None:
        found = frame if isinstance(frame, Frame) else found
    if found is None:
        raise RemoteProtocolError("no frame")
    return found


@dataclass(frozen=True, slots=True)
class Talk:
    """How one dialect is cut into messages and put into words.

    `sent` reads what a host writes at once, as a message or in words; `heard` reads one message;
    `shown` writes bytes for people. None where nothing is known of the dialect.
    """

    splitter: Callable[[], Splitter]
    heard: Callable[[bytes], object] | None
    sent: Callable[[bytes], object] | None = None
    shown: Callable[[bytes], str] = _escaped

    def said(self, data: bytes) -> str:
        """Return one message for people, with its meaning where its bytes do not show it."""
        words = "" if self.shown is _escaped else self.words(data, self.heard)
        return f"{self.shown(data)} ({words})" if words else self.shown(data)

    def words(self, data: bytes, read: Callable[[bytes], object] | None) -> str:
        """Return what bytes mean; nothing where that is not known."""
        try:
            return "" if read is None else wording(read(data))
        except ProtocolError:
            return "unreadable"


TALKS: Mapping[str, Talk] = MappingProxyType(
    {
        "teachmover": Talk(lambda: Lines(b"\r\n", _answer), decode_reply, _teachmover_request),
        "robko01": Talk(Frames, _robko01_answer, _robko01_request, _hexadecimal),
        "armdroid": Talk(
            lambda: Lines(b"\r\n", _armdroid_message), armdroid_answer, armdroid.commands
        ),
        "grbl": Talk(lambda: Lines(b"\r\n", _grbl_message), grbl_answer, grbl.lines),
        "mks": Talk(
            lambda: messages_can.PackedFrames(messages_mks.weighed),
            messages_mks.heard,
            messages_mks.sent,
            messages_can.shown,
        ),
        "cia402": Talk(
            lambda: messages_can.PackedFrames(messages_canopen.weighed),
            messages_canopen.words,
            messages_canopen.words,
            messages_can.shown,
        ),
    }
)
"""Every dialect whose recordings can be read and compared."""
_PLAIN = Talk(lambda: Lines(b"\r\n", _answer), None)


def talk(dialect: str) -> Talk:
    """Return a dialect's row; of an unknown one, lines without words."""
    return TALKS.get(dialect, _PLAIN)


# Requests, answers, calls and errors in the words that a recording keeps.


def request_words(request: Request) -> str:
    """Return a request in words; what is a program of its own is left out."""
    if isinstance(request, MoveBy):
        return f"MoveBy({_counts(request.steps)}; {request.rate_hz:g} steps/s)"
    if isinstance(request, MoveAlong):
        return f"MoveAlong({'jogging, ' if request.jog else ''}{request.ahead_s:g} s ahead)"
    return repr(request)


def event_words(event: Event) -> tuple[Kind, str]:
    """Return the kind of an answer or an alert, and its words; counts of motors come first."""
    if isinstance(event, Registers):
        return Kind.REGISTERS, f"{_counts(event.positions)}; {event}"
    if isinstance(event, Alert):
        return Kind.ALERT, f"{event.kind.value}: {event.text}"
    if isinstance(event, Oddity):
        return Kind.ODDITY, event.text
    return Kind.SILENCE if isinstance(event, Silence) else Kind.REPLY, str(event)


def call_words(name: str, words: tuple[Any, ...], named: Mapping[str, Any]) -> str:
    """Return a call as it would be written."""
    shown = [repr(word) for word in words]
    shown += [f"{key}={value!r}" for key, value in named.items()]
    return f"{name}({', '.join(shown)})"


def error_words(error: BaseException) -> str:
    """Return an error in words."""
    return f"{type(error).__name__}: {error}"


def _counts(counts: tuple[int, ...]) -> str:
    return " ".join(map(str, counts))
