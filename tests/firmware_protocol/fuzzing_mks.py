"""The two ends of a bus of MKS drives for the long fuzz run."""

import random

from fuzzing import FuzzCase
from mks_strategies import events

from firmware_protocol.frames import pack
from firmware_protocol.mks import (
    MOTION_CODES,
    Asked,
    Bitrate,
    Code,
    Device,
    EmergencyStop,
    Enable,
    EncoderRead,
    Foreign,
    Garbled,
    GoSynchronous,
    Home,
    Host,
    Mode,
    MotorState,
    MoveAbsoluteAxis,
    MoveAbsolutePulses,
    MoveRelativeAxis,
    MoveRelativePulses,
    Outcome,
    Overrun,
    ReadEncoder,
    ReadSetting,
    ReadState,
    ReportByItself,
    RunAtSpeed,
    RunFor,
    SetBitrate,
    SetCurrent,
    SetMicrosteps,
    SetMode,
    SilenceWatchdog,
    SpeedRead,
    StateRead,
    Status,
    Stop,
    VersionRead,
    encode,
)

NODES = range(1, 7)
MOTIONS = sorted(MOTION_CODES)


def _target(rng: random.Random) -> int:
    return rng.randint(-8388607, 8388607)


def _speed(rng: random.Random) -> int:
    return rng.randint(1, 3000)


def _acc(rng: random.Random) -> int:
    return rng.randrange(256)


MOVES = (MoveAbsoluteAxis, MoveRelativeAxis, MoveAbsolutePulses, MoveRelativePulses)
REQUESTS = (
    lambda rng: rng.choice(MOVES)(_target(rng), _speed(rng), _acc(rng)),
    lambda rng: RunAtSpeed(rng.choice((-1, 1)) * _speed(rng), _acc(rng)),
    lambda rng: RunFor(_speed(rng), _acc(rng), 10 * rng.randint(1, 0xFFFFFF)),
    lambda rng: Stop(rng.choice(MOTIONS), _acc(rng)),
    lambda rng: rng.choice((EmergencyStop, GoSynchronous, Home, ReadEncoder, ReadState))(),
    lambda rng: Enable(rng.random() < 0.5),
    lambda rng: SetMode(rng.choice(list(Mode))),
    lambda rng: SetCurrent(rng.randint(1, 5200), rng.random() < 0.5),
    lambda rng: SetMicrosteps(rng.randint(1, 256)),
    lambda rng: SetBitrate(rng.choice(list(Bitrate))),
    lambda rng: SilenceWatchdog(rng.getrandbits(32)),
    lambda rng: ReportByItself(Code.ENCODER, rng.getrandbits(16)),
    lambda rng: ReadSetting(rng.choice((Code.MODE, Code.CURRENT, Code.WATCHDOG))),
)
ANSWERS = (
    lambda rng: EncoderRead(rng.getrandbits(48) - (1 << 47)),
    lambda rng: SpeedRead(rng.randint(-3000, 3000)),
    lambda rng: StateRead(rng.choice(list(MotorState))),
    lambda rng: VersionRead(True, 2, rng.randbytes(3)),
    lambda rng: Status(rng.choice(MOTIONS), rng.choice(list(Outcome))),
    lambda rng: Status(Code.ENABLE, rng.choice((Outcome.DONE, Outcome.FAILED))),
    lambda rng: Status(Code.MODE, Outcome.DONE),
    lambda rng: Status(Code.REPORT, Outcome.DONE, Code.ENCODER),
)


def _host_saw_one(host: Host) -> bool:
    found = any(not isinstance(event, Garbled | Foreign | Overrun) for event in events(host))
    for node in NODES:
        host.send(node, MoveAbsoluteAxis(1, 1, 1))
        if not any(isinstance(request, ReadEncoder) for request in host.unanswered(node)):
            host.send(node, ReadEncoder())
    return found


def _device_saw_one(device: Device) -> bool:
    return any(isinstance(event, Asked) for event in events(device))


HOST = FuzzCase(
    "mks host",
    lambda: Host(NODES),
    lambda rng: pack(encode(rng.choice(NODES), rng.choice(ANSWERS)(rng))),
    _host_saw_one,
)
DEVICE = FuzzCase(
    "mks device",
    lambda: Device(1),
    lambda rng: pack(encode(rng.choice((0, 1)), rng.choice(REQUESTS)(rng))),
    _device_saw_one,
)
