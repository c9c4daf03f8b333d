"""One frame of a CAN bus described in words, for any protocol."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from armdrive.dialects.words import Message, Sentences, wording
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, Unpacker


class FrameKind(Enum):
    """The kinds of frames."""

    REQUEST = "request"
    ANSWER = "answer"
    """Including what a CANopen node sends without being asked."""
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class FrameDescription:
    """One frame described in words.

    `command` is the name of its code or service, empty if it is unknown. `node` is the drive it
    concerns, 0 for all or none.
    """

    frame: Frame
    kind: FrameKind
    command: str
    words: str
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
        }

    def line(self, time_s: float) -> str:
        """Return it as a line of text."""
        arrow = {FrameKind.REQUEST: ">", FrameKind.ANSWER: "<", FrameKind.UNKNOWN: "?"}[self.kind]
        return f"{time_s:9.3f}  {self.frame!s:<21} {arrow} {self.words}"


class FrameDescriber(Protocol):
    """Describes frames one after the other, and remembers the questions among them."""

    def describe(self, frame: Frame) -> FrameDescription:
        """Describe a frame. Never raises."""


# Frames as messages of a recording.


class PackedFrames:
    """Messages that are packed frames."""

    def __init__(self, weigh: Callable[[Frame], Message]) -> None:
        self._unpacker = Unpacker()
        self._weigh = weigh

    def feed(self, data: bytes) -> list[Message]:
        """Return the complete frames in some bytes."""
        return [self._weigh(frame) for frame in self._unpacker.feed(data)]


def shown(data: bytes) -> str:
    """Return frames in the notation of `candump`."""
    return " ".join(map(str, Unpacker().feed(data)))


def words(data: bytes, read: Callable[[Frame], tuple[str, object]], sentences: Sentences) -> str:
    """Return what frames mean, grouped by meaning: `1 2 3: the motor is on`.

    `read` returns the node that a frame concerns and its message, which is worded by the dialect's
    `sentences`. Raises `RemoteProtocolError`.
    """
    nodes: dict[str, list[str]] = {}
    for frame in Unpacker().feed(data):
        node, message = read(frame)
        nodes.setdefault(wording(message, sentences), []).append(node)
    if not nodes:
        raise RemoteProtocolError("no frame")
    return "; ".join(addressed(" ".join(filter(None, who)), each) for each, who in nodes.items())


def addressed(who: str, words: str) -> str:
    """Return words with the node that they concern in front, if there is one."""
    return f"{who}: {words}" if who else words
