"""The bytes of MKS frames: code, payload, check byte; requests and answers, both ways.

A drive's answer has the id of the request, so a frame alone does not say which of the two it is.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError
from firmware_protocol.frames import DATA_MAX, Frame
from firmware_protocol.mks.answers import READINGS, Answer, Reading, SettingRead, Status
from firmware_protocol.mks.requests import (
    ACTIONS,
    MOVES,
    READS,
    SETTINGS,
    Calibrate,
    GoToZero,
    Home,
    ReadSetting,
    ReportByItself,
    Request,
    RunAtSpeed,
    RunFor,
    Setting,
    Stop,
)
from firmware_protocol.mks.values import Code, check_byte

_Message = TypeVar("_Message")


def encode(can_id: int, message: Request | Answer) -> Frame:
    """Return the frame of a request or of an answer."""
    data = bytes((message.code,)) + message.payload
    return Frame(can_id, data + bytes((check_byte(can_id, data),)))


def decode_request(frame: Frame) -> Request:
    """Read a request; raises `RemoteProtocolError`."""
    code, payload = _checked(frame)
    if code not in _REQUESTS:
        raise RemoteProtocolError(f"{code.name} is no request")
    return _read(code, _REQUESTS[code], payload)


def decode_answer(frame: Frame, *, setting: bool = False) -> Answer:
    """Read an answer; raises `RemoteProtocolError`.

    `setting` says that a setting was asked for by its code: the answer to setting it looks alike.
    """
    code, payload = _checked(frame)
    if setting:
        return _read(code, lambda value: SettingRead.of(code, value), payload)
    if code in _READINGS:
        return _read(code, _READINGS[code], payload)
    return _read(code, lambda value: Status.of(code, value), payload)


def as_setting(read: SettingRead) -> Setting | None:
    """Return what would set a setting as it was read, to be compared with what was set.

    None where the drive does not tell it. Raises `LocalProtocolError` for a code that is no
    setting here, `RemoteProtocolError` for a value that is none of it.
    """
    if read.value is None:
        return None
    if read.code not in _SETTINGS:
        raise LocalProtocolError(f"{read.code.name} is no setting")
    return _read(read.code, _SETTINGS[read.code], read.value)


def _checked(frame: Frame) -> tuple[Code, bytes]:
    if frame.extended or frame.remote:
        raise RemoteProtocolError("a frame of another kind than the drive's")
    data = frame.data
    if len(data) < 2:
        raise RemoteProtocolError(f"{len(data)} bytes where 2 to {DATA_MAX} belong")
    wanted = check_byte(frame.can_id, data[:-1])
    if data[-1] != wanted:
        raise RemoteProtocolError(f"the check byte should be {wanted:02x}")
    try:
        return Code(data[0]), data[1:-1]
    except ValueError:
        raise RemoteProtocolError(f"no code has the number {data[0]:02x}") from None


def _read(code: Code, read: Callable[[bytes], _Message], payload: bytes) -> _Message:
    try:
        return read(payload)
    except ValueError as error:  # of what came, not of what we chose
        raise RemoteProtocolError(f"{code.name}: {error}") from None


_ZERO_SPEEDS = (b"\0\0", b"\x80\0")  # where bit 7 is the direction


def _run(payload: bytes) -> Request:
    if payload[:2] in _ZERO_SPEEDS and len(payload) == 3:
        return Stop(Code.SPEED_MODE, payload[2])
    return RunAtSpeed.read(payload) if len(payload) == 3 else RunFor.read(payload)


def _move(code: Code, move: Callable[[bytes], Request]) -> Callable[[bytes], Request]:
    zeros = _ZERO_SPEEDS if code is Code.RELATIVE_PULSES else _ZERO_SPEEDS[:1]

    def read(payload: bytes) -> Request:
        stops = len(payload) == 6 and payload[:2] in zeros  # wherever it is to go
        return Stop(code, payload[2]) if stops else move(payload)

    return read


def _home(payload: bytes) -> Request:
    return GoToZero() if payload == b"\1" else Home.read(b"" if payload == b"\0" else payload)


_SETTINGS: dict[Code, Callable[[bytes], Setting]] = {each.code: each.read for each in SETTINGS}
_READINGS: dict[Code, Callable[[bytes], Reading]] = {each.code: each.read for each in READINGS}
_REQUESTS: dict[Code, Callable[[bytes], Request]] = {
    **_SETTINGS,
    **{each.code: each.read for each in (*READS, ReadSetting, ReportByItself)},
    **{each.code: each.read for each in (*ACTIONS, Calibrate)},
    **{each.code: _move(each.code, each.read) for each in MOVES},
    Code.SPEED_MODE: _run,
    Code.HOME: _home,
}
