"""Frames of MKS drives and their host, described in words."""

from __future__ import annotations

from types import MappingProxyType

from armdrive.dialects.bus.words import (
    FrameCheck,
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
    NODE_MAX,
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
    as_setting,
    check_byte,
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


# The shortest frame: a code and a check byte.
LEAST_BYTES = 2


class MksFrameDescriber:
    """Describes frames one after the other, and remembers the questions among them."""

    def __init__(self) -> None:
        self._asked: dict[tuple[int, int], Request] = {}

    def describe(self, frame: Frame) -> FrameDescription:
        """Describe a frame. Never raises."""
        check = _check(frame)
        if check is not FrameCheck.RIGHT:
            return _described(frame, FrameKind.UNKNOWN, _why_not(frame, check), check)
        request, answer = self._read(frame)
        if answer is not None and (request is None or self._pending(frame) is not None):
            self._asked.pop((frame.can_id, frame.data[0]), None)
            return _described(frame, FrameKind.ANSWER, wording(answer, SENTENCES), check)
        if request is None:
            return _described(frame, FrameKind.UNKNOWN, _why_not(frame, check), check)
        self._note(frame, request)
        who = "all" if frame.can_id == BROADCAST else f"drive {frame.can_id}"
        words = addressed(who, wording(request, SENTENCES))
        return _described(frame, FrameKind.REQUEST, words, check)

    def _read(self, frame: Frame) -> tuple[Request | None, Answer | None]:
        answer = read_answer(frame, setting=isinstance(self._pending(frame), ReadSetting))
        return read_request(frame), answer if frame.can_id != BROADCAST else None

    def _pending(self, frame: Frame) -> Request | None:
        return self._asked.get((frame.can_id, frame.data[0]))

    def _note(self, frame: Frame, request: Request) -> None:
        code = request.setting if isinstance(request, ReadSetting) else request.code
        if frame.can_id != BROADCAST:
            self._asked[frame.can_id, code] = request


def _described(frame: Frame, kind: FrameKind, words: str, check: FrameCheck) -> FrameDescription:
    code = _code(frame)
    command = "" if code is None else code.name.lower()
    return FrameDescription(frame, kind, command, words, check, frame.can_id)


def _check(frame: Frame) -> FrameCheck:
    if frame.extended or frame.remote or frame.can_id > NODE_MAX or len(frame.data) < LEAST_BYTES:
        return FrameCheck.NONE
    right = frame.data[-1] == check_byte(frame.can_id, frame.data[:-1])
    return FrameCheck.RIGHT if right else FrameCheck.WRONG


def _code(frame: Frame) -> Code | None:
    try:
        return Code(frame.data[0]) if frame.data else None
    except ValueError:
        return None


def _why_not(frame: Frame, check: FrameCheck) -> str:
    code = _code(frame)
    if check is FrameCheck.NONE:
        kind = "remote" if frame.remote else "extended" if frame.extended else "short"
        return f"not of an MKS drive ({kind})"
    if check is FrameCheck.RIGHT:
        return "an unknown code" if code is None else f"{plain(code)} with an invalid payload"
    if code is None:
        return "not of an MKS drive"
    wanted = check_byte(frame.can_id, frame.data[:-1])
    return f"perhaps {plain(code)}, but its last byte would be {wanted:02X}"


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
