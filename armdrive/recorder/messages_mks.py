"""What MKS drives on a CAN bus say, as messages of a recording: how each is weighed and read."""

from __future__ import annotations

from armdrive.recorder import messages_can
from armdrive.recorder.weighing import Message, Weight
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import MOTION_CODES, SETTING_CODES, Code
from firmware_protocol.mks.wire import decode_answer, decode_request

_OF_ITSELF = frozenset({*SETTING_CODES, Code.VERSION})
_PASSING = frozenset({*MOTION_CODES, Code.ENCODER, Code.RAW_ENCODER, Code.SPEED, Code.ANGLE_ERROR})
"""Encoders tremble, and ends of motions are told or not: where drives rest is what has to agree."""


def weighed(frame: Frame) -> Message:
    """Return a frame as a message, by its code."""
    data, code = pack(frame), frame.data[:1]
    if code and code[0] in _OF_ITSELF:
        return Message(data, Weight.SELF)
    if code and code[0] in _PASSING:
        return Message(data, Weight.PASSING)
    return Message(data, Weight.MOMENT, code)


def heard(data: bytes) -> object:
    """Return what answers mean. Raises `RemoteProtocolError`."""
    return messages_can.words(data, lambda frame: (str(frame.can_id), _answer(frame)))


def sent(data: bytes) -> object:
    """Return what frames of the host mean. Raises `RemoteProtocolError`."""
    return messages_can.words(data, lambda frame: (str(frame.can_id), decode_request(frame)))


def _answer(frame: Frame) -> object:
    """Read an answer: the value of a setting looks like the answer to setting it."""
    try:
        return decode_answer(frame)
    except RemoteProtocolError:
        return decode_answer(frame, setting=True)
