"""What MKS drives on a CAN bus and their host say, in words."""

from __future__ import annotations

import re
from dataclasses import fields
from enum import Enum
from types import MappingProxyType
from typing import Any

from armdrive.dialects.bus.words import FrameCheck, FrameKind, FrameSaid, PackedFrames, shown, words
from armdrive.dialects.words import Describer, Message, Sentences, Weight, plain
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
    GoSynchronous,
    MoveAbsoluteAxis,
    MoveAbsolutePulses,
    MoveRelativeAxis,
    MoveRelativePulses,
    RawEncoderRead,
    ReadSetting,
    Request,
    RunAtSpeed,
    RunFor,
    SettingRead,
    SetZero,
    StateRead,
    Status,
    as_setting,
    check_byte,
    decode_answer,
    decode_request,
)


def _pace(message: Any) -> str:
    return f"at {message.speed_rpm} rpm, acc {message.acc}"


def _status(message: Status) -> str:
    about = "" if message.reading is None else f" of {plain(message.reading)}"
    return f"{plain(message.code)}{about}: {plain(message.outcome)}"


SENTENCES: Sentences = MappingProxyType(
    {
        Status: _status,
        EncoderRead: lambda message: f"the encoder is at {message.counts}",
        RawEncoderRead: lambda message: f"the encoder's raw count is {message.counts}",
        StateRead: lambda message: f"the motor is: {plain(message.state)}",
        EnabledRead: lambda message: f"the motor is {'on' if message.on else 'off'}",
        Enable: lambda message: f"switch the motor {'on' if message.on else 'off'}",
        ArmSynchronous: lambda message: (
            "keep moves for a common start" if message.on else "start moves at once"
        ),
        GoSynchronous: lambda _: "start the moves that were kept",
        SetZero: lambda _: "count from here",
        MoveAbsoluteAxis: lambda message: f"go to {message.counts} {_pace(message)}",
        MoveRelativeAxis: lambda message: f"go by {message.counts:+d} {_pace(message)}",
        MoveAbsolutePulses: lambda message: f"go to pulse {message.pulses} {_pace(message)}",
        MoveRelativePulses: lambda message: f"go by {message.pulses:+d} pulses {_pace(message)}",
        RunAtSpeed: lambda message: f"turn without end {_pace(message)}",
        RunFor: lambda message: f"turn for {message.duration_ms} ms {_pace(message)}",
    }
)


# What passes on a bus of MKS drives, in words: one frame at a time, for whoever listens.
#
# A frame does not say whether it is a request or its answer. Where its bytes could be either, it
# is an answer to a request of the same code that was heard before, and else a request.


def read_request(frame: Frame) -> Request | None:
    """Return the request that a frame can be read as; None where it is none."""
    try:
        return decode_request(frame)
    except ProtocolError:
        return None


def read_answer(frame: Frame, *, setting: bool = False) -> Answer | None:
    """Return the answer that a frame can be read as; None where it is none."""
    try:
        return decode_answer(frame, setting=setting)
    except ProtocolError:
        return None


LEAST_BYTES = 2
"""Of a frame of this dialect: a code and a check byte."""


class MksEar:
    """Hears frames in their order, and knows what was asked."""

    def __init__(self) -> None:
        self._asked: dict[tuple[int, int], Request] = {}

    def hear(self, frame: Frame) -> FrameSaid:
        """Put a frame into words. Never raises."""
        check = _check(frame)
        if check is not FrameCheck.RIGHT:
            return _said(frame, FrameKind.UNKNOWN, _why_not(frame, check), check)
        request, answer = self._read(frame)
        if answer is not None and (request is None or self._pending(frame) is not None):
            self._asked.pop((frame.can_id, frame.data[0]), None)
            return _said(frame, FrameKind.ANSWER, answer_words(answer), check)
        if request is None:
            return _said(frame, FrameKind.UNKNOWN, _why_not(frame, check), check)
        self._note(frame, request)
        return _said(frame, FrameKind.REQUEST, request_words(frame, request), check)

    def _read(self, frame: Frame) -> tuple[Request | None, Answer | None]:
        answer = read_answer(frame, setting=isinstance(self._pending(frame), ReadSetting))
        return read_request(frame), answer if frame.can_id != BROADCAST else None

    def _pending(self, frame: Frame) -> Request | None:
        return self._asked.get((frame.can_id, frame.data[0]))

    def _note(self, frame: Frame, request: Request) -> None:
        code = request.setting if isinstance(request, ReadSetting) else request.code
        if frame.can_id != BROADCAST:
            self._asked[frame.can_id, code] = request


