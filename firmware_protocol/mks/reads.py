"""What a host reads from an MKS drive, and what it asks the drive to report by itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, TypeAlias

from firmware_protocol.errors import BadField, whole
from firmware_protocol.mks.forms import Plain, sized
from firmware_protocol.mks.settings import SETTING_CODES
from firmware_protocol.mks.values import Code


@dataclass(frozen=True, slots=True)
class ReadEncoder(Plain):
    """Ask where the shaft is, in counts from the zero that was set; F4 and F5 count so too."""

    code: ClassVar[Code] = Code.ENCODER


@dataclass(frozen=True, slots=True)
class ReadRawEncoder(Plain):
    """Ask where the shaft is, in counts, whatever zero was set. From 1.0.6 on."""

    code: ClassVar[Code] = Code.RAW_ENCODER


@dataclass(frozen=True, slots=True)
class ReadSpeed(Plain):
    """Ask how fast the shaft turns."""

    code: ClassVar[Code] = Code.SPEED


@dataclass(frozen=True, slots=True)
class ReadPulses(Plain):
    """Ask for the pulses that were commanded."""

    code: ClassVar[Code] = Code.PULSES


@dataclass(frozen=True, slots=True)
class ReadInputs(Plain):
    """Ask for the levels of the switches' inputs and of the outputs. From 1.0.3 on."""

    code: ClassVar[Code] = Code.INPUTS


@dataclass(frozen=True, slots=True)
class ReadAngleError(Plain):
    """Ask how far the shaft is from where it was commanded."""

    code: ClassVar[Code] = Code.ANGLE_ERROR


@dataclass(frozen=True, slots=True)
class ReadEnabled(Plain):
    """Ask whether the motor has current."""

    code: ClassVar[Code] = Code.ENABLED


@dataclass(frozen=True, slots=True)
class ReadHoming(Plain):
    """Ask how a return to zero stands."""

    code: ClassVar[Code] = Code.HOMING_STATE


@dataclass(frozen=True, slots=True)
class ReadStall(Plain):
    """Ask whether a protection has let the shaft go: after a stall, or too large an error."""

    code: ClassVar[Code] = Code.STALL


@dataclass(frozen=True, slots=True)
class ReadVersion(Plain):
    """Ask for the board and its firmware. Older firmware has no answer (`Ability.VERSION`)."""

    code: ClassVar[Code] = Code.VERSION


@dataclass(frozen=True, slots=True)
class ReadState(Plain):
    """Ask what the motor does."""

    code: ClassVar[Code] = Code.STATE


Read: TypeAlias = (
    ReadEncoder
    | ReadRawEncoder
    | ReadSpeed
    | ReadPulses
    | ReadInputs
    | ReadAngleError
    | ReadEnabled
    | ReadHoming
    | ReadStall
    | ReadVersion
    | ReadState
)

READS: tuple[type[Read], ...] = (
    ReadEncoder,
    ReadRawEncoder,
    ReadSpeed,
    ReadPulses,
    ReadInputs,
    ReadAngleError,
    ReadEnabled,
    ReadHoming,
    ReadStall,
    ReadVersion,
    ReadState,
)
READ_CODES = frozenset(read.code for read in READS)


@dataclass(frozen=True, slots=True)
class ReadSetting:
    """Ask for a setting, by the code that sets it. From 1.0.6 on.

    The answer has that code, and then looks like the answer to setting it: a host does not ask
    both at once.
    """

    code: ClassVar[Code] = Code.READ_SETTING
    setting: Code

    def __post_init__(self) -> None:
        if self.setting not in SETTING_CODES or not isinstance(self.setting, Code):
            raise BadField("setting", self.setting, "the Code of a setting")

    @property
    def payload(self) -> bytes:
        """The setting's code."""
        return bytes((self.setting,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload; ValueError where no code has the number."""
        return cls(Code(sized(payload, 1)[0]))


@dataclass(frozen=True, slots=True)
class ReportByItself:
    """Have the drive say a reading unasked every so many ms; 0 ends that. From 1.0.9 on."""

    code: ClassVar[Code] = Code.REPORT
    reading: Code
    period_ms: int

    def __post_init__(self) -> None:
        if self.reading not in READ_CODES or not isinstance(self.reading, Code):
            raise BadField("reading", self.reading, "the Code of a reading")
        whole("period_ms", self.period_ms, 0, 0xFFFF)

    @property
    def payload(self) -> bytes:
        """The reading's code and the period."""
        return bytes((self.reading,)) + self.period_ms.to_bytes(2, "big")

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload; ValueError where no code has the number."""
        sized(payload, 3)
        return cls(Code(payload[0]), int.from_bytes(payload[1:], "big"))
