"""How an MKS drive runs its motor: mode, current, microsteps; checked when built."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from firmware_protocol.errors import BadField, whole
from firmware_protocol.mks.forms import byte_switch, one_of, sized, switch
from firmware_protocol.mks.values import Code, Mode

CURRENT_MAX_MA = 5200
"""Of a SERVO57D; a 42D, 35D or 28D takes 3000. The manual warns of setting the maximum at once."""
MICROSTEPS_MAX = 256


@dataclass(frozen=True, slots=True)
class SetMode:
    """Choose who commands the motor; `Mode.BUS_FOC` for an arm."""

    code: ClassVar[Code] = Code.MODE
    mode: Mode

    def __post_init__(self) -> None:
        one_of("mode", self.mode, Mode)

    @property
    def payload(self) -> bytes:
        """The mode."""
        return bytes((self.mode,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload; ValueError where there is no such mode."""
        return cls(Mode(sized(payload, 1)[0]))


@dataclass(frozen=True, slots=True)
class SetCurrent:
    """Set the motor's current; not to `keep` it works from 1.0.7 on."""

    code: ClassVar[Code] = Code.CURRENT
    current_ma: int
    keep: bool = True

    def __post_init__(self) -> None:
        whole("current_ma", self.current_ma, 1, CURRENT_MAX_MA)
        switch("keep", self.keep)

    @property
    def payload(self) -> bytes:
        """The current, and a zero where it is not to be kept."""
        return self.current_ma.to_bytes(2, "big") + (b"" if self.keep else b"\0")

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        keep = payload[2:] != b"\0"
        sized(payload, 2 if keep else 3)
        return cls(int.from_bytes(payload[:2], "big"), keep)


@dataclass(frozen=True, slots=True)
class SetHoldingCurrent:
    """Set the current at rest in percent of the other, 10 to 90 by tens; not in FOC. From 1.0.4."""

    code: ClassVar[Code] = Code.HOLDING_CURRENT
    percent: int

    def __post_init__(self) -> None:
        if whole("percent", self.percent, 10, 90) % 10:
            raise BadField("percent", self.percent, "a multiple of 10")

    @property
    def payload(self) -> bytes:
        """Tens, from 0."""
        return bytes((self.percent // 10 - 1,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(10 * (sized(payload, 1)[0] + 1))


@dataclass(frozen=True, slots=True)
class SetMicrosteps:
    """Set the pulses of a full step. What 256 is on the wire, 0, is not in the CAN manuals."""

    code: ClassVar[Code] = Code.MICROSTEPS
    microsteps: int

    def __post_init__(self) -> None:
        whole("microsteps", self.microsteps, 1, MICROSTEPS_MAX)

    @property
    def payload(self) -> bytes:
        """One byte."""
        return bytes((self.microsteps % MICROSTEPS_MAX,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(sized(payload, 1)[0] or MICROSTEPS_MAX)


@dataclass(frozen=True, slots=True)
class SetDirection:
    """Choose which way pulses turn the motor. It does nothing to motions over the bus."""

    code: ClassVar[Code] = Code.DIRECTION
    counter_clockwise: bool

    def __post_init__(self) -> None:
        switch("counter_clockwise", self.counter_clockwise)

    @property
    def payload(self) -> bytes:
        """One byte."""
        return bytes((self.counter_clockwise,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(byte_switch(payload))
