"""The SUPER protocol's two ends for the long fuzz run."""

import random

from fuzzing import FuzzCase

from firmware_protocol.robko01 import (
    Acknowledged,
    Answered,
    Axes,
    Busy,
    Clear,
    Device,
    Disable,
    Enable,
    GetRobotId,
    Host,
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
    Overrun,
    Ping,
    Pong,
    Position,
    Positions,
    RobotId,
    SavePosition,
    SetRobotId,
    Status,
    Stop,
    Stray,
    Unreadable,
)
from firmware_protocol.robko01.messages import encode_answer, encode_request


def _byte(rng: random.Random) -> int:
    return rng.randrange(256)


def _some(rng: random.Random) -> bytes:
    return rng.randbytes(rng.randint(0, 26))


def _axes(rng: random.Random) -> Axes:
    six = [tuple(rng.randint(-32768, 32767) for _ in range(6)) for _ in range(2)]
    return Axes(*six)


PLAIN = (Stop, Disable, Enable, Clear, Inputs, IsMoving, Position, SavePosition, LoadPosition)
REQUESTS = (
    lambda rng: rng.choice(PLAIN)(),
    lambda rng: rng.choice((Ping, SetRobotId, GetRobotId))(_some(rng)),
    lambda rng: rng.choice((MoveRelative, MoveAbsolute, MoveSpeed))(_axes(rng)),
    lambda rng: Outputs(_byte(rng)),
)
ANSWERS = (
    lambda rng: Acknowledged(rng.choice(list(Op)), rng.choice(list(Status)[1:])),
    lambda rng: Busy(rng.choice(list(Op)), _byte(rng)),
    lambda rng: rng.choice((OutputsSet, InputsRead, Moving))(_byte(rng)),
    lambda rng: Positions(_axes(rng)),
    lambda rng: RobotId(rng.choice((Op.SET_ROBOT_ID, Op.GET_ROBOT_ID)), _some(rng)),
    lambda rng: Pong(_some(rng)),
)


def _host_saw_one(host: Host) -> bool:
    seen = False
    while (event := host.next_event()) is not None:
        seen |= isinstance(event, Answered | Stray)
    if host.outstanding is None:
        host.send(Position())
    return seen


def _device_saw_one(device: Device) -> bool:
    seen = False
    while (event := device.next_event()) is not None:
        if not isinstance(event, Unreadable | Overrun):
            seen = True
            device.send(Acknowledged(event.op, Status.ERROR))
    return seen


HOST = FuzzCase(
    "robko01 host", Host, lambda rng: encode_answer(rng.choice(ANSWERS)(rng)), _host_saw_one
)
DEVICE = FuzzCase(
    "robko01 device",
    Device,
    lambda rng: encode_request(rng.choice(REQUESTS)(rng)),
    _device_saw_one,
)
