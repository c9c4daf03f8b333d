"""What an MKS drive answers to reads, as values checked when they are built."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, TypeAlias

from firmware_protocol.errors import RemoteProtocolError, whole
from firmware_protocol.mks.forms import Switch, number, one_of, signed, sized
from firmware_protocol.mks.identity import VersionRead
from firmware_protocol.mks.values import Code, HomingState, MotorState

_BYTE_MAX = 0xFF


@dataclass(frozen=True, slots=True)
class _Counts:
    counts: int

    def __post_init__(self) -> None:
        number("counts", self.counts, 6)

    @property
    def payload(self) -> bytes:
        """Six bytes."""
        return signed(self.counts, 6)

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(int.from_bytes(sized(payload, 6), "big", signed=True))


@dataclass(frozen=True, slots=True)
class EncoderRead(_Counts):
    """Where the shaft is, in counts from the zero that was set."""

    code: ClassVar[Code] = Code.ENCODER


@dataclass(frozen=True, slots=True)
class RawEncoderRead(_Counts):
    """Where the shaft is, in counts, whatever zero was set."""

    code: ClassVar[Code] = Code.RAW_ENCODER


@dataclass(frozen=True, slots=True)
class SpeedRead:
    """How fast the shaft turns; positive is counter-clockwise."""

    code: ClassVar[Code] = Code.SPEED
    speed_rpm: int

    def __post_init__(self) -> None:
        number("speed_rpm", self.speed_rpm, 2)

    @property
    def payload(self) -> bytes:
        """Two bytes."""
        return signed(self.speed_rpm, 2)

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(int.from_bytes(sized(payload, 2), "big", signed=True))


@dataclass(frozen=True, slots=True)
class PulsesRead:
    """The pulses that were commanded."""

    code: ClassVar[Code] = Code.PULSES
    pulses: int

    def __post_init__(self) -> None:
        number("pulses", self.pulses, 4)

    @property
    def payload(self) -> bytes:
        """Four bytes."""
        return signed(self.pulses, 4)

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(int.from_bytes(sized(payload, 4), "big", signed=True))


@dataclass(frozen=True, slots=True)
class AngleErrorRead:
    """How far the shaft is from where it was commanded; 51200 is a turn."""

    code: ClassVar[Code] = Code.ANGLE_ERROR
    error: int

    def __post_init__(self) -> None:
        number("error", self.error, 4)

    @property
    def payload(self) -> bytes:
        """Four bytes."""
        return signed(self.error, 4)

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(int.from_bytes(sized(payload, 4), "big", signed=True))


@dataclass(frozen=True, slots=True)
class InputsRead:
    """Levels: bit 0 IN_1, 1 IN_2, 2 OUT_1, 3 OUT_2. Sources disagree on the first two."""

    code: ClassVar[Code] = Code.INPUTS
    levels: int

    def __post_init__(self) -> None:
        whole("levels", self.levels, 0, _BYTE_MAX)

    @property
    def payload(self) -> bytes:
        """One byte."""
        return bytes((self.levels,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(sized(payload, 1)[0])


@dataclass(frozen=True, slots=True)
class EnabledRead(Switch):
    """Whether the motor has current."""

    code: ClassVar[Code] = Code.ENABLED


@dataclass(frozen=True, slots=True)
class StallRead(Switch):
    """Whether a protection has let the shaft go."""

    code: ClassVar[Code] = Code.STALL


@dataclass(frozen=True, slots=True)
class StateRead:
    """What the motor does."""

    code: ClassVar[Code] = Code.STATE
    state: MotorState

    def __post_init__(self) -> None:
        one_of("state", self.state, MotorState)

    @property
    def payload(self) -> bytes:
        """One byte."""
        return bytes((self.state,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload; ValueError where there is no such state."""
        return cls(MotorState(sized(payload, 1)[0]))


@dataclass(frozen=True, slots=True)
class HomingRead:
    """How the return to zero at power-on stands and, from 1.0.7 on, the one by a `Home`."""

    code: ClassVar[Code] = Code.HOMING_STATE
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
        if len(payload) not in (1, 2):
            raise RemoteProtocolError(f"{len(payload)} bytes where 1 or 2 belong")
        return cls(*map(HomingState, payload))


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
READINGS: tuple[type[Reading], ...] = (
    EncoderRead,
    RawEncoderRead,
    SpeedRead,
    PulsesRead,
    AngleErrorRead,
    InputsRead,
    EnabledRead,
    StallRead,
    StateRead,
    HomingRead,
    VersionRead,
)
