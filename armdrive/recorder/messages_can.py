"""Frames of a CAN bus as messages of a recording: cut out of bytes, written, put into words."""

from __future__ import annotations

from collections.abc import Callable

from armdrive.recorder.weighing import Message
from armdrive.wording import wording
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, Unpacker


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


def words(data: bytes, read: Callable[[Frame], tuple[str, object]]) -> str:
    """Return what frames mean; those that are told the same, or say it, stand together.

    `read` gives whom a frame is about, and its message. Raises `RemoteProtocolError`.
    """
    told: dict[str, list[str]] = {}
    for frame in Unpacker().feed(data):
        who, message = read(frame)
        told.setdefault(wording(message), []).append(who)
    if not told:
        raise RemoteProtocolError("no frame")
    return "; ".join(_said(" ".join(filter(None, who)), words) for words, who in told.items())


def _said(who: str, words: str) -> str:
    return f"{who}: {words}" if who else words
