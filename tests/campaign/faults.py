"""The faults of the campaign: of the wire, the board, the arm, and the program.

Each fault draws its numbers from the mission's generator. When it strikes, it tells the watch what
it excuses.
"""

import random

from armdrive.errors import ArmError
from armdrive.motion.reference import PROMPT_S
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.device import HasPendant, HasSwitches, Resettable
from kinematics import Motors

from .excuses import NOISE_S, TurnedByHand
from .faults_can import ON_A_BUS
from .injection import DEVICE, HOST, CampaignFault, inject, motor
from .missed_orders import excuse_cut_off, orders_cut_short, orders_lost
from .power_loss import next_poll_by_s, note_power_loss
from .stage import STATE, Stage, suspend


def _no_check_bytes(stage: Stage) -> bool:
    """Return whether the device obeys changed numbers: neither messages nor a bus have checks."""
    return not stage.config_abilities.check_bytes and not isinstance(stage.twin.board, DrivesBoard)


def _amount(draw: random.Random) -> str:
    return draw.choice(("next", f"#{draw.randint(1, 30)}", f"#{draw.randint(1, 8)}"))


def _drop(stage: Stage) -> str:
    amount = _amount(stage.draw)
    if stage.draw.random() < 0.5:
        return inject(stage, f"drop {amount} {DEVICE}")
    return inject(
        stage, f"drop {amount} {HOST}", misdirects=amount != "next" and _no_check_bytes(stage)
    )


def _corrupt(stage: Stage) -> str:
    side = stage.draw.choice((HOST, DEVICE))
    return inject(
        stage,
        f"corrupt {_amount(stage.draw)} {side}",
        misdirects=side == HOST and _no_check_bytes(stage),
    )


def _duplicate(stage: Stage) -> str:
    side = stage.draw.choice((HOST, DEVICE))
    return inject(stage, f"duplicate {_amount(stage.draw)} {side}", misdirects=side == HOST)


NEXT_MESSAGE_S = 0.1
"""A program sends its next message within this time: a heartbeat, a poll or a target."""


def _delay(stage: Stage) -> str:
    side = stage.draw.choice((HOST, DEVICE))
    by_s = stage.draw.choice((0.05, 0.2, 0.4, 1.0, 2.5))
    if side == HOST:
        stage.watch.late_s = by_s
        stage.late_orders_until_s = stage.now_s + by_s + NEXT_MESSAGE_S
    return inject(stage, f"delay {by_s} next {side}", misdirects=side == HOST and by_s > 0.4)


DAMAGES_FRAMES = 0.03
"""A line to a CAN adapter that changes this share of its characters damages every other frame. A
stop may reach all drives, one or none, however often it is repeated."""


def _noise(stage: Stage) -> str:
    kind, share = stage.draw.choice(("drop", "corrupt")), stage.draw.choice((0.005, 0.03, 0.1))
    side = stage.draw.choice((HOST, DEVICE))
    for_s = stage.draw.choice((0.5, 1.0, 3.0))
    on_bus = side == HOST and isinstance(stage.twin.board, DrivesBoard)
    if on_bus:
        stage.orders_lost_until_s = stage.now_s + for_s
    if on_bus and share >= DAMAGES_FRAMES:
        stage.commands_lost_until_s = stage.now_s + for_s
        stage.watch.lost_targets.begin(stage.now_s, for_s)
        if stage.watch.must_stop:
            stage.add_silence_bound("the line damaged a stop")
        stage.watch.missed_orders = orders_lost(stage, for_s)
    words = f"{kind} {share} {side} --for {for_s}"
    return inject(stage, words, misdirects=side == HOST and _no_check_bytes(stage))


def _garbage(stage: Stage) -> str:
    return inject(stage, f"garbage {stage.draw.choice((1, 8, 40, 300))}")


def _mute(stage: Stage) -> str:
    for_s = stage.draw.choice((0.2, 1.0, 3.0, 8.0))
    stage.no_hold_until_s |= dict.fromkeys(range(len(stage.world.motors)), stage.now_s + for_s)
    return inject(stage, f"mute --for {for_s}")


def _unplug(stage: Stage) -> str:
    excuse_cut_off(stage)
    stage.add_silence_bound("the cable was pulled")
    return inject(stage, f"unplug --for {stage.draw.choice((0.05, 0.5, 2.0, 6.0))}")


def _brown_out(stage: Stage) -> str:
    for_s = stage.draw.choice((0.1, 0.5, 2.0))
    note_power_loss(stage, for_s)
    return inject(stage, f"brown-out --for {for_s}")


def _reset(stage: Stage) -> str:
    note_power_loss(stage)
    return inject(stage, "reset")


def _lose_steps(stage: Stage) -> str:
    return inject(stage, f"lose-steps {motor(stage)} {stage.draw.choice((1, 5, 40))}")


