"""What a Robko 01 answers, as values checked when they are built: operation, status, payload.

Everything here raises `BadField` (a `LocalProtocolError`) that names the field, the value and
the range.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from firmware_protocol.errors import BadField, whole
from firmware_protocol.robko01.requests import BYTE_MAX, six_axes, some_bytes
from firmware_protocol.robko01.values import AXES, Axes, Op, Status

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
