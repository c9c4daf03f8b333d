"""An MKS drive's answers: readings, settings, and the outcomes of commands."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Self, TypeAlias, TypeVar, get_args

from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError, whole
from firmware_protocol.fields import boolean, message
from firmware_protocol.frames import DATA_MAX, Frame
from firmware_protocol.mks.requests import (
    ACTIONS,
    MOTION_CODES,
    OTHER_MOTIONS,
    READS,
    SETTING_CODES,
    SETTINGS,
    Calibrate,
    Home,
    MoveAbsoluteAxis,
    OtherMotion,
    ReadSetting,
    Request,
    Setting,
    Stop,
)
from firmware_protocol.mks.values import (
    Code,
    HomingState,
    Message,
    MotorState,
    Outcome,
    Switch,
    Version,
    check_byte,
    choice,
    one_of,
    signed,
    sized,
)

_Int48: TypeAlias = Annotated[int, signed(6)]
_Int32: TypeAlias = Annotated[int, signed(4)]

# -- readings ------------------------------------------------------------------------------------


@message()
class EncoderRead(Message, code=Code.ENCODER):
    """The shaft's position, in counts from the zero that was set."""

    counts: _Int48


@message()
class RawEncoderRead(Message, code=Code.RAW_ENCODER):
    """The shaft's raw position in counts, regardless of the zero."""

    counts: _Int48


@message()
class AngleErrorRead(Message, code=Code.ANGLE_ERROR):
    """The shaft's following error; 51200 is one turn."""

    error: _Int32


@message()
class EnabledRead(Message, code=Code.ENABLED):
    """Whether the motor has current."""

    on: Switch


@message()
class StallRead(Message, code=Code.STALL):
    """Whether a protection has released the shaft."""

    on: Switch


@message()
class StateRead(Message, code=Code.STATE):
    """The motor's state."""

    state: Annotated[MotorState, choice(MotorState)]


@message()
class HomingRead(Message, code=Code.HOMING_STATE):
    """The state of the return to zero at power-on and, since 1.0.7, of a `Home`."""

    at_power_on: HomingState
    by_command: HomingState | None = None

    def __post_init__(self) -> None:
        one_of("at_power_on", self.at_power_on, HomingState)
        if self.by_command is not None:
            one_of("by_command", self.by_command, HomingState)

    @property
    def payload(self) -> bytes:
        """One byte, or two."""
        states = (self.at_power_on, self.by_command)
        return bytes(state for state in states if state is not None)

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Decode a payload. Raises ValueError for an unknown state."""
        return cls(*map(HomingState, sized(payload, 1, 2)))


# The boards by number, from the manual 1.0.9.
BOARDS = {
    1: "SERVO42D, RS485",
    2: "SERVO42D, CAN",
    3: "SERVO57D, RS485",
    4: "SERVO57D, CAN",
    5: "SERVO28D, RS485",
    6: "SERVO28D, CAN",
    7: "SERVO35D, RS485",
    8: "SERVO35D, CAN",
}


@message()
class VersionRead(Message, code=Code.VERSION):
    """Whether the encoder is calibrated, the board's number, and the firmware's version.

    A real drive of the E series answers with three bytes of firmware (`40 92 01 00 01`,
    TRazDev/servo42es-esp32-can-controller, protocol notes), as the manual 1.0.9 names them.
    """

    calibrated: bool
    board: int
    version: Version
    e_series: bool = False
    """Whether it is a SERVO42E or 57E, whose commands differ (its manual 1.0.1, 40H)."""

    def __post_init__(self) -> None:
        boolean("calibrated", self.calibrated)
        boolean("e_series", self.e_series)
        whole("board", self.board, 0, 0x0F)
        for part in self.version:
            whole("version", part, 0, 255)

    @property
    def payload(self) -> bytes:
        """Series, calibration and board in one byte, then the firmware."""
        first = self.e_series << 7 | self.calibrated << 4 | self.board
        return bytes((first, *self.version))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Decode a payload."""
        first, *version = sized(payload, 4)
        return cls(bool(first & 0x70), first & 0x0F, tuple(version), bool(first & 0x80))  # type: ignore[arg-type]


Reading: TypeAlias = (
    EncoderRead
    | RawEncoderRead
    | AngleErrorRead
    | EnabledRead
    | StallRead
    | StateRead
    | HomingRead
    | VersionRead
)
READINGS: tuple[type[Reading], ...] = get_args(Reading)

