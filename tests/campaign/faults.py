"""The faults of a campaign: what can happen to the wire, the board, the arm, and the program.

Each row draws its numbers from the mission's own generator, and happens at a moment of the host's
time. What a fault excuses is said to the watch at that moment, and nothing more.
"""

from __future__ import annotations

import random

from armdrive.errors import ArmError
from armdrive.motion.reference import PROMPT_S
from armdrive.sim.device import DrivesOnBus, HasPendant, HasSwitches, Resettable
from kinematics import Motors

from .asking import DEVICE, HOST, Fault, ask, motor
from .faults_can import ON_A_BUS
from .stage import STATE, Stage, suspend
from .turned import turned_by_hand
from .unled import cut_off, half_heard, half_told
from .untold import fail_power, seen_by_s


def _unchecked(stage: Stage) -> bool:
    """A changed number is a number: without check bytes the device obeys it."""
    return not stage.config_abilities.check_bytes


def _amount(draw: random.Random) -> str:
    return draw.choice(("next", f"#{draw.randint(1, 30)}", f"#{draw.randint(1, 8)}"))


def _drop(stage: Stage) -> str:
    amount = _amount(stage.draw)
    if stage.draw.random() < 0.5:
        return ask(stage, f"drop {amount} {DEVICE}")
    return ask(stage, f"drop {amount} {HOST}", strays=amount != "next" and _unchecked(stage))


def _corrupt(stage: Stage) -> str:
    side = stage.draw.choice((HOST, DEVICE))
    return ask(
        stage, f"corrupt {_amount(stage.draw)} {side}", strays=side == HOST and _unchecked(stage)
    )


def _duplicate(stage: Stage) -> str:
    side = stage.draw.choice((HOST, DEVICE))
    return ask(stage, f"duplicate {_amount(stage.draw)} {side}", strays=side == HOST)


def _delay(stage: Stage) -> str:
    side = stage.draw.choice((HOST, DEVICE))
    by_s = stage.draw.choice((0.05, 0.2, 0.4, 1.0, 2.5))
    if side == HOST:
        stage.watch.late_s = by_s
    return ask(stage, f"delay {by_s} next {side}", strays=side == HOST and by_s > 0.4)


SPOILS = 0.03
"""A line to an adapter that spoils so many of its characters spoils every other frame of a bus: a
stop may reach nobody, one drive alone or all, however often it is said."""


def _noise(stage: Stage) -> str:
    kind, share = stage.draw.choice(("drop", "corrupt")), stage.draw.choice((0.005, 0.03, 0.1))
    side = stage.draw.choice((HOST, DEVICE))
    for_s = stage.draw.choice((0.5, 1.0, 3.0))
    if side == HOST and share >= SPOILS and isinstance(stage.twin.board, DrivesOnBus):
        stage.unheard_until_s = stage.now_s + for_s
        if stage.watch.promised:
            stage.promise_silence("the line spoilt a stop")
        stage.watch.unled = half_heard(stage, for_s)
    words = f"{kind} {share} {side} --for {for_s}"
    return ask(stage, words, strays=side == HOST and _unchecked(stage))


def _garbage(stage: Stage) -> str:
    return ask(stage, f"garbage {stage.draw.choice((1, 8, 40, 300))}")


def _mute(stage: Stage) -> str:
    return ask(stage, f"mute --for {stage.draw.choice((0.2, 1.0, 3.0, 8.0))}")


def _unplug(stage: Stage) -> str:
    cut_off(stage)
    stage.promise_silence("the cable was pulled")
    return ask(stage, f"unplug --for {stage.draw.choice((0.05, 0.5, 2.0, 6.0))}")


def _brown_out(stage: Stage) -> str:
    for_s = stage.draw.choice((0.1, 0.5, 2.0))
    fail_power(stage, for_s)
    return ask(stage, f"brown-out --for {for_s}")


def _reset(stage: Stage) -> str:
    fail_power(stage)
    return ask(stage, "reset")


def _lose_steps(stage: Stage) -> str:
    return ask(stage, f"lose-steps {motor(stage)} {stage.draw.choice((1, 5, 40))}")


def _stall(stage: Stage) -> str:
    return ask(stage, f"stall {motor(stage)} --for {stage.draw.choice((0.3, 2.0))}")


