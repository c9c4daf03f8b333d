"""What happens to the programs of a mission, to their disk, and by the hand of a person.

What happens to the wire, the board and the drives is in `tests/scenarios/happenings.py`.
"""

import random
from collections.abc import Callable, Mapping
from types import MappingProxyType

from armdrive.errors import ArmError
from armdrive.sim.device import HasPendant
from kinematics import Motors
from tests.scenarios.happenings import HAPPENINGS
from tests.scenarios.stage import STATE, Stage
from tests.scenarios.watch import Excuse

ProgramFault = Callable[[Stage, random.Random], str]
"""Lets something happen, and returns its words."""


def killed(stage: Stage, draw: random.Random) -> str:
    """Kill the program."""
    stage.pace.kill()
    return "killed"


def killed_in_mid_message(stage: Stage, draw: random.Random) -> str:
    """Kill the program while it writes."""
    stage.link.kill_after, stage.link.sent_share = draw.randint(0, 6), draw.random()
    stage.watch.pardon(Excuse.PATH)  # drives get one order each, and drive it to its end
    return f"killed at write {stage.link.kill_after}, {stage.link.sent_share:.0%} of it sent"


def killed_while_recording(stage: Stage, draw: random.Random) -> str:
    """Kill the program in the middle of what it does to the disk."""
    stage.disk.kill_after = draw.randint(0, 14)
    return f"killed at operation {stage.disk.kill_after} of the disk"


def power_cut(stage: Stage, draw: random.Random) -> str:
    """Cut the power of the computer and of the arm together."""
    stage.pace.kill()
    stage.disk.power_cut(draw)
    brown_out = next(each for each in HAPPENINGS if each.drawn.startswith("brown-out"))
    return f"a power cut; {stage.strike(brown_out, draw)}"


def record_damaged(stage: Stage, draw: random.Random) -> str:
    """Kill the program, and damage its record."""
    stage.pace.kill()
    text = bytearray(stage.disk.texts.get(STATE, b""))
    if text:
        if draw.random() < 0.5:
            del text[draw.randrange(len(text)) :]
        else:
            text[draw.randrange(len(text))] ^= 1 << draw.randrange(8)
        stage.disk.texts[STATE] = bytes(text)
    return "killed, and its record damaged"


def suspended(stage: Stage, draw: random.Random) -> str:
    """Suspend the program."""
    by_s = draw.choice((0.3, 1.5, 20.0, 4000.0))
    stage.suspend(by_s)
    return f"suspended for {by_s} s"


def disk_full(stage: Stage, draw: random.Random) -> str:
    """Fill the disk for a time."""
    for_s = draw.choice((0.5, 3.0, 30.0))

    def end() -> None:
        stage.disk.full = False

    stage.disk.full = True
    stage.timeline.at(stage.now_s + for_s, end)
    return f"the disk is full for {for_s} s"


def by_hand(stage: Stage, draw: random.Random) -> str:
    """Turn a motor by hand, or press the pendant's STOP."""
    stage.look()
    if isinstance(stage.twin.board, HasPendant) and draw.random() < 0.5:
        if stage.twin.device.moving:
            stage.add_stop_bound("the pendant's STOP")
        stage.twin.board.press_named("STOP")
        return "the pendant's STOP"
    steps = [0] * len(stage.world.motors)
    steps[draw.randrange(len(steps))] = draw.choice((-60, -7, 3, 25))
    stage.note_change()
    if stage.watch.closed_loop:
        stage.watch.pardon(Excuse.MOTION)  # the shaft turns back to its set-point
    try:
        done = stage.turn_by_hand(Motors(steps))
    except ArmError as error:
        return f"no motor could be turned: {error}"
    return f"turned by hand: {steps}" if done else "no motor could be turned"


PROGRAM_FAULTS: Mapping[str, ProgramFault] = MappingProxyType(
    {
        "program killed": killed,
        "killed in mid-message": killed_in_mid_message,
        "killed while recording": killed_while_recording,
        "record damaged": record_damaged,
        "power cut": power_cut,
        "program suspended": suspended,
        "disk full": disk_full,
        "turned by hand": by_hand,
    }
)
"""What happens to a program, by name; nothing happens without one."""
