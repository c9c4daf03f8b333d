"""What an MKS drive answers: readings, settings, and how it fares with what it was told to do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Self, TypeAlias, get_args

from firmware_protocol.errors import BadField, RemoteProtocolError, whole
from firmware_protocol.mks.forms import (
    Message,
    Switch,
    choice,
    one_of,
    signed,
    sized,
    switch,
    unsigned,
)
from firmware_protocol.mks.requests import MOTION_CODES, READ_CODES, SETTING_CODES
from firmware_protocol.mks.values import Code, HomingState, MotorState, Outcome

_Int48: TypeAlias = Annotated[int, signed(6)]
_Int32: TypeAlias = Annotated[int, signed(4)]

# -- readings ------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class EncoderRead(Message, code=Code.ENCODER):
    """Where the shaft is, in counts from the zero that was set."""

    counts: _Int48


@dataclass(frozen=True, slots=True)
class RawEncoderRead(Message, code=Code.RAW_ENCODER):
    """Where the shaft is, in counts, whatever zero was set."""

    counts: _Int48


@dataclass(frozen=True, slots=True)
class SpeedRead(Message, code=Code.SPEED):
    """How fast the shaft turns; positive is counter-clockwise."""

    speed_rpm: Annotated[int, signed(2)]


@dataclass(frozen=True, slots=True)
class PulsesRead(Message, code=Code.PULSES):
    """The pulses that were commanded."""

    pulses: _Int32


@dataclass(frozen=True, slots=True)
class AngleErrorRead(Message, code=Code.ANGLE_ERROR):
    """How far the shaft is from where it was commanded; 51200 is a turn."""

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
    """Whether a protection has let the shaft go."""

    on: Switch


@dataclass(frozen=True, slots=True)
class StateRead(Message, code=Code.STATE):
    """What the motor does."""

    state: Annotated[MotorState, choice(MotorState)]


@dataclass(frozen=True, slots=True)
class HomingRead(Message, code=Code.HOMING_STATE):
    """How the return to zero at power-on stands and, from 1.0.7 on, the one by a `Home`."""

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
        """Read a payload; ValueError where there is no such state."""
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
"""What the number of a board means, by the manual 1.0.9."""


@dataclass(frozen=True, slots=True)
class VersionRead(Message, code=Code.VERSION):
    """Whether the encoder is calibrated, the board's number, and the firmware.

    The firmware has three numbers by what public programs read and two bytes by the manual 1.0.9,
    which does not say how to read those: `version` is None for them.
    """

    calibrated: bool
    board: int
    firmware: bytes

    def __post_init__(self) -> None:
        switch("calibrated", self.calibrated)
        whole("board", self.board, 0, 0x0F)
        if not isinstance(self.firmware, bytes) or len(self.firmware) not in (2, 3):
            raise BadField("firmware", self.firmware, "two or three bytes")

    @property
    def version(self) -> tuple[int, int, int] | None:
        """The version, as `abilities_of` takes it."""
        return None if len(self.firmware) < 3 else (*self.firmware[:2], self.firmware[2])

    @property
    def payload(self) -> bytes:
        """Calibration and board in one byte, firmware."""
        return bytes((self.calibrated << 4 | self.board,)) + self.firmware

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
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

# -- settings, as they are read ------------------------------------------------------------------

_UNREADABLE = b"\xff\xff"


@dataclass(frozen=True, slots=True)
class SettingRead:
    """A setting's payload as it is set, or None where the drive does not tell it."""

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
        """Read a payload."""
        return cls(code, None if payload == _UNREADABLE else payload)


# -- outcomes: the numbers by which a drive says how it fares, one table a kind ------------------

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
    # 2 is of a current that is not kept; a device here says 1 of that too
    Code.CURRENT: {0: Outcome.FAILED, 1: Outcome.DONE, 2: Outcome.DONE},
    Code.HOME: {0: Outcome.FAILED, 1: Outcome.STARTED, 2: Outcome.DONE},
    Code.CALIBRATE: {0: Outcome.STARTED, 1: Outcome.DONE, 2: Outcome.FAILED},
}


@dataclass(frozen=True, slots=True)
class Status:
    """How a drive fares with a code; `reading` is what a report by itself is to tell."""

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
        """The number, behind what it is about."""
        numbers = {outcome: key for key, outcome in reversed(_TABLES[self.code].items())}
        about = b"" if self.reading is None else bytes((self.reading,))
        return about + bytes((numbers[self.outcome],))

    @classmethod
    def of(cls, code: Code, payload: bytes) -> Status:
        """Read a payload; raises `RemoteProtocolError`, or ValueError for an unknown reading."""
        reading = Code(sized(payload, 2)[0]) if code is Code.REPORT else None
        (number,) = sized(payload if reading is None else payload[1:], 1)
        outcome = _TABLES.get(code, {}).get(number)
        if outcome is None:
            raise RemoteProtocolError(f"{number} says nothing of {code.name}")
        return cls(code, outcome, reading)


Answer: TypeAlias = Reading | SettingRead | Status