# -- settings, as read back ----------------------------------------------------------------------

_UNREADABLE = b"\xff\xff"


@message()
class SettingRead:
    """A setting's payload, in the format of the write; None if the drive does not report it."""

    code: Code
    value: bytes | None

    def __post_init__(self) -> None:
        one_of("code", self.code, Code)
        fits = isinstance(self.value, bytes) and 1 <= len(self.value) <= 6
        if self.value is not None and (not fits or self.value == _UNREADABLE):
            raise BadField("value", self.value, "1 to 6 bytes other than FF FF, or None")

    @property
    def payload(self) -> bytes:
        """The value, or FF FF."""
        return _UNREADABLE if self.value is None else self.value

    @classmethod
    def of(cls, code: Code, payload: bytes) -> Self:
        """Decode a payload."""
        return cls(code, None if payload == _UNREADABLE else payload)


# -- outcomes: the status numbers, one table per kind of request ---------------------------------

_PLAIN = {0: Outcome.FAILED, 1: Outcome.DONE}
_MOTION = {
    0: Outcome.FAILED,
    1: Outcome.STARTED,
    2: Outcome.DONE,
    3: Outcome.LIMIT_STOP,
    5: Outcome.STORED,
}
_TABLES: dict[Code, dict[int, Outcome]] = {
    **dict.fromkeys(SETTING_CODES, _PLAIN),
    **dict.fromkeys(MOTION_CODES, _MOTION),
    **dict.fromkeys((Code.ENABLE, Code.EMERGENCY_STOP, Code.ARM, Code.ZERO), _PLAIN),
    Code.CLEAR_STALL: _PLAIN,
    Code.HOME: {0: Outcome.FAILED, 1: Outcome.STARTED, 2: Outcome.DONE},
    Code.CALIBRATE: {0: Outcome.STARTED, 1: Outcome.DONE, 2: Outcome.FAILED},
}


@message()
class Status:
    """The outcome of a request."""

    code: Code
    outcome: Outcome

    def __post_init__(self) -> None:
        one_of("code", self.code, Code)
        outcomes = _TABLES.get(self.code, {}).values()
        if self.outcome not in outcomes:
            words = ", ".join(sorted({outcome.name for outcome in outcomes})) or "none"
            raise BadField("outcome", self.outcome, f"for {self.code.name} one of: {words}")

    @property
    def payload(self) -> bytes:
        """The number."""
        table = _TABLES[self.code]
        return bytes((next(key for key, each in table.items() if each is self.outcome),))

    @classmethod
    def of(cls, code: Code, payload: bytes) -> Status:
        """Decode a payload. Raises `RemoteProtocolError`."""
        (number,) = sized(payload, 1)
        outcome = _TABLES.get(code, {}).get(number)
        if outcome is None:
            raise RemoteProtocolError(f"{number} says nothing of {code.name}")
        return cls(code, outcome)


Answer: TypeAlias = Reading | SettingRead | Status


# -- the bytes of frames: code, payload, check byte ----------------------------------------------
#
# A drive's answer has the id of the request, so a frame alone does not say which of the two it is.

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
        raise RemoteProtocolError(f"length {len(data)} where 2 to {DATA_MAX} belong")
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


def _move(payload: bytes) -> Request:
    stops = len(payload) == 6 and payload[:2] == b"\0\0"  # wherever it is to go
    return Stop(payload[2]) if stops else MoveAbsoluteAxis.read(payload)


def _other(code: Code) -> Callable[[bytes], Request]:
    return lambda payload: OtherMotion(code, payload)


_SETTINGS: dict[Code, Callable[[bytes], Setting]] = {each.code: each.read for each in SETTINGS}
_READINGS: dict[Code, Callable[[bytes], Reading]] = {each.code: each.read for each in READINGS}
_REQUESTS: dict[Code, Callable[[bytes], Request]] = {
    **_SETTINGS,
    **{each.code: each.read for each in (*READS, ReadSetting)},
    **{each.code: each.read for each in (*ACTIONS, Calibrate)},
    **{code: _other(code) for code in OTHER_MOTIONS},
    Code.ABSOLUTE_AXIS: _move,
    Code.HOME: lambda payload: Home.read(b"" if payload == b"\0" else payload),
}
