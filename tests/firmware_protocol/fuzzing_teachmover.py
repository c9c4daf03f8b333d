"""The TeachMover codec's two ends for the long fuzz run."""

import random

from fuzzing import FuzzCase

from firmware_protocol.teachmover import (
    ATTENTION,
    Arm,
    Close,
    Completed,
    Delay,
    Device,
    Host,
    Ignored,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Registers,
    Reset,
    Run,
    Set,
    Status,
    Step,
    Stray,
    Unreadable,
)
from firmware_protocol.teachmover.messages import encode_command, encode_reply


def _byte(rng: random.Random) -> int:
    return rng.randrange(256)


def _six(rng: random.Random) -> tuple[int, ...]:
    return tuple(rng.randint(-32768, 32767) for _ in range(6))


def _row(rng: random.Random) -> ProgramRow:
    return ProgramRow(rng.randrange(65536), _byte(rng), _six(rng), _byte(rng))


COMMANDS = (
    lambda rng: Step(rng.randrange(246), _six(rng), rng.choice((None, _byte(rng)))),
    lambda rng: rng.choice((Read, Reset, Run, QDump))(),
    lambda rng: rng.choice((Close, Set))(rng.choice((None, rng.randrange(246)))),
    lambda rng: QWrite(_row(rng)),
    lambda rng: Arm(rng.choice("!#$%&*@~")),
    lambda rng: Delay(rng.randrange(65536)),
)
REPLIES = (
    lambda rng: rng.choice(list(Status)),
    lambda rng: Registers(_six(rng), _byte(rng), _byte(rng)),
    _row,
)


def _host_saw_one(host: Host) -> bool:
    """Ask for nothing, so that every readable line is an event of its own."""
    seen = False
    while (event := host.next_event()) is not None:
        seen |= isinstance(event, Completed | Stray)
    return seen


def _device_saw_one(device: Device) -> bool:
    """Answer that it failed, so that the attention character stays as it is."""
    seen = False
    while (event := device.next_event()) is not None:
        if isinstance(event, Ignored):
            continue
        seen |= not isinstance(event, Unreadable)
        device.send(Status.FAILED)
    return seen


MOST_HELD = 256 * 256 + 256
HOST = FuzzCase(
    "teachmover host",
    Host,
    lambda rng: encode_reply(rng.choice(REPLIES)(rng)),
    _host_saw_one,
    MOST_HELD,
)
DEVICE = FuzzCase(
    "teachmover device",
    Device,
    lambda rng: encode_command(rng.choice(COMMANDS)(rng), ATTENTION),
    _device_saw_one,
    MOST_HELD,
)
