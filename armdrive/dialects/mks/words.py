"""Frames of MKS drives and their host, described in words."""

from __future__ import annotations

from types import MappingProxyType

from armdrive.dialects.bus.words import (
    FrameDescription,
    FrameKind,
    PackedFrames,
    addressed,
    shown,
    words,
)
from armdrive.dialects.words import Describer, Message, Sentences, Weight, plain, wording
from firmware_protocol.errors import ProtocolError, RemoteProtocolError
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import (
    BROADCAST,
    MOTION_CODES,
    SETTING_CODES,
    Answer,
    ArmSynchronous,
    Code,
    Enable,
    EnabledRead,
    EncoderRead,
    MoveAbsoluteAxis,
    OtherMotion,
    RawEncoderRead,
    ReadSetting,
    Request,
    SettingRead,
    SetZero,
    StateRead,
    Status,
    answer_code,
    as_setting,
    decode_answer,
    decode_request,
)


def _setting(message: SettingRead) -> str:
    try:
        setting = as_setting(message)
    except ProtocolError:
        value = f"{(message.value or b'').hex(' ')}, which is invalid"
    else:
        value = "not reported" if setting is None else plain(setting).partition(": ")[2]
    return f"setting {plain(message.code)}: {value}"


SENTENCES: Sentences = MappingProxyType(
    {
        Status: lambda message: f"{plain(message.code)}: {message.outcome.value}",
        ReadSetting: lambda message: f"read setting {plain(message.setting)}",
        SettingRead: _setting,
        EncoderRead: lambda message: f"the encoder is at {message.counts}",
        RawEncoderRead: lambda message: f"the encoder's raw count is {message.counts}",
        StateRead: lambda message: f"the motor is: {plain(message.state)}",
        EnabledRead: lambda message: f"the motor is {'on' if message.on else 'off'}",
        Enable: lambda message: f"switch the motor {'on' if message.on else 'off'}",
        ArmSynchronous: lambda message: (
            "store moves for a common start" if message.on else "start moves at once"
        ),
        SetZero: lambda _: "count from here",
        MoveAbsoluteAxis: lambda message: (
            f"go to {message.counts} at {message.speed_rpm} rpm, acc {message.acc}"
        ),
        OtherMotion: lambda message: f"{plain(message.code)} {message.payload.hex(' ')}".rstrip(),
    }
)


# Describing the traffic on a bus, one frame at a time.
#
# A frame does not state whether it is a request or an answer. If its bytes could be either, it is
# the answer if a request with the same code came before, otherwise it is a request.


def read_request(frame: Frame) -> Request | None:
    """Decode a frame as a request; None if it is not one."""
    try:
        return decode_request(frame)
    except ProtocolError:
        return None


def read_answer(frame: Frame, *, setting: bool = False) -> Answer | None:
    """Decode a frame as an answer; None if it is not one."""
    try:
        return decode_answer(frame, setting=setting)
    except ProtocolError:
        return None


class MksFrameDescriber:
    """Describes frames one after the other, and remembers the questions among them."""

    def __init__(self) -> None:
        self._asked: dict[tuple[int, bytes], Request] = {}

    def describe(self, frame: Frame) -> FrameDescription:
        """Describe a frame. Never raises."""
        asked = self._asked.get((frame.can_id, frame.data[:1]))
        request: Request | None = None
        answer, why = None, ""
        try:
            request = decode_request(frame)
        except ProtocolError as error:
            why = str(error)
        if frame.can_id != BROADCAST:
            answer = read_answer(frame, setting=isinstance(asked, ReadSetting))
        if answer is not None and (request is None or asked is not None):
            self._asked.pop((frame.can_id, frame.data[:1]), None)
            return _described(frame, FrameKind.ANSWER, wording(answer, SENTENCES))
        if request is None:
            code = _code(frame)
            words = "not of an MKS drive" if code is None else f"perhaps {plain(code)}: {why}"
            return _described(frame, FrameKind.UNKNOWN, words)
        self._asked[frame.can_id, bytes((answer_code(request),))] = request
        who = "all" if frame.can_id == BROADCAST else f"drive {frame.can_id}"
        words = addressed(who, wording(request, SENTENCES))
        return _described(frame, FrameKind.REQUEST, words)


def _described(frame: Frame, kind: FrameKind, words: str) -> FrameDescription:
    code = _code(frame)
    command = "" if code is None else code.name.lower()
    return FrameDescription(frame, kind, command, words, frame.can_id)


def _code(frame: Frame) -> Code | None:
    try:
        return Code(frame.data[0]) if frame.data else None
    except ValueError:
        return None


# Frames as messages of a recording, and how each is compared.

_OF_ITSELF = frozenset({*SETTING_CODES, Code.VERSION})
# Encoders tremble, and ends of motions may go unreported: only rest positions have to agree.
_PASSING = frozenset({*MOTION_CODES, Code.ENCODER, Code.RAW_ENCODER, Code.ANGLE_ERROR})


def as_message(frame: Frame) -> Message:
    """Return a frame as a message, compared by its code."""
    data, code = pack(frame), frame.data[:1]
    if code and code[0] in _OF_ITSELF:
        return Message(data, Weight.SELF)
    if code and code[0] in _PASSING:
        return Message(data, Weight.PASSING)
    return Message(data, Weight.MOMENT, code)


def answer_words(data: bytes) -> object:
    """Return what answers mean. Raises `RemoteProtocolError`."""
    return words(data, lambda frame: (str(frame.can_id), _answer(frame)), SENTENCES)


def request_words(data: bytes) -> object:
    """Return what frames of the host mean. Raises `RemoteProtocolError`."""
    return words(data, lambda frame: (str(frame.can_id), decode_request(frame)), SENTENCES)


def _answer(frame: Frame) -> object:
    """Decode an answer; the value of a setting looks like the answer to setting it."""
    try:
        return decode_answer(frame)
    except RemoteProtocolError:
        return decode_answer(frame, setting=True)


TALK = Describer(lambda: PackedFrames(as_message), answer_words, request_words, shown, SENTENCES)
