"""The small values of the SUPER protocol: operations, status, the six axes, positions that wrap.

Operations and status: robko01/fw_arduino_lib src/OperationsCodes.h and src/SUPER.h.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import ClassVar, TypeAlias

from firmware_protocol.errors import BadField, whole
from firmware_protocol.robko01.frames import PAYLOAD_MAX

AXES = 6
AXIS_NAMES = ("base", "shoulder", "elbow", "left differential", "right differential", "gripper")
WORD_MIN, WORD_MAX = -(1 << 15), (1 << 15) - 1
_TURN = 1 << 16
_TWELVE = struct.Struct(f"<{2 * AXES}h")
AXES_BYTES = _TWELVE.size


class Op(IntEnum):
    """What a request asks for; its answer carries the same number."""

    PING = 1
    STOP = 2
    DISABLE = 3
    ENABLE = 4
    CLEAR = 5
    MOVE_RELATIVE = 6
    MOVE_ABSOLUTE = 7
    OUTPUTS = 8
    INPUTS = 9
    IS_MOVING = 10
    POSITION = 11
    MOVE_SPEED = 12
    SET_ROBOT_ID = 13
    GET_ROBOT_ID = 14
    SAVE_POSITION = 15
    LOAD_POSITION = 16


class Status(IntEnum):
    """How a request fared."""

    OK = 1
    ERROR = 2
    """Refused; a move is while the motors are disabled."""
    BUSY = 3
    """Refused: the arm is moving."""
    TIMEOUT = 4


def six_words(field: str, words: object) -> tuple[int, ...]:
    """Return six whole numbers in signed 16 bit, or raise `BadField` naming the one."""
    if not isinstance(words, tuple | list) or len(words) != AXES:
        raise BadField(field, words, f"{AXES} whole numbers, one an axis")
    return tuple(
        whole(f"{field}[{index}]", word, WORD_MIN, WORD_MAX) for index, word in enumerate(words)
    )


@dataclass(frozen=True, slots=True)
class Axes:
    """A position in steps and a speed in steps a second for each axis, base to gripper.

    In a move the position is where to go, or how far; in an answer where the axis is, and both
    have wrapped to 16 bits. Raises `BadField`.
    """

    positions_steps: tuple[int, ...]
    speeds_steps_s: tuple[int, ...] = (0,) * AXES

    def __post_init__(self) -> None:
        for field in ("positions_steps", "speeds_steps_s"):
            object.__setattr__(self, field, six_words(field, getattr(self, field)))

    @classmethod
    def from_bytes(cls, data: bytes) -> Axes:
        """Read the 24 bytes: position, speed, position, speed, ..., low byte first."""
        words = _TWELVE.unpack(data)
        return cls(words[::2], words[1::2])

    def to_bytes(self) -> bytes:
        """Return the 24 bytes."""
        pairs = zip(self.positions_steps, self.speeds_steps_s, strict=True)
        return _TWELVE.pack(*(word for pair in pairs for word in pair))


def wrap(position_steps: int) -> int:
    """Return a position as the arm reports it: in 16 bits, wrapped."""
    return (position_steps - WORD_MIN) % _TURN + WORD_MIN


def unwrap(reported_steps: int, near_steps: int) -> int:
    """Return the position nearest to a known one among those that are reported alike.

    Right as long as the axis is less than 32768 steps from where it is believed to be.
    """
    return near_steps + wrap(reported_steps - near_steps)


# What a host asks of a Robko 01, as values checked when they are built.
#
# Each has its operation and its payload. Everything here raises `BadField` (a
# `LocalProtocolError`) that names the field, the value and the range.

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


# What a Robko 01 answers, as values checked when they are built: operation, status, payload.
#
# Everything here raises `BadField` (a `LocalProtocolError`) that names the field, the value and
# the range.

VALUED = frozenset(
    (Op.PING, Op.INPUTS, Op.IS_MOVING, Op.POSITION, Op.SET_ROBOT_ID, Op.GET_ROBOT_ID)
)
"""Operations whose answer, when it is OK, has a form of its own and never is an `Acknowledged`.

