"""What stops an MKS drive, switches it, homes it and sets it going, checked when built."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self, TypeAlias

from firmware_protocol.errors import BadField, whole
from firmware_protocol.mks.forms import Plain, Switch, sized
from firmware_protocol.mks.moves import ACC_MAX, TARGET_BYTES, Move, RunAtSpeed, RunFor
from firmware_protocol.mks.values import Code

MOTION_CODES = frozenset(
    (
        Code.RELATIVE_AXIS,
        Code.ABSOLUTE_AXIS,
        Code.SPEED_MODE,
        Code.RELATIVE_PULSES,
        Code.ABSOLUTE_PULSES,
    )
)


@dataclass(frozen=True, slots=True)
class Stop:
    """End a motion of this code by a ramp of `acc`, or at once by an `acc` of 0."""

    code: Code
    acc: int

    def __post_init__(self) -> None:
        if self.code not in MOTION_CODES or not isinstance(self.code, Code):
            raise BadField("code", self.code, "the Code of a motion")
        whole("acc", self.acc, 0, ACC_MAX)

    @property
    def payload(self) -> bytes:
        """A speed of 0, acc, and a distance of 0 where a move has one."""
        rest = b"" if self.code is Code.SPEED_MODE else bytes(TARGET_BYTES)
        return bytes((0, 0, self.acc)) + rest


@dataclass(frozen=True, slots=True)
class EmergencyStop(Plain):
    """Stop at once, without a ramp: not above 1000 rpm. From 1.0.4 on."""

    code: ClassVar[Code] = Code.EMERGENCY_STOP


@dataclass(frozen=True, slots=True)
class Enable(Switch):
    """Switch the motor's current on or off. Off lets the shaft go."""

    code: ClassVar[Code] = Code.ENABLE


@dataclass(frozen=True, slots=True)
class ArmSynchronous(Switch):
    """Have the drive store motions until `GoSynchronous`, or no more. From 1.0.8 on."""

    code: ClassVar[Code] = Code.ARM


@dataclass(frozen=True, slots=True)
class GoSynchronous(Plain):
    """Start every stored motion. Broadcast alone; say it again 1 ms later, as drives miss it."""

    code: ClassVar[Code] = Code.GO


@dataclass(frozen=True, slots=True)
class Home(Plain):
    """Search for the zero as the drive is set up to. It moves."""

    code: ClassVar[Code] = Code.HOME


@dataclass(frozen=True, slots=True)
class GoToZero:
    """Run to the zero that a `Home` has found. It moves. From 1.0.9 on."""

    code: ClassVar[Code] = Code.HOME

    @property
    def payload(self) -> bytes:
        """Its choice."""
        return b"\1"


@dataclass(frozen=True, slots=True)
class Calibrate:
    """Measure the encoder against the motor, which turns: nothing may be on its shaft."""

    code: ClassVar[Code] = Code.CALIBRATE

    @property
    def payload(self) -> bytes:
        """A zero."""
        return b"\0"

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        if sized(payload, 1) != b"\0":
            raise BadField("payload", payload, "a zero")
        return cls()


@dataclass(frozen=True, slots=True)
class SetZero(Plain):
    """Call the present position zero. It moves nothing. From 1.0.1 on."""

    code: ClassVar[Code] = Code.ZERO


@dataclass(frozen=True, slots=True)
class ClearStall(Plain):
    """Let the motor have current again after a protection has let the shaft go."""

    code: ClassVar[Code] = Code.CLEAR_STALL


@dataclass(frozen=True, slots=True)
class Restart(Plain):
    """Start the drive anew; settings stay. From 1.0.5 on."""

    code: ClassVar[Code] = Code.RESTART


Motion: TypeAlias = Move | RunAtSpeed | RunFor | Stop | Home | GoToZero | Calibrate
"""What a drive first says `STARTED` of, and later how it ended."""
Action: TypeAlias = (
    EmergencyStop | Enable | ArmSynchronous | GoSynchronous | SetZero | ClearStall | Restart
)
