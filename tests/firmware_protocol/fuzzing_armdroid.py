"""The Armdroid codec's two ends for the long fuzz run."""

import random

from armdroid_strategies import events
from fuzzing import FuzzCase

from firmware_protocol import armdroid
from firmware_protocol.armdroid.messages import encode_answer, encode_command


def _steps(rng: random.Random, count: int = 6) -> tuple[int, ...]:
    return tuple(rng.randint(-32768, 32767) for _ in range(count))


COMMANDS = (
    lambda rng: armdroid.DriveOne(rng.randint(1, 6), *_steps(rng, 1)),
    lambda rng: armdroid.DriveAll(_steps(rng)),
    lambda rng: armdroid.SetSpeed(rng.randint(1, 1250)),
    lambda rng: armdroid.Torque(rng.random() < 0.5),
    lambda rng: armdroid.HomeToOffsets(),
    lambda rng: armdroid.ReportOffsets(),
    lambda rng: armdroid.ZeroOffsets(),
    lambda rng: armdroid.Version(),
    lambda rng: armdroid.InterfaceKind(),
    lambda rng: armdroid.ReportArguments(),
)
ANSWERS = (
    lambda rng: armdroid.OffsetsReported(_steps(rng)),
    lambda rng: armdroid.SpeedReported(*_steps(rng, 1)),
    lambda rng: armdroid.TorqueReported(rng.random() < 0.5),
    lambda rng: armdroid.VersionReported(),
    lambda rng: armdroid.VersionReported("1.3", None),
    lambda rng: armdroid.InterfaceReported(),
    lambda rng: armdroid.ArgumentsReported(_steps(rng, 5), *_steps(rng, 1)),
    lambda rng: armdroid.Welcome(),
)


def _host_saw_one(host: armdroid.Host) -> bool:
    found = any(
        isinstance(event, armdroid.Completed | armdroid.Stray | armdroid.Welcome)
        for event in events(host)
    )
    if host.outstanding is None:
        host.send(armdroid.ReportOffsets())
    return found


def _device_saw_one(device: armdroid.Device) -> bool:
    return any(
        not isinstance(event, armdroid.Ignored | armdroid.Overrun) for event in events(device)
    )


MOST_HELD = 256 * 80 + 80
HOST = FuzzCase(
    "armdroid host",
    armdroid.Host,
    lambda rng: encode_answer(rng.choice(ANSWERS)(rng)),
    _host_saw_one,
    MOST_HELD,
    most_good=2,
)
DEVICE = FuzzCase(
    "armdroid device",
    armdroid.Device,
    lambda rng: encode_command(rng.choice(COMMANDS)(rng)),
    _device_saw_one,
    MOST_HELD,
    most_good=2,
)