`Op.OUTPUTS` is not among them: some firmware answers it with the byte, some with nothing.
"""
_ID_OPS = (Op.SET_ROBOT_ID, Op.GET_ROBOT_ID)


def _operation(value: object) -> Op:
    return Op(whole("op", value, min(Op), max(Op)))


@dataclass(frozen=True, slots=True)
class Acknowledged:
    """A status and nothing more."""

    op: Op
    status: Status = Status.OK

    def __post_init__(self) -> None:
        object.__setattr__(self, "op", _operation(self.op))
        status = Status(whole("status", self.status, min(Status), max(Status)))
        object.__setattr__(self, "status", status)
        if self.status is Status.OK and self.op in VALUED:
            raise BadField("status", status, f"other than OK: {self.op.name} answers with a value")

    @property
    def payload(self) -> bytes:
        """Nothing."""
        return b""


@dataclass(frozen=True, slots=True)
class _Ok:
    """An answer that comes with a status of OK alone."""

    status: ClassVar[Status] = Status.OK


@dataclass(frozen=True, slots=True)
class _OfByte:
    """An answer whose payload is one byte."""

    value: int

    def __post_init__(self) -> None:
        whole("value", self.value, 0, BYTE_MAX)

    @property
    def payload(self) -> bytes:
        """The one byte."""
        return bytes((self.value,))


@dataclass(frozen=True, slots=True)
class Busy:
    """Refused, because axes are moving: bit n of `moving` is axis n."""

    status: ClassVar[Status] = Status.BUSY
    op: Op
    moving: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "op", _operation(self.op))
        whole("moving", self.moving, 0, BYTE_MAX)

    @property
    def payload(self) -> bytes:
        """The mask."""
        return bytes((self.moving,))


@dataclass(frozen=True, slots=True)
class Pong(_Ok):
    """The bytes of a `Ping`."""

    op: ClassVar[Op] = Op.PING
    payload: bytes = b""

    def __post_init__(self) -> None:
        some_bytes("payload", self.payload)


@dataclass(frozen=True, slots=True)
class OutputsSet(_OfByte, _Ok):
    """The outputs as they are now. An `Acknowledged` says the same without the byte."""

    op: ClassVar[Op] = Op.OUTPUTS


@dataclass(frozen=True, slots=True)
class InputsRead(_OfByte, _Ok):
    """The inputs, one a bit."""

    op: ClassVar[Op] = Op.INPUTS


@dataclass(frozen=True, slots=True)
class Moving(_OfByte, _Ok):
    """Which axes move: bit n of `value` is axis n."""

    op: ClassVar[Op] = Op.IS_MOVING

    @property
    def axes(self) -> tuple[int, ...]:
        """The numbers of the axes that move."""
        return tuple(axis for axis in range(AXES) if self.value >> axis & 1)


@dataclass(frozen=True, slots=True)
class Positions(_Ok):
    """Where every axis is, wrapped to 16 bits (`unwrap`), and how fast it goes."""

    op: ClassVar[Op] = Op.POSITION
    axes: Axes

    def __post_init__(self) -> None:
        six_axes(self.axes)

    @property
    def payload(self) -> bytes:
        """The axes' 24 bytes."""
        return self.axes.to_bytes()


@dataclass(frozen=True, slots=True)
class RobotId(_Ok):
    """The answer to `SetRobotId` or `GetRobotId`."""

    op: Op
    robot_id: bytes = b""

    def __post_init__(self) -> None:
        object.__setattr__(self, "op", _operation(self.op))
        if self.op not in _ID_OPS:
            raise BadField("op", self.op, "SET_ROBOT_ID or GET_ROBOT_ID")
        some_bytes("robot_id", self.robot_id)

    @property
    def payload(self) -> bytes:
        """The id, as it is."""
        return self.robot_id


Answer: TypeAlias = (
    Acknowledged | Busy | Pong | OutputsSet | InputsRead | Moving | Positions | RobotId
)