def _switch(stage: Stage) -> str:
    state = stage.draw.choice(("open", "closed"))
    return ask(stage, f"switch {motor(stage)} {state} --for {stage.draw.choice((0.5, 4.0))}")


def _pendant(stage: Stage) -> str:
    """Have somebody turn a motor, or press STOP."""
    stage.look()
    board = stage.twin.board
    if isinstance(board, HasPendant) and stage.draw.random() < 0.5:
        board.press_named("STOP")
        return "the pendant's STOP"
    steps = [0] * len(stage.world.motors)
    steps[motor(stage) - 1] = stage.draw.choice((-60, -7, 3, 25))
    stage.watch.change(stage.now_s, seen_by_s(stage))
    before = stage.world.motors
    try:
        done = stage.turn_by_hand(Motors(steps))
    except ArmError as error:
        return f"nobody could turn it: {error}"
    stage.watch.turned = turned_by_hand(stage, before)
    if done and stage.now_s <= stage.vouched_s + PROMPT_S:
        stage.watch.overlooked(Motors(steps))
    return f"turned by hand: {steps}" if done else "nobody could turn it"


def _kill(stage: Stage) -> str:
    stage.pace.die()
    return "killed"


def _kill_at_write(stage: Stage) -> str:
    stage.link.ends_in = stage.draw.randint(0, 6)
    stage.link.share = stage.draw.random()
    stage.link.torn = lambda: _tear(stage)
    return f"killed at write {stage.link.ends_in}, {stage.link.share:.0%} of it sent"


def _tear(stage: Stage) -> None:
    """Hear that some drives have been given their orders, and others will never be."""
    if (excuse := half_told(stage)) is not None:
        stage.watch.unled = excuse


def _kill_at_disk(stage: Stage) -> str:
    stage.disk.ends_in = stage.draw.randint(0, 14)
    return f"killed at operation {stage.disk.ends_in} of the disk"


def _power_cut(stage: Stage) -> str:
    """Have the power of the computer and of the arm fail together."""
    stage.pace.die()
    stage.disk.power_cut(stage.draw)
    return f"a power cut; {_brown_out(stage)}"


def _jump(stage: Stage) -> str:
    by_s = stage.draw.choice((0.3, 1.5, 20.0, 4000.0))
    suspend(stage, by_s)
    return f"the program was suspended for {by_s} s"


def _disk_full(stage: Stage) -> str:
    stage.disk.full = True
    for_s = stage.draw.choice((0.5, 3.0, 30.0))

    def end() -> None:
        stage.disk.full = False

    stage.agenda.at(stage.now_s + for_s, end)
    return f"the disk is full for {for_s} s"


def _damage(stage: Stage) -> str:
    """Have the record damaged behind the program's back, and the program end."""
    stage.pace.die()
    text = bytearray(stage.disk.texts.get(STATE, b""))
    if text:
        if stage.draw.random() < 0.5:
            del text[stage.draw.randrange(len(text)) :]
        else:
            text[stage.draw.randrange(len(text))] ^= 1 << stage.draw.randrange(8)
        stage.disk.texts[STATE] = bytes(text)
    return "killed, and its record damaged"


FAULTS: tuple[Fault, ...] = (
    Fault("bytes lost", _drop),
    Fault("bytes changed", _corrupt),
    Fault("bytes twice", _duplicate),
    Fault("messages late", _delay),
    Fault("a noisy line", _noise),
    Fault("garbage", _garbage),
    Fault("a mute device", _mute),
    Fault("unplugged, replugged", _unplug),
    Fault("board reset", _reset, Resettable),
    Fault("brown-out", _brown_out),
    Fault("lost steps", _lose_steps),
    Fault("a stalled motor", _stall),
    Fault("a stuck switch", _switch, HasSwitches),
    Fault("somebody at the pendant", _pendant),
    Fault("program killed", _kill, of_programs=True),
    Fault("killed in mid-message", _kill_at_write, of_programs=True),
    Fault("killed while recording", _kill_at_disk, of_programs=True),
    Fault("power cut", _power_cut),
    Fault("record damaged", _damage),
    Fault("program suspended", _jump, of_programs=True),
    Fault("disk full", _disk_full),
    *ON_A_BUS,
)
NONE = "nothing"
"""The row of missions without a fault."""
