"""What drives on a CAN bus say, as messages of a recording: packed frames, and what they mean."""

from __future__ import annotations

from collections.abc import Callable

from armdrive.recorder.weighing import Message, Weight
from armdrive.wording import wording
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks import MOTION_CODES, SETTING_CODES, Code
from firmware_protocol.mks.wire import decode_answer, decode_request

_OF_ITSELF = frozenset({*SETTING_CODES, Code.VERSION})
_PASSING = frozenset({*MOTION_CODES, Code.ENCODER, Code.RAW_ENCODER, Code.SPEED, Code.ANGLE_ERROR})
"""Encoders tremble, and ends of motions are told or not: where drives rest is what has to agree."""


class PackedFrames:
    """Messages that are packed frames."""

    def __init__(self) -> None:
        self._unpacker = Unpacker()

    def feed(self, data: bytes) -> list[Message]:
        """Take bytes; return the frames that are whole."""
        return [_message(frame) for frame in self._unpacker.feed(data)]


def _message(frame: Frame) -> Message:
    data, code = pack(frame), frame.data[:1]
    if code and code[0] in _OF_ITSELF:
        return Message(data, Weight.SELF)
    if code and code[0] in _PASSING:
        return Message(data, Weight.PASSING)
    return Message(data, Weight.MOMENT, code)


def heard(data: bytes) -> object:
    """Return what one answer means. Raises `RemoteProtocolError`."""
    return _words(data, _answer)


def sent(data: bytes) -> object:
    """Return what frames of the host mean. Raises `RemoteProtocolError`."""
    return _words(data, decode_request)


def shown(data: bytes) -> str:
    """Write frames as `candump` does."""
    return " ".join(map(str, Unpacker().feed(data)))


def _words(data: bytes, read: Callable[[Frame], object]) -> str:
    """Return what frames mean; drives that are told the same stand together."""
    told: dict[str, list[str]] = {}
    for frame in Unpacker().feed(data):
        told.setdefault(wording(read(frame)), []).append(str(frame.can_id))
    if not told:
        raise RemoteProtocolError("no frame")
    return "; ".join(f"{' '.join(drives)}: {words}" for words, drives in told.items())


def _answer(frame: Frame) -> object:
    """Read an answer: the value of a setting looks like the answer to setting it."""
    try:
        return decode_answer(frame)
    except RemoteProtocolError:
        return decode_answer(frame, setting=True)
