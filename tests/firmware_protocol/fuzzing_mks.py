"""The two ends of a bus of MKS drives for the long fuzz run."""

import random

from chunks import events
from fuzzing import FuzzCase

from firmware_protocol import mks
from firmware_protocol.frames import pack

NODES = range(1, 7)
MOTIONS = sorted(mks.MOTION_CODES)


def _target(rng: random.Random) -> int:
    return rng.randint(-8388607, 8388607)


def _speed(rng: random.Random) -> int:
    return rng.randint(1, 3000)


def _acc(rng: random.Random) -> int:
    return rng.randrange(256)


MOVES = (mks.MoveAbsoluteAxis, mks.MoveRelativeAxis, mks.MoveAbsolutePulses, mks.MoveRelativePulses)
REQUESTS = (
    lambda rng: rng.choice(MOVES)(_target(rng), _speed(rng), _acc(rng)),
    lambda rng: mks.RunAtSpeed(rng.choice((-1, 1)) * _speed(rng), _acc(rng)),
    lambda rng: mks.RunFor(_speed(rng), _acc(rng), 10 * rng.randint(1, 0xFFFFFF)),
    lambda rng: mks.Stop(rng.choice(MOTIONS), _acc(rng)),
    lambda rng: rng.choice(
        (mks.EmergencyStop, mks.GoSynchronous, mks.Home, mks.ReadEncoder, mks.ReadState)
    )(),
    lambda rng: mks.Enable(rng.random() < 0.5),
    lambda rng: mks.SetMode(rng.choice(list(mks.Mode))),
    lambda rng: mks.SetCurrent(rng.randint(1, 5200), rng.random() < 0.5),
    lambda rng: mks.SetMicrosteps(rng.randint(1, 256)),
    lambda rng: mks.SetBitrate(rng.choice(list(mks.Bitrate))),
    lambda rng: mks.SilenceWatchdog(rng.getrandbits(32)),
    lambda rng: mks.ReportByItself(mks.Code.ENCODER, rng.getrandbits(16)),
    lambda rng: mks.ReadSetting(rng.choice((mks.Code.MODE, mks.Code.CURRENT, mks.Code.WATCHDOG))),
)
ANSWERS = (
    lambda rng: mks.EncoderRead(rng.getrandbits(48) - (1 << 47)),
    lambda rng: mks.SpeedRead(rng.randint(-3000, 3000)),
    lambda rng: mks.StateRead(rng.choice(list(mks.MotorState))),
    lambda rng: mks.VersionRead(True, 2, rng.randbytes(3)),
    lambda rng: mks.Status(rng.choice(MOTIONS), rng.choice(list(mks.Outcome))),
    lambda rng: mks.Status(mks.Code.ENABLE, rng.choice((mks.Outcome.DONE, mks.Outcome.FAILED))),
    lambda rng: mks.Status(mks.Code.MODE, mks.Outcome.DONE),
    lambda rng: mks.Status(mks.Code.REPORT, mks.Outcome.DONE, mks.Code.ENCODER),
)


def _host_saw_one(host: mks.Host) -> bool:
    found = any(
        not isinstance(event, mks.UnreadableFrame | mks.Foreign | mks.Overrun)
        for event in events(host)
    )
    for node in NODES:
        host.send(node, mks.MoveAbsoluteAxis(1, 1, 1))
        if not any(isinstance(request, mks.ReadEncoder) for request in host.unanswered(node)):
            host.send(node, mks.ReadEncoder())
    return found


def _device_saw_one(device: mks.Device) -> bool:
    return any(isinstance(event, mks.Asked) for event in events(device))


HOST = FuzzCase(
    "mks host",
    lambda: mks.Host(NODES),
    lambda rng: pack(mks.encode(rng.choice(NODES), rng.choice(ANSWERS)(rng))),
    _host_saw_one,
)
DEVICE = FuzzCase(
    "mks device",
    lambda: mks.Device(1),
    lambda rng: pack(mks.encode(rng.choice((0, 1)), rng.choice(REQUESTS)(rng))),
    _device_saw_one,
)
