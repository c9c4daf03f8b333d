"""What moves an MKS drive, as values checked when they are built.

Targets are absolute or relative, in encoder counts (`...Axis`) or in pulses, which are microsteps.
`acc` is the drive's own measure of a ramp (`ramp_rpm_s`), and 0 has none. All of it works in a bus
mode alone. A nine-byte example of F4 in the manual is a misprint: no frame of CAN is so long.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, TypeAlias

from firmware_protocol.errors import BadField, whole
from firmware_protocol.mks.forms import signed, sized
from firmware_protocol.mks.values import SPEED_MAX_RPM, TARGET_MAX, Code

ACC_MAX = 255
TICK_MS = 10
RUN_MAX_MS = 0xFF_FFFF * TICK_MS

_CLOCKWISE = 0x8000
_SPEED = 0x0FFF
TARGET_BYTES = 3


def _speed_and_acc(speed_rpm: object, acc: object) -> None:
    whole("speed_rpm", speed_rpm, 1, SPEED_MAX_RPM)
    whole("acc", acc, 0, ACC_MAX)


def _to_target(target: int, speed_rpm: int, acc: int) -> bytes:
    return speed_rpm.to_bytes(2, "big") + bytes((acc,)) + signed(target, TARGET_BYTES)


def _target(payload: bytes) -> tuple[int, int, int]:
    sized(payload, 3 + TARGET_BYTES)
    target = int.from_bytes(payload[3:], "big", signed=True)
    return target, int.from_bytes(payload[:2], "big"), payload[2]


def _way(speed_rpm: int, clockwise: bool) -> bytes:
    return (speed_rpm | (_CLOCKWISE if clockwise else 0)).to_bytes(2, "big")


@dataclass(frozen=True, slots=True)
class _InCounts:
    counts: int
    speed_rpm: int
    acc: int

    def __post_init__(self) -> None:
        whole("counts", self.counts, -TARGET_MAX, TARGET_MAX)
        _speed_and_acc(self.speed_rpm, self.acc)

    @property
    def payload(self) -> bytes:
        """Speed, acc, counts."""
        return _to_target(self.counts, self.speed_rpm, self.acc)

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(*_target(payload))


@dataclass(frozen=True, slots=True)
class MoveRelativeAxis(_InCounts):
    """Move by so many encoder counts."""

    code: ClassVar[Code] = Code.RELATIVE_AXIS


@dataclass(frozen=True, slots=True)
class MoveAbsoluteAxis(_InCounts):
    """Move to a count. From 1.0.5 on also while one is under way, which it replaces."""

    code: ClassVar[Code] = Code.ABSOLUTE_AXIS


@dataclass(frozen=True, slots=True)
class MoveAbsolutePulses:
    """Move to a pulse. From 1.0.4 on."""

    code: ClassVar[Code] = Code.ABSOLUTE_PULSES
    pulses: int
    speed_rpm: int
    acc: int

    def __post_init__(self) -> None:
        whole("pulses", self.pulses, -TARGET_MAX, TARGET_MAX)
        _speed_and_acc(self.speed_rpm, self.acc)

    @property
    def payload(self) -> bytes:
        """Speed, acc, pulses."""
        return _to_target(self.pulses, self.speed_rpm, self.acc)

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(*_target(payload))


@dataclass(frozen=True, slots=True)
class MoveRelativePulses:
    """Move by so many pulses."""

    code: ClassVar[Code] = Code.RELATIVE_PULSES
    pulses: int
    speed_rpm: int
    acc: int

    def __post_init__(self) -> None:
        most = (1 << 8 * TARGET_BYTES) - 1
        whole("pulses", self.pulses, -most, most)
        _speed_and_acc(self.speed_rpm, self.acc)

    @property
    def payload(self) -> bytes:
        """Direction and speed, acc, distance."""
        distance = abs(self.pulses).to_bytes(TARGET_BYTES, "big")
        return _way(self.speed_rpm, self.pulses < 0) + bytes((self.acc,)) + distance

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        sized(payload, 6)
        way = int.from_bytes(payload[:2], "big")
        distance = int.from_bytes(payload[3:], "big")
        return cls(-distance if way & _CLOCKWISE else distance, way & _SPEED, payload[2])


@dataclass(frozen=True, slots=True)
class RunAtSpeed:
    """Run at a signed speed until told otherwise. Nothing else ends it but the silence watchdog."""

    code: ClassVar[Code] = Code.SPEED_MODE
    speed_rpm: int
    acc: int

    def __post_init__(self) -> None:
        _signed_speed_and_acc(self.speed_rpm, self.acc)

    @property
    def payload(self) -> bytes:
        """Direction and speed, acc."""
        return _way(abs(self.speed_rpm), self.speed_rpm < 0) + bytes((self.acc,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(*_signed_speed(sized(payload, 3)))


@dataclass(frozen=True, slots=True)
class RunFor:
    """Run at a signed speed for a time, in steps of 10 ms; the drive ends it. From 1.0.7 on."""

    code: ClassVar[Code] = Code.SPEED_MODE
    speed_rpm: int
    acc: int
    duration_ms: int

    def __post_init__(self) -> None:
        _signed_speed_and_acc(self.speed_rpm, self.acc)
        if whole("duration_ms", self.duration_ms, TICK_MS, RUN_MAX_MS) % TICK_MS:
            raise BadField("duration_ms", self.duration_ms, f"a multiple of {TICK_MS}")

    @property
    def payload(self) -> bytes:
        """Direction and speed, acc, time."""
        run = _way(abs(self.speed_rpm), self.speed_rpm < 0) + bytes((self.acc,))
        return run + (self.duration_ms // TICK_MS).to_bytes(3, "big")

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        sized(payload, 6)
        ticks = int.from_bytes(payload[3:], "big")
        return cls(*_signed_speed(payload[:3]), ticks * TICK_MS)


def _signed_speed_and_acc(speed_rpm: object, acc: object) -> None:
    whole("speed_rpm", speed_rpm, -SPEED_MAX_RPM, SPEED_MAX_RPM)
    if speed_rpm == 0:
        raise BadField("speed_rpm", speed_rpm, "other than 0, which is a Stop")
    whole("acc", acc, 0, ACC_MAX)


def _signed_speed(payload: bytes) -> tuple[int, int]:
    way = int.from_bytes(payload[:2], "big")
    speed_rpm = way & _SPEED
    return (-speed_rpm if way & _CLOCKWISE else speed_rpm), payload[2]


Move: TypeAlias = MoveRelativeAxis | MoveAbsoluteAxis | MoveRelativePulses | MoveAbsolutePulses
