"""Requests and answers of the Robko 01, checked when built, and their frames.

A message has an operation and a payload in one of four forms: nothing, one byte, the six axes, or
any bytes. Building a message may raise `BadField` (a `LocalProtocolError`), decoding one may raise
`RemoteProtocolError`.

Operations and status: robko01/fw_arduino_lib src/OperationsCodes.h and src/SUPER.h.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from enum import IntEnum
from typing import ClassVar, Self, TypeAlias, get_args

from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.fields import (
    BYTE,
    INT16,
    an_instance,
    message,
    numbered,
    row_of,
    some_bytes,
)
from firmware_protocol.robko01.frames import (
    PAYLOAD_MAX,
    Kind,
    SuperFrame,
    frame_bytes,
)

AXES = 6
AXIS_NAMES = ("base", "shoulder", "elbow", "left differential", "right differential", "gripper")
_TWELVE = struct.Struct(f"<{2 * AXES}h")


class Op(IntEnum):
    """A request's operation; the answer has the same number.

    The firmware also has a name that it only echoes (13, 14), and numbers for stored positions that
    it does not carry out (15, 16). Neither end here uses them.
    """

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


class Status(IntEnum):
    """The outcome of a request."""

    OK = 1
    ERROR = 2
    """Refused, for example a move while the motors are disabled."""
    BUSY = 3
    """Refused: the arm is moving."""
    TIMEOUT = 4


_PAYLOAD = some_bytes(PAYLOAD_MAX)
_SIX_WORDS = row_of(INT16, AXES, f"{AXES} whole numbers, one an axis")


@message(positions_steps=_SIX_WORDS, speeds_steps_s=_SIX_WORDS)
class Axes:
    """A position in steps and a speed in steps per second for each axis, base to gripper.

    In a move the position is the target; in an answer, the axis's position. In answers both
    numbers are wrapped to 16 bits. Raises `BadField`.
    """

    positions_steps: tuple[int, ...]
    speeds_steps_s: tuple[int, ...] = (0,) * AXES

    @classmethod
    def from_bytes(cls, data: bytes) -> Axes:
        """Decode the 24 bytes: position, speed, position, speed, ..., low byte first."""
        words = _TWELVE.unpack(data)
        return cls(words[::2], words[1::2])

    def to_bytes(self) -> bytes:
        """Return the 24 bytes."""
        pairs = zip(self.positions_steps, self.speeds_steps_s, strict=True)
        return _TWELVE.pack(*(word for pair in pairs for word in pair))


# The four forms of a payload, in requests and answers.


def _require_length(op: Op, payload: bytes, length: int, belong: str) -> bytes:
    if len(payload) != length:
        raise RemoteProtocolError(f"{op.name} of length {len(payload)} where {belong}")
    return payload


@message()
class _OfNothing:
    """A message without a payload."""

    op: ClassVar[Op]

    @property
    def payload(self) -> bytes:
        """Nothing."""
        return b""

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Decode the message. Raises `RemoteProtocolError`."""
        _require_length(cls.op, payload, 0, "none belong")
        return cls()


