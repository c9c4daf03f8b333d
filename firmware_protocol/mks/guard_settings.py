"""What an MKS drive guards itself by: protections, limits, silence; checked when built."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from firmware_protocol.errors import whole
from firmware_protocol.mks.forms import Switch, byte_switch, sized, switch
from firmware_protocol.mks.values import SPEED_MAX_RPM, Code


@dataclass(frozen=True, slots=True)
class SetStallProtection(Switch):
    """Have the drive let the shaft go when it stalls, or not, as shipped."""

    code: ClassVar[Code] = Code.STALL_PROTECTION


@dataclass(frozen=True, slots=True)
class SetPositionProtection:
    """Have the drive let the shaft go when it is too far from its target. From 1.0.6 on.

    `window` counts about 15 ms; `error` 28000 is a turn. The flag of zeroing by the En pin, which
    is in the same byte, is left off.
    """

    code: ClassVar[Code] = Code.POSITION_PROTECTION
    on: bool
    window: int
    error: int

    def __post_init__(self) -> None:
        switch("on", self.on)
        whole("window", self.window, 0, 0xFFFF)
        whole("error", self.error, 0, 0xFFFF)

    @property
    def payload(self) -> bytes:
        """Flag, window, error."""
        return bytes((self.on,)) + self.window.to_bytes(2, "big") + self.error.to_bytes(2, "big")

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        sized(payload, 5)
        numbers = (int.from_bytes(payload[at : at + 2], "big") for at in (1, 3))
        return cls(byte_switch(payload[:1]), *numbers)


@dataclass(frozen=True, slots=True)
class SetHoming:
    """Set up what `Home` does. After a change of the limits the manual wants a `Home`.

    `method`: 0 by a switch, 1 against a stop, 2 within a turn. `limits` has the switches stop
    motions; reaching one in homing then lets the shaft go.
    """

    code: ClassVar[Code] = Code.HOMING
    active_high: bool
    counter_clockwise: bool
    speed_rpm: int
    limits: bool
    method: int

    def __post_init__(self) -> None:
        for field in ("active_high", "counter_clockwise", "limits"):
            switch(field, getattr(self, field))
        whole("speed_rpm", self.speed_rpm, 0, SPEED_MAX_RPM)
        whole("method", self.method, 0, 2)

    @property
    def payload(self) -> bytes:
        """Level, direction, speed, limits, method."""
        ways = bytes((self.active_high, self.counter_clockwise))
        return ways + self.speed_rpm.to_bytes(2, "big") + bytes((self.limits, self.method))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        sized(payload, 6)
        high, ccw, limits = (byte_switch(payload[at : at + 1]) for at in (0, 1, 4))
        return cls(high, ccw, int.from_bytes(payload[2:4], "big"), limits, payload[5])


@dataclass(frozen=True, slots=True)
class SetArrival:
    """Choose how near a motion must come to be said `DONE`; 65535 is a turn. From 1.0.8 on."""

    code: ClassVar[Code] = Code.ARRIVAL
    on: bool
    threshold: int = 200

    def __post_init__(self) -> None:
        switch("on", self.on)
        whole("threshold", self.threshold, 0, 0xFFFF)

    @property
    def payload(self) -> bytes:
        """Flag, threshold."""
        return bytes((self.on,)) + self.threshold.to_bytes(2, "big")

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        sized(payload, 3)
        return cls(byte_switch(payload[:1]), int.from_bytes(payload[1:], "big"))


@dataclass(frozen=True, slots=True)
class SilenceWatchdog:
    """Have the drive stop when it has been told nothing for so long; 0, as shipped, never.

    From 1.0.9 on. Whether frames to other drives count as something is not in the manual.
    """

    code: ClassVar[Code] = Code.WATCHDOG
    timeout_ms: int

    def __post_init__(self) -> None:
        whole("timeout_ms", self.timeout_ms, 0, 0xFFFF_FFFF)

    @property
    def payload(self) -> bytes:
        """Four bytes."""
        return self.timeout_ms.to_bytes(4, "big")

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(int.from_bytes(sized(payload, 4), "big"))
