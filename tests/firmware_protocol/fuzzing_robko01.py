"""The SUPER protocol's two ends for the long fuzz run."""

import random

from fuzzing import FuzzCase
from robko01_strategies import PLAIN

from firmware_protocol import robko01
from firmware_protocol.robko01.messages import encode_answer, encode_request


def _byte(rng: random.Random) -> int:
    return rng.randrange(256)


def _some(rng: random.Random) -> bytes:
    return rng.randbytes(rng.randint(0, 26))


def _axes(rng: random.Random) -> robko01.Axes:
    six = [tuple(rng.randint(-32768, 32767) for _ in range(6)) for _ in range(2)]
    return robko01.Axes(*six)


REQUESTS = (
    lambda rng: rng.choice(PLAIN)(),
    lambda rng: rng.choice((robko01.Ping, robko01.SetRobotId, robko01.GetRobotId))(_some(rng)),
    lambda rng: rng.choice((robko01.MoveRelative, robko01.MoveAbsolute, robko01.MoveSpeed))(
        _axes(rng)
    ),
    lambda rng: robko01.Outputs(_byte(rng)),
)
ANSWERS = (
    lambda rng: robko01.Acknowledged(
        rng.choice(list(robko01.Op)), rng.choice(list(robko01.Status)[1:])
    ),
    lambda rng: robko01.Busy(rng.choice(list(robko01.Op)), _byte(rng)),
    lambda rng: rng.choice((robko01.OutputsSet, robko01.InputsRead, robko01.Moving))(_byte(rng)),
    lambda rng: robko01.Positions(_axes(rng)),
    lambda rng: robko01.RobotId(
        rng.choice((robko01.Op.SET_ROBOT_ID, robko01.Op.GET_ROBOT_ID)), _some(rng)
    ),
    lambda rng: robko01.Pong(_some(rng)),
)


def _host_saw_one(host: robko01.Host) -> bool:
    seen = False
    while (event := host.next_event()) is not None:
        seen |= isinstance(event, robko01.Answered | robko01.Stray)
    if host.outstanding is None:
        host.send(robko01.Position())
    return seen


def _device_saw_one(device: robko01.Device) -> bool:
    seen = False
    while (event := device.next_event()) is not None:
        if not isinstance(event, robko01.Unreadable | robko01.Overrun):
            seen = True
            device.send(robko01.Acknowledged(event.op, robko01.Status.ERROR))
    return seen


HOST = FuzzCase(
    "robko01 host", robko01.Host, lambda rng: encode_answer(rng.choice(ANSWERS)(rng)), _host_saw_one
)
DEVICE = FuzzCase(
    "robko01 device",
    robko01.Device,
    lambda rng: encode_request(rng.choice(REQUESTS)(rng)),
    _device_saw_one,
)