@message(value=BYTE)
class _OfByte:
    """A message whose payload is one byte."""

    op: ClassVar[Op]
    value: int

    @property
    def payload(self) -> bytes:
        """The one byte."""
        return bytes((self.value,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Decode the message. Raises `RemoteProtocolError`."""
        return cls(_require_length(cls.op, payload, 1, "one belongs")[0])


@message(axes=an_instance(Axes, "an Axes"))
class _OfAxes:
    """A message about all six axes."""

    op: ClassVar[Op]
    axes: Axes

    @property
    def payload(self) -> bytes:
        """The axes' 24 bytes."""
        return self.axes.to_bytes()

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Decode the message. Raises `RemoteProtocolError`."""
        data = _require_length(cls.op, payload, _TWELVE.size, f"{_TWELVE.size} belong")
        return cls(Axes.from_bytes(data))


@message(payload=_PAYLOAD)
class _OfBytes:
    """A message of any bytes."""

    op: ClassVar[Op]
    payload: bytes = b""

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Decode the message."""
        return cls(payload)


# The requests.


class Ping(_OfBytes):
    """Ask for the same bytes back; on a retrofit this also feeds the watchdog."""

    op = Op.PING


class Stop(_OfNothing):
    """Ramp a move down. A `MoveSpeed` continues; end it with one whose speeds are all zero."""

    op = Op.STOP


class Disable(_OfNothing):
    """Switch the motor current off."""

    op = Op.DISABLE


class Enable(_OfNothing):
    """Switch the motor current on."""

    op = Op.ENABLE


class Clear(_OfNothing):
    """Set the present position of every axis as zero, even in motion."""

    op = Op.CLEAR


class Inputs(_OfNothing):
    """Ask for the digital inputs."""

    op = Op.INPUTS


class IsMoving(_OfNothing):
    """Ask which axes move. For 10 ms after accepting a move, the arm may answer "none"."""

    op = Op.IS_MOVING


class Position(_OfNothing):
    """Ask for the position and the speed of every axis."""

    op = Op.POSITION


class MoveRelative(_OfAxes):
    """Move every axis by a distance, as fast as its last `MoveAbsolute`."""

    op = Op.MOVE_RELATIVE


class MoveAbsolute(_OfAxes):
    """Move every axis to a position, uncoordinated, limited to 16 bits without wrapping."""

    op = Op.MOVE_ABSOLUTE


class MoveSpeed(_OfAxes):
    """Run every axis at a speed until the next command; the positions have no meaning.

    It continues if the connection is lost, and `Stop` does not end it either.
    """

    op = Op.MOVE_SPEED


class Outputs(_OfByte):
    """Set the digital outputs, one per bit."""

    op = Op.OUTPUTS


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
)


# The answers: a status, and a payload if the operation has one.

# Operations whose OK answer always has a payload and is never an `Acknowledged`.
#
# `Op.OUTPUTS` is not among them: some firmware answers with the byte, some without.
VALUED = frozenset((Op.PING, Op.INPUTS, Op.IS_MOVING, Op.POSITION))


@message(op=numbered(Op), status=numbered(Status))
class Acknowledged:
    """A status without a payload."""

    payload: ClassVar[bytes] = b""
    op: Op
    status: Status = Status.OK

    def __post_init__(self) -> None:
        if self.status is Status.OK and self.op in VALUED:
            raise BadField(
                "status", self.status, f"other than OK: {self.op.name} answers with a value"
            )


@message(op=numbered(Op), moving=BYTE)
class Busy:
    """A refusal because axes are moving: bit n of `moving` is axis n."""

    status: ClassVar[Status] = Status.BUSY
    op: Op
    moving: int

    @property
    def payload(self) -> bytes:
        """The bit mask."""
        return bytes((self.moving,))


class Pong(_OfBytes):
    """The bytes of a `Ping`."""

    op, status = Op.PING, Status.OK


class OutputsSet(_OfByte):
    """The present outputs. Some firmware sends an `Acknowledged` without the byte instead."""

    op, status = Op.OUTPUTS, Status.OK


class InputsRead(_OfByte):
    """The inputs, one per bit."""

    op, status = Op.INPUTS, Status.OK


class Moving(_OfByte):
    """Which axes move: bit n of `value` is axis n."""

    op, status = Op.IS_MOVING, Status.OK


class Positions(_OfAxes):
    """The position of every axis, wrapped to 16 bits, and its speed."""

    op, status = Op.POSITION, Status.OK


Answer: TypeAlias = Acknowledged | Busy | Pong | OutputsSet | InputsRead | Moving | Positions


# Encoding and decoding.

_REQUESTS: dict[Op, type[Request]] = {kind.op: kind for kind in get_args(Request)}
# Decoders for the payloads of OK answers.
_VALUES: dict[Op, Callable[[bytes], Answer]] = {
    kind.op: kind.read for kind in (Pong, OutputsSet, InputsRead, Moving, Positions)
}


def encode_request(request: Request) -> bytes:
    """Return the frame of a request."""
    return frame_bytes(Kind.REQUEST, request.op, request.payload)


def encode_answer(answer: Answer) -> bytes:
    """Return the frame of an answer."""
    rest = bytes((answer.status,)) + answer.payload
    return frame_bytes(Kind.ANSWER, answer.op, rest)


def decode_request(frame: SuperFrame) -> Request:
    """Decode a request. Raises `RemoteProtocolError`."""
    if frame.kind is not Kind.REQUEST:
        raise RemoteProtocolError("an answer, where requests belong")
    return _REQUESTS[_named(frame)].read(frame.rest)


def decode_answer(frame: SuperFrame) -> Answer:
    """Decode an answer. Raises `RemoteProtocolError`."""
    if frame.kind is not Kind.ANSWER:
        raise RemoteProtocolError("a request, where answers belong")
    op = _named(frame)
    number, payload = frame.rest[0], frame.rest[1:]
    try:
        status = Status(number)
    except ValueError:
        raise RemoteProtocolError(f"no status has the number {number}") from None
    if status is Status.OK and op in _VALUES and (payload or op in VALUED):
        return _VALUES[op](payload)
    if status is Status.BUSY and payload:
        return Busy(op, _require_length(op, payload, 1, "one belongs")[0])
    _require_length(op, payload, 0, "none belong")
    return Acknowledged(op, status)


def _named(frame: SuperFrame) -> Op:
    try:
        return Op(frame.op)
    except ValueError:
        raise RemoteProtocolError(f"no operation has the number {frame.op}") from None
