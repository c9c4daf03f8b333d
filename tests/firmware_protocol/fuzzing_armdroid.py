"""The Armdroid codec's two ends for the long fuzz run."""

import random

from armdroid_strategies import events
from fuzzing import FuzzCase

from firmware_protocol.armdroid import (
    ArgumentsReported,
    Completed,
    Device,
    DriveAll,
    DriveOne,
    HomeToOffsets,
    Host,
    Ignored,
    InterfaceKind,
    InterfaceReported,
    OffsetsReported,
    Overrun,
    ReportArguments,
    ReportOffsets,
    SetSpeed,
    SpeedReported,
    Stray,
    Torque,
    TorqueReported,
    Version,
    VersionReported,
    Welcome,
    ZeroOffsets,
)
from firmware_protocol.armdroid.messages import encode_answer, encode_command


def _steps(rng: random.Random, count: int = 6) -> tuple[int, ...]:
    return tuple(rng.randint(-32768, 32767) for _ in range(count))


COMMANDS = (
    lambda rng: DriveOne(rng.randint(1, 6), *_steps(rng, 1)),
    lambda rng: DriveAll(_steps(rng)),
    lambda rng: SetSpeed(rng.randint(1, 1250)),
    lambda rng: Torque(rng.random() < 0.5),
    lambda rng: HomeToOffsets(),
    lambda rng: ReportOffsets(),
    lambda rng: ZeroOffsets(),
    lambda rng: Version(),
    lambda rng: InterfaceKind(),
    lambda rng: ReportArguments(),
)
ANSWERS = (
    lambda rng: OffsetsReported(_steps(rng)),
    lambda rng: SpeedReported(*_steps(rng, 1)),
    lambda rng: TorqueReported(rng.random() < 0.5),
    lambda rng: VersionReported(),
    lambda rng: VersionReported("1.3", None),
    lambda rng: InterfaceReported(),
    lambda rng: ArgumentsReported(_steps(rng, 5), *_steps(rng, 1)),
    lambda rng: Welcome(),
)


def _host_saw_one(host: Host) -> bool:
    found = any(isinstance(event, Completed | Stray | Welcome) for event in events(host))
    if host.outstanding is None:
        host.send(ReportOffsets())
    return found


def _device_saw_one(device: Device) -> bool:
    return any(not isinstance(event, Ignored | Overrun) for event in events(device))


MOST_HELD = 256 * 80 + 80
HOST = FuzzCase(
    "armdroid host",
    Host,
    lambda rng: encode_answer(rng.choice(ANSWERS)(rng)),
    _host_saw_one,
    MOST_HELD,
    most_good=2,
)
DEVICE = FuzzCase(
    "armdroid device",
    Device,
    lambda rng: encode_command(rng.choice(COMMANDS)(rng)),
    _device_saw_one,
    MOST_HELD,
    most_good=2,
)
