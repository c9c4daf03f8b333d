"""One frame of a CAN bus in words, whatever its drives speak: for whoever listens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from armdrive.dialects.words import Message, Sentences, wording
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, Unpacker


class FrameKind(Enum):
    """What a frame is taken for."""

    REQUEST = "request"
    ANSWER = "answer"
    """Of CANopen also what a node says unasked."""
    UNKNOWN = "unknown"


class FrameCheck(Enum):
    """How its last byte is."""

    RIGHT = "right"
    WRONG = "wrong"
    NONE = "none"
    """The frame is no drive's, too short for one, or of a protocol that has none."""


@dataclass(frozen=True, slots=True)
class FrameSaid:
    """One frame in words.

    `command` is the name of the code or of the service, empty where none has the number. `node` is
    the drive that it is about, 0 where that is all of them or none.
    """

    frame: Frame
    kind: FrameKind
    command: str
    words: str
    check: FrameCheck
    node: int

    @property
    def foreign(self) -> bool:
        """Whether it is not a readable frame of this protocol."""
        return self.kind is FrameKind.UNKNOWN

    def view(self, time_s: float) -> dict[str, object]:
        """Return it as plain data."""
        return {
            "time_s": round(time_s, 6),
            "id": self.frame.can_id,
            "node": self.node,
            "frame": str(self.frame),
            "kind": self.kind.value,
            "command": self.command,
            "words": self.words,
            "check": self.check.value,
        }

    def line(self, time_s: float) -> str:
        """Return it as a line for people."""
        arrow = {FrameKind.REQUEST: ">", FrameKind.ANSWER: "<", FrameKind.UNKNOWN: "?"}[self.kind]
        check = "  CHECK BYTE WRONG" if self.check is FrameCheck.WRONG and self.command else ""
        return f"{time_s:9.3f}  {self.frame!s:<21} {arrow} {self.words}{check}"


class Ear(Protocol):
    """Hears frames in their order, and knows what was asked."""

    def hear(self, frame: Frame) -> FrameSaid:
        """Put a frame into words. Never raises."""


# Frames of a CAN bus as messages of a recording: cut out of bytes, written, put into words.


class PackedFrames:
    """Messages that are packed frames."""

    def __init__(self, weigh: Callable[[Frame], Message]) -> None:
        self._unpacker = Unpacker()
        self._weigh = weigh

    def feed(self, data: bytes) -> list[Message]:
        """Take bytes; return the frames that are whole."""
        return [self._weigh(frame) for frame in self._unpacker.feed(data)]


def shown(data: bytes) -> str:
    """Write frames as `candump` does."""
    return " ".join(map(str, Unpacker().feed(data)))


def words(data: bytes, read: Callable[[Frame], tuple[str, object]], sentences: Sentences) -> str:
    """Return what frames mean; those that are told the same, or say it, stand together.

    `read` gives whom a frame is about, and its message, which is worded by the dialect's own
    `sentences`. Raises `RemoteProtocolError`.
    """
    told: dict[str, list[str]] = {}
    for frame in Unpacker().feed(data):
        who, message = read(frame)
        told.setdefault(wording(message, sentences), []).append(who)
    if not told:
        raise RemoteProtocolError("no frame")
    return "; ".join(_said(" ".join(filter(None, who)), words) for words, who in told.items())


def _said(who: str, words: str) -> str:
    return f"{who}: {words}" if who else words
