"""The TeachMover codec's two ends for the long fuzz run."""

import random

from fuzzing import FuzzCase

from firmware_protocol import teachmover
from firmware_protocol.teachmover.messages import encode_command, encode_reply


def _byte(rng: random.Random) -> int:
    return rng.randrange(256)


def _six(rng: random.Random) -> tuple[int, ...]:
    return tuple(rng.randint(-32768, 32767) for _ in range(6))


def _row(rng: random.Random) -> teachmover.ProgramRow:
    return teachmover.ProgramRow(rng.randrange(65536), _byte(rng), _six(rng), _byte(rng))


COMMANDS = (
    lambda rng: teachmover.Step(rng.randrange(246), _six(rng), rng.choice((None, _byte(rng)))),
    lambda rng: rng.choice((teachmover.Read, teachmover.Reset, teachmover.Run, teachmover.QDump))(),
    lambda rng: rng.choice((teachmover.Close, teachmover.Set))(
        rng.choice((None, rng.randrange(246)))
    ),
    lambda rng: teachmover.QWrite(_row(rng)),
    lambda rng: teachmover.Arm(rng.choice("!#$%&*@~")),
    lambda rng: teachmover.Delay(rng.randrange(65536)),
)
REPLIES = (
    lambda rng: rng.choice(list(teachmover.Status)),
    lambda rng: teachmover.Registers(_six(rng), _byte(rng), _byte(rng)),
    _row,
)


def _host_saw_one(host: teachmover.Host) -> bool:
    """Ask for nothing, so that every readable line is an event of its own."""
    seen = False
    while (event := host.next_event()) is not None:
        seen |= isinstance(event, teachmover.Completed | teachmover.Stray)
    return seen


def _device_saw_one(device: teachmover.Device) -> bool:
    """Answer that it failed, so that the attention character stays as it is."""
    seen = False
    while (event := device.next_event()) is not None:
        if isinstance(event, teachmover.Ignored):
            continue
        seen |= not isinstance(event, teachmover.Unreadable)
        device.send(teachmover.Status.FAILED)
    return seen


MOST_HELD = 256 * 256 + 256
HOST = FuzzCase(
    "teachmover host",
    teachmover.Host,
    lambda rng: encode_reply(rng.choice(REPLIES)(rng)),
    _host_saw_one,
    MOST_HELD,
)
DEVICE = FuzzCase(
    "teachmover device",
    teachmover.Device,
    lambda rng: encode_command(rng.choice(COMMANDS)(rng), teachmover.ATTENTION),
    _device_saw_one,
    MOST_HELD,
)