def _said(frame: Frame, kind: FrameKind, words: str, check: FrameCheck) -> FrameSaid:
    return FrameSaid(frame, kind, _name(frame), words, check, frame.can_id)


def request_words(frame: Frame, request: Request) -> str:
    """Return a request in words."""
    who = "all" if frame.can_id == BROADCAST else f"drive {frame.can_id}"
    if isinstance(request, ReadSetting):
        return f"{who}: read setting {_plain(request.setting.name)}"
    return f"{who}: {_of_class(request)}"


def answer_words(answer: Answer) -> str:
    """Return an answer in words."""
    if isinstance(answer, Status):
        about = f" of {_plain(answer.reading.name)}" if answer.reading is not None else ""
        return f"{_plain(answer.code.name)}{about}: {answer.outcome.value}"
    if isinstance(answer, SettingRead):
        return f"setting {_plain(answer.code.name)}: {_setting_words(answer)}"
    return _of_class(answer)


def _setting_words(read: SettingRead) -> str:
    try:
        setting = as_setting(read)
    except ProtocolError:
        return f"{(read.value or b'').hex(' ')}, which is none"
    return "not told" if setting is None else _values(setting)


def _of_class(message: object) -> str:
    name = _plain(re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(message).__name__))
    values = _values(message)
    return f"{name}: {values}" if values else name


def _values(message: object) -> str:
    found = [(each.name, getattr(message, each.name)) for each in fields(message)]  # type: ignore[arg-type]
    return ", ".join(_value(name, value) for name, value in found)


def _value(name: str, value: object) -> str:
    unit = name.rpartition("_")[2]
    if isinstance(value, bool):
        return ("on" if value else "off") if name == "on" else f"{_plain(name)} {_yes(value)}"
    if isinstance(value, Enum):
        return _plain(value.name)
    if isinstance(value, bytes):
        return f"{_plain(name)} {'.'.join(map(str, value))}"
    if unit in _UNITS:
        return f"{value} {_UNITS[unit]}"
    return f"{value} {name}" if name in _COUNTED else f"{_plain(name)} {value}"


def _yes(value: bool) -> str:
    return "yes" if value else "no"


def _plain(name: str) -> str:
    return name.replace("_", " ").lower()


_UNITS = {"rpm": "rpm", "ms": "ms", "ma": "mA"}
_COUNTED = frozenset({"counts", "pulses", "percent", "microsteps"})


def _check(frame: Frame) -> FrameCheck:
    if frame.extended or frame.remote or frame.can_id > NODE_MAX or len(frame.data) < LEAST_BYTES:
        return FrameCheck.NONE
    right = frame.data[-1] == check_byte(frame.can_id, frame.data[:-1])
    return FrameCheck.RIGHT if right else FrameCheck.WRONG


def _name(frame: Frame) -> str:
    try:
        return Code(frame.data[0]).name.lower() if frame.data else ""
    except ValueError:
        return ""


def _why_not(frame: Frame, check: FrameCheck) -> str:
    if check is FrameCheck.NONE:
        kind = "remote" if frame.remote else "extended" if frame.extended else "short"
        return f"not of an MKS drive ({kind})"
    if check is FrameCheck.WRONG:
        wanted = check_byte(frame.can_id, frame.data[:-1])
        code = _name(frame)
        if not code:
            return "not of an MKS drive"
        return f"perhaps {_plain(code)}, but its last byte would be {wanted:02X}"
    known = _name(frame)
    return f"{_plain(known)} with a payload it does not have" if known else "a code nobody knows"


# What MKS drives on a CAN bus say, as messages of a recording: how each is weighed and read.

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
    return words(data, lambda frame: (str(frame.can_id), _answer(frame)), SENTENCES)


def sent(data: bytes) -> object:
    """Return what frames of the host mean. Raises `RemoteProtocolError`."""
    return words(data, lambda frame: (str(frame.can_id), decode_request(frame)), SENTENCES)


def _answer(frame: Frame) -> object:
    """Read an answer: the value of a setting looks like the answer to setting it."""
    try:
        return decode_answer(frame)
    except RemoteProtocolError:
        return decode_answer(frame, setting=True)


TALK = Describer(lambda: PackedFrames(weighed), heard, sent, shown, SENTENCES)
