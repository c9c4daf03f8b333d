"""What a host asks of a Robko 01, as values checked when they are built.

Each has its operation and its payload. Everything here raises `BadField` (a
`LocalProtocolError`) that names the field, the value and the range.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from firmware_protocol.errors import BadField, whole
from firmware_protocol.robko01.frames import PAYLOAD_MAX
from firmware_protocol.robko01.values import Axes, Op

BYTE_MAX = 255


def some_bytes(field: str, value: object) -> bytes:
    """Return bytes that fit in a payload, or raise `BadField`."""
    if not isinstance(value, bytes) or len(value) > PAYLOAD_MAX:
        raise BadField(field, value, f"at most {PAYLOAD_MAX} bytes")
    return value


def six_axes(value: object) -> Axes:
    """Return `Axes`, or raise `BadField`."""
    if not isinstance(value, Axes):
        raise BadField("axes", value, "an Axes")
    return value


@dataclass(frozen=True, slots=True)
class Ping:
    """Ask for the same bytes back; on a retrofit it also feeds the watchdog."""

    op: ClassVar[Op] = Op.PING
    payload: bytes = b""

    def __post_init__(self) -> None:
        some_bytes("payload", self.payload)


@dataclass(frozen=True, slots=True)
class _Plain:
    """A request without a payload."""

    @property
    def payload(self) -> bytes:
        """Nothing."""
        return b""


@dataclass(frozen=True, slots=True)
class Stop(_Plain):
    """Ramp a move down. A `MoveSpeed` runs on: it is ended by one with all speeds zero."""

    op: ClassVar[Op] = Op.STOP


@dataclass(frozen=True, slots=True)
class Disable(_Plain):
    """Switch the motors' current off."""

    op: ClassVar[Op] = Op.DISABLE


@dataclass(frozen=True, slots=True)
class Enable(_Plain):
    """Switch the motors' current on."""

    op: ClassVar[Op] = Op.ENABLE


@dataclass(frozen=True, slots=True)
class Clear(_Plain):
    """Call the present position zero on every axis, in motion too."""

    op: ClassVar[Op] = Op.CLEAR


@dataclass(frozen=True, slots=True)
class Inputs(_Plain):
    """Ask for the digital inputs."""

    op: ClassVar[Op] = Op.INPUTS


@dataclass(frozen=True, slots=True)
class IsMoving(_Plain):
    """Ask which axes move. The answer can be none for 10 ms after a move was accepted."""

    op: ClassVar[Op] = Op.IS_MOVING


@dataclass(frozen=True, slots=True)
class Position(_Plain):
    """Ask for the position and the speed of every axis."""

    op: ClassVar[Op] = Op.POSITION


@dataclass(frozen=True, slots=True)
class SavePosition(_Plain):
    """Named by the firmware and not implemented: no answer comes."""

    op: ClassVar[Op] = Op.SAVE_POSITION


@dataclass(frozen=True, slots=True)
class LoadPosition(_Plain):
    """Named by the firmware and not implemented: no answer comes."""

    op: ClassVar[Op] = Op.LOAD_POSITION


@dataclass(frozen=True, slots=True)
class _OfAxes:
    """A request for all six axes."""

    axes: Axes

    def __post_init__(self) -> None:
        six_axes(self.axes)

    @property
    def payload(self) -> bytes:
        """The axes' 24 bytes."""
        return self.axes.to_bytes()


@dataclass(frozen=True, slots=True)
class MoveRelative(_OfAxes):
    """Move every axis by a distance; each ends when it ends. Answered at once."""

    op: ClassVar[Op] = Op.MOVE_RELATIVE


@dataclass(frozen=True, slots=True)
class MoveAbsolute(_OfAxes):
    """Move every axis to a position, which is not wrapped: 16 bits is as far as it goes."""

    op: ClassVar[Op] = Op.MOVE_ABSOLUTE


@dataclass(frozen=True, slots=True)
class MoveSpeed(_OfAxes):
    """Run every axis at a speed until told otherwise; the positions mean nothing.

    Nothing ends it when the host falls silent, and `Stop` does not either.
    """

    op: ClassVar[Op] = Op.MOVE_SPEED


@dataclass(frozen=True, slots=True)
class Outputs:
    """Set the digital outputs, one a bit."""

    op: ClassVar[Op] = Op.OUTPUTS
    value: int

    def __post_init__(self) -> None:
        whole("value", self.value, 0, BYTE_MAX)

    @property
    def payload(self) -> bytes:
        """The one byte."""
        return bytes((self.value,))


@dataclass(frozen=True, slots=True)
class _OfRobotId:
    """A request that the firmware answers with what it carries: it stores no id."""

    robot_id: bytes = b""

    def __post_init__(self) -> None:
        some_bytes("robot_id", self.robot_id)

    @property
    def payload(self) -> bytes:
        """The id, as it is."""
        return self.robot_id


@dataclass(frozen=True, slots=True)
class SetRobotId(_OfRobotId):
    """Name the robot. The firmware forgets it."""

    op: ClassVar[Op] = Op.SET_ROBOT_ID


@dataclass(frozen=True, slots=True)
class GetRobotId(_OfRobotId):
    """Ask for the robot's name, without bytes of one's own; the firmware would return those."""

    op: ClassVar[Op] = Op.GET_ROBOT_ID


Request: TypeAlias = (
    Ping
    | Stop
    | Disable
    | Enable
    | Clear
    | MoveRelative
    | MoveAbsolute
    | Outputs
    | Inputs
    | IsMoving
    | Position
    | MoveSpeed
    | SetRobotId
    | GetRobotId
    | SavePosition
    | LoadPosition
)
