"""An MKS drive's answers: readings, settings, and the outcomes of commands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Self, TypeAlias, get_args

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.fields import boolean
from firmware_protocol.mks.forms import (
    Message,
    Switch,
    choice,
    one_of,
    signed,
    sized,
    unsigned,
)
from firmware_protocol.mks.requests import MOTION_CODES, READ_CODES, SETTING_CODES
from firmware_protocol.mks.values import Code, HomingState, MotorState, Outcome

_Int48: TypeAlias = Annotated[int, signed(6)]
_Int32: TypeAlias = Annotated[int, signed(4)]

# -- readings ------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class EncoderRead(Message, code=Code.ENCODER):
    """The shaft's position, in counts from the zero that was set."""

    counts: _Int48


@dataclass(frozen=True, slots=True)
class RawEncoderRead(Message, code=Code.RAW_ENCODER):
    """The shaft's raw position in counts, regardless of the zero."""

    counts: _Int48


@dataclass(frozen=True, slots=True)
class SpeedRead(Message, code=Code.SPEED):
    """The shaft's speed; positive is counter-clockwise."""

    speed_rpm: Annotated[int, signed(2)]


@dataclass(frozen=True, slots=True)
class PulsesRead(Message, code=Code.PULSES):
    """The commanded pulses."""

    pulses: _Int32


@dataclass(frozen=True, slots=True)
class AngleErrorRead(Message, code=Code.ANGLE_ERROR):
    """The shaft's following error; 51200 is one turn."""

    error: _Int32


@dataclass(frozen=True, slots=True)
class InputsRead(Message, code=Code.INPUTS):
    """Levels: bit 0 IN_1, 1 IN_2, 2 OUT_1, 3 OUT_2. Sources disagree on the first two."""

    levels: Annotated[int, unsigned(1)]


@dataclass(frozen=True, slots=True)
class EnabledRead(Message, code=Code.ENABLED):
    """Whether the motor has current."""

    on: Switch


@dataclass(frozen=True, slots=True)
class StallRead(Message, code=Code.STALL):
    """Whether a protection has released the shaft."""

    on: Switch


@dataclass(frozen=True, slots=True)
class StateRead(Message, code=Code.STATE):
    """The motor's state."""

    state: Annotated[MotorState, choice(MotorState)]


@dataclass(frozen=True, slots=True)
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
"""The boards by number, from the manual 1.0.9."""


@dataclass(frozen=True, slots=True)
class VersionRead(Message, code=Code.VERSION):
    """Whether the encoder is calibrated, the board's number, and the firmware's version.

    Public programs read three numbers as the firmware's version. The manual 1.0.9 has two bytes
    and does not explain them; `version` is then None.
    """

    calibrated: bool
    board: int
    firmware: bytes

    def __post_init__(self) -> None:
        boolean("calibrated", self.calibrated)
        whole("board", self.board, 0, 0x0F)
        if not isinstance(self.firmware, bytes) or len(self.firmware) not in (2, 3):
            raise BadField("firmware", self.firmware, "two or three bytes")

    @property
    def version(self) -> tuple[int, int, int] | None:
        """The version, for `abilities_of`."""
        return None if len(self.firmware) < 3 else (*self.firmware[:2], self.firmware[2])

    @property
    def payload(self) -> bytes:
        """Calibration and board in one byte, then the firmware."""
        return bytes((self.calibrated << 4 | self.board,)) + self.firmware

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Decode a payload."""
        sized(payload, 3, 4)
        return cls(payload[0] > 0x0F, payload[0] & 0x0F, payload[1:])


Reading: TypeAlias = (
    EncoderRead
    | RawEncoderRead
    | SpeedRead
    | PulsesRead
    | AngleErrorRead
    | InputsRead
    | EnabledRead
    | StallRead
    | StateRead
    | HomingRead
    | VersionRead
)
READINGS: tuple[type[Reading], ...] = get_args(Reading)

# -- settings, as read back ----------------------------------------------------------------------

_UNREADABLE = b"\xff\xff"


@dataclass(frozen=True, slots=True)
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
    **dict.fromkeys((Code.CLEAR_STALL, Code.RESTART, Code.REPORT), _PLAIN),
    # 2 is for a current that is not stored; the simulated device sends 1 for that too
    Code.CURRENT: {0: Outcome.FAILED, 1: Outcome.DONE, 2: Outcome.DONE},
    Code.HOME: {0: Outcome.FAILED, 1: Outcome.STARTED, 2: Outcome.DONE},
    Code.CALIBRATE: {0: Outcome.STARTED, 1: Outcome.DONE, 2: Outcome.FAILED},
}


@dataclass(frozen=True, slots=True)
class Status:
    """The outcome of a request; `reading` is the code of an automatic report being set up."""

    code: Code
    outcome: Outcome
    reading: Code | None = None

    def __post_init__(self) -> None:
        one_of("code", self.code, Code)
        outcomes = set(_TABLES.get(self.code, {}).values())
        if self.outcome not in outcomes:
            words = ", ".join(sorted(outcome.name for outcome in outcomes)) or "none"
            raise BadField("outcome", self.outcome, f"for {self.code.name} one of: {words}")
        if (self.code is Code.REPORT) != (self.reading in READ_CODES):
            raise BadField("reading", self.reading, "a reading's Code, for Code.REPORT alone")

    @property
    def payload(self) -> bytes:
        """The code of the reading, if any, and the number."""
        numbers = {outcome: key for key, outcome in reversed(_TABLES[self.code].items())}
        about = b"" if self.reading is None else bytes((self.reading,))
        return about + bytes((numbers[self.outcome],))

    @classmethod
    def of(cls, code: Code, payload: bytes) -> Status:
        """Decode a payload. Raises `RemoteProtocolError`, or ValueError for an unknown reading."""
        reading = Code(sized(payload, 2)[0]) if code is Code.REPORT else None
        (number,) = sized(payload if reading is None else payload[1:], 1)
        outcome = _TABLES.get(code, {}).get(number)
        if outcome is None:
            raise RemoteProtocolError(f"{number} says nothing of {code.name}")
        return cls(code, outcome, reading)


Answer: TypeAlias = Reading | SettingRead | Status
