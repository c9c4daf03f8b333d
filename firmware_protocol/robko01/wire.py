"""The meaning of SUPER frames: requests and answers out of them, one table each way."""

from __future__ import annotations

from collections.abc import Callable

from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.robko01.frames import Frame, Kind, frame_bytes
from firmware_protocol.robko01.messages import (
    AXES_BYTES,
    VALUED,
    Acknowledged,
    Answer,
    Axes,
    Busy,
    Clear,
    Disable,
    Enable,
    GetRobotId,
    Inputs,
    InputsRead,
    IsMoving,
    LoadPosition,
    MoveAbsolute,
    MoveRelative,
    MoveSpeed,
    Moving,
    Op,
    Outputs,
    OutputsSet,
    Ping,
    Pong,
    Position,
    Positions,
    Request,
    RobotId,
    SavePosition,
    SetRobotId,
    Status,
    Stop,
)


def encode_request(request: Request, *, counts_check: bool = False) -> bytes:
    """Return the frame of a request."""
    return frame_bytes(Kind.REQUEST, request.op, request.payload, counts_check=counts_check)


def encode_answer(answer: Answer, *, counts_check: bool = False) -> bytes:
    """Return the frame of an answer."""
    rest = bytes((answer.status,)) + answer.payload
    return frame_bytes(Kind.ANSWER, answer.op, rest, counts_check=counts_check)


def decode_request(frame: Frame) -> Request:
    """Read a request; raises `RemoteProtocolError`."""
    if frame.kind is not Kind.REQUEST:
        raise RemoteProtocolError("an answer, where requests belong")
    op = _operation(frame)
    return _REQUESTS[op](op, frame.rest)


def decode_answer(frame: Frame) -> Answer:
    """Read an answer; raises `RemoteProtocolError`."""
    if frame.kind is not Kind.ANSWER:
        raise RemoteProtocolError("a request, where answers belong")
    op = _operation(frame)
    number, payload = frame.rest[0], frame.rest[1:]
    if number not in tuple(Status):
        raise RemoteProtocolError(f"no status has the number {number}")
    status = Status(number)
    if status is Status.OK and op in _VALUES and (payload or op in VALUED):
        return _VALUES[op](op, payload)
    if status is Status.BUSY and payload:
        return Busy(op, _one_byte(op, payload))
    _nothing(op, payload)
    return Acknowledged(op, status)


def _operation(frame: Frame) -> Op:
    if frame.op not in tuple(Op):
        raise RemoteProtocolError(f"no operation has the number {frame.op}")
    return Op(frame.op)


def _nothing(op: Op, payload: bytes) -> None:
    if payload:
        raise RemoteProtocolError(f"{op.name} with {len(payload)} bytes where none belong")


def _one_byte(op: Op, payload: bytes) -> int:
    if len(payload) != 1:
        raise RemoteProtocolError(f"{op.name} with {len(payload)} bytes where one belongs")
    return payload[0]


def _axes(op: Op, payload: bytes) -> Axes:
    if len(payload) != AXES_BYTES:
        wanted = f"where {AXES_BYTES} belong"
        raise RemoteProtocolError(f"{op.name} with {len(payload)} bytes {wanted}")
    return Axes.from_bytes(payload)


def _plain(request: Callable[[], Request]) -> Callable[[Op, bytes], Request]:
    def read(op: Op, payload: bytes) -> Request:
        _nothing(op, payload)
        return request()

    return read


def _move(request: Callable[[Axes], Request]) -> Callable[[Op, bytes], Request]:
    return lambda op, payload: request(_axes(op, payload))


def _ok_byte(answer: Callable[[int], Answer]) -> Callable[[Op, bytes], Answer]:
    return lambda op, payload: answer(_one_byte(op, payload))


_REQUESTS: dict[Op, Callable[[Op, bytes], Request]] = {
    Op.PING: lambda _, payload: Ping(payload),
    Op.STOP: _plain(Stop),
    Op.DISABLE: _plain(Disable),
    Op.ENABLE: _plain(Enable),
    Op.CLEAR: _plain(Clear),
    Op.MOVE_RELATIVE: _move(MoveRelative),
    Op.MOVE_ABSOLUTE: _move(MoveAbsolute),
    Op.OUTPUTS: lambda op, payload: Outputs(_one_byte(op, payload)),
    Op.INPUTS: _plain(Inputs),
    Op.IS_MOVING: _plain(IsMoving),
    Op.POSITION: _plain(Position),
    Op.MOVE_SPEED: _move(MoveSpeed),
    Op.SET_ROBOT_ID: lambda _, payload: SetRobotId(payload),
    Op.GET_ROBOT_ID: lambda _, payload: GetRobotId(payload),
    Op.SAVE_POSITION: _plain(SavePosition),
    Op.LOAD_POSITION: _plain(LoadPosition),
}

_VALUES: dict[Op, Callable[[Op, bytes], Answer]] = {
    Op.PING: lambda _, payload: Pong(payload),
    Op.OUTPUTS: _ok_byte(OutputsSet),
    Op.INPUTS: _ok_byte(InputsRead),
    Op.IS_MOVING: _ok_byte(Moving),
    Op.POSITION: lambda op, payload: Positions(_axes(op, payload)),
    Op.SET_ROBOT_ID: RobotId,
    Op.GET_ROBOT_ID: RobotId,
}
"""How the payload of an answer is read when its status is OK."""