def _stall(stage: Stage) -> str:
    return inject(stage, f"stall {motor(stage)} --for {stage.draw.choice((0.3, 2.0))}")


def _switch(stage: Stage) -> str:
    state = stage.draw.choice(("open", "closed"))
    return inject(stage, f"switch {motor(stage)} {state} --for {stage.draw.choice((0.5, 4.0))}")


def _pendant(stage: Stage) -> str:
    """Turn a motor by hand, or press the pendant's STOP."""
    stage.look()
    board = stage.twin.board
    if isinstance(board, HasPendant) and stage.draw.random() < 0.5:
        board.press_named("STOP")
        return "the pendant's STOP"
    steps = [0] * len(stage.world.motors)
    steps[motor(stage) - 1] = stage.draw.choice((-60, -7, 3, 25))
    stage.watch.note_change(stage.now_s, next_poll_by_s(stage))
    before = stage.world.motors
    try:
        done = stage.turn_by_hand(Motors(steps))
    except ArmError as error:
        return f"no motor could be turned: {error}"
    stage.watch.turned_by_hand = TurnedByHand.of(
        stage.config, before, stage.world.motors, stage.now_s
    )
    prompt = stage.now_s <= stage.referenced_s + PROMPT_S
    if done and prompt and stage.watch.referencing:
        stage.watch.excuse_hand_turn(Motors(steps))
    return f"turned by hand: {steps}" if done else "no motor could be turned"


def _kill(stage: Stage) -> str:
    stage.pace.kill()
    return "killed"


def _kill_at_write(stage: Stage) -> str:
    stage.link.kill_after = stage.draw.randint(0, 6)
    stage.link.sent_share = stage.draw.random()
    stage.link.on_partial_write = lambda: _orders_cut_short(stage)
    return f"killed at write {stage.link.kill_after}, {stage.link.sent_share:.0%} of it sent"


def _orders_cut_short(stage: Stage) -> None:
    """Excuse the drives if only some of them have got their orders."""
    if (excuse := orders_cut_short(stage)) is not None:
        stage.watch.missed_orders = excuse
        stage.commands_lost_until_s = max(stage.commands_lost_until_s, stage.now_s + NOISE_S)


def _kill_at_disk(stage: Stage) -> str:
    stage.disk.kill_after = stage.draw.randint(0, 14)
    return f"killed at operation {stage.disk.kill_after} of the disk"


def _power_cut(stage: Stage) -> str:
    """Cut the power of the computer and of the arm together."""
    stage.pace.kill()
    stage.disk.power_cut(stage.draw)
    return f"a power cut; {_brown_out(stage)}"


def _suspend(stage: Stage) -> str:
    by_s = stage.draw.choice((0.3, 1.5, 20.0, 4000.0))
    suspend(stage, by_s)
    return f"the program was suspended for {by_s} s"


def _disk_full(stage: Stage) -> str:
    stage.disk.full = True
    for_s = stage.draw.choice((0.5, 3.0, 30.0))

    def end() -> None:
        stage.disk.full = False

    stage.schedule.at(stage.now_s + for_s, end)
    return f"the disk is full for {for_s} s"


def _damage(stage: Stage) -> str:
    """Kill the program, and damage its record."""
    stage.pace.kill()
    text = bytearray(stage.disk.texts.get(STATE, b""))
    if text:
        if stage.draw.random() < 0.5:
            del text[stage.draw.randrange(len(text)) :]
        else:
            text[stage.draw.randrange(len(text))] ^= 1 << stage.draw.randrange(8)
        stage.disk.texts[STATE] = bytes(text)
    return "killed, and its record damaged"


FAULTS: tuple[CampaignFault, ...] = (
    CampaignFault("bytes lost", _drop),
    CampaignFault("bytes changed", _corrupt),
    CampaignFault("bytes doubled", _duplicate),
    CampaignFault("messages late", _delay),
    CampaignFault("a noisy line", _noise),
    CampaignFault("garbage", _garbage),
    CampaignFault("a mute device", _mute),
    CampaignFault("unplugged, replugged", _unplug),
    CampaignFault("board reset", _reset, Resettable),
    CampaignFault("brown-out", _brown_out),
    CampaignFault("lost steps", _lose_steps),
    CampaignFault("a stalled motor", _stall),
    CampaignFault("a stuck switch", _switch, HasSwitches),
    CampaignFault("pendant used", _pendant),
    CampaignFault("program killed", _kill, needs_program=True),
    CampaignFault("killed in mid-message", _kill_at_write, needs_program=True),
    CampaignFault("killed while recording", _kill_at_disk, needs_program=True),
    CampaignFault("power cut", _power_cut),
    CampaignFault("record damaged", _damage),
    CampaignFault("program suspended", _suspend, needs_program=True),
    CampaignFault("disk full", _disk_full),
    *ON_A_BUS,
)
NONE = "nothing"
"""The name of the row for missions without a fault."""
