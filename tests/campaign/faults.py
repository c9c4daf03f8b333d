"""The faults of the campaign: of the wire, board, arm and program, and of the drives on a bus.

Each fault draws its numbers from the mission's generator. When it strikes, it tells the watch what
no driver can know or prevent.
"""

import random
from collections.abc import Callable, Collection
from dataclasses import dataclass

from armdrive.errors import ArmError, BadRequest
from armdrive.motion.reference import PROMPT_S
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.device import Board, HasPendant, HasSwitches, Resettable
from armdrive.sim.faults import parse_words
from armdrive.sim.robko01 import SimRobkoBoard
from kinematics import Motors

from .stage import STATE, Stage, suspend

HOST, DEVICE = "from=host", "from=device"


@dataclass(frozen=True, slots=True)
class CampaignFault:
    """A fault that missions draw: `begin` injects it and returns what was injected, for the log."""

    name: str
    begin: Callable[[Stage], str]
    needs: type | None = None
    """The ability that a board needs to have this fault."""
    needs_program: bool = False
    """Whether the fault strikes a program: without one, nothing happens."""

    def applies_to(self, board: Board) -> bool:
        """Return whether a device with this board can have the fault."""
        return self.needs is None or isinstance(board, self.needs)


def inject(stage: Stage, words: str, *, misdirects: bool = False) -> str:
    """Inject a fault of the simulator's table, and return its words.

    `misdirects`: the device may now do something that the driver did not command.
    """
    if misdirects:
        stage.watch.doubts.misdirected = True
    seed = stage.draw.randrange(1 << 30)
    stage.look()
    try:
        stage.twin.faults.ask(parse_words(f"{words} seed={seed}".split()))
    except BadRequest as error:
        return f"{words}: {error}"
    return words


def motor(stage: Stage) -> int:
    """Draw a motor, counted from 1."""
    return stage.draw.randint(1, len(stage.world.motors))


LOOK_S = 0.5
"""A poll that is due has begun within this time, whatever its result."""
RESET_S = 0.15
"""A simulated MKS drive that is reset holds its shaft again after this time (`BOOT_S`)."""
NEAR_ZERO = 64
"""After a restart, a drive that had counted no more than this seems to be where it was."""


def _next_poll_by_s(stage: Stage) -> float:
    """Return the latest time at which an idle program polls the arm next."""
    return stage.now_s + stage.config.motion.idle_poll_s + LOOK_S


def _note_restart(stage: Stage, motors: Collection[int], for_s: float = RESET_S) -> None:
    """Note that motors lose their power for a time, and then count from zero.

    The next poll shows that, unless they had counted about as much before. A drive that is back
    soon may obey an order from its new zero, until the driver has noticed.
    """
    stage.look()
    stage.watch.note_change(stage.now_s, _next_poll_by_s(stage))
    stage.watch.doubts.off_path |= set(motors)
    stage.disturb(for_s)
    near = NEAR_ZERO if stage.world.closed_loop else 0
    counts = stage.twin.device.registers
    if stage.reads_zero or all(abs(counts[motor]) <= near for motor in motors):
        stage.watch.lose_track(motors)


# -- Faults of the wire, the board, the arm, and the program ---------------------------------------


def _no_check_bytes(stage: Stage) -> bool:
    """Return whether the device obeys changed numbers: neither messages nor a bus have checks."""
    return not isinstance(stage.twin.board, DrivesBoard | SimRobkoBoard)


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
        stage.watch.doubts.late_s = by_s
        stage.disturb(by_s + NEXT_MESSAGE_S)
    return inject(stage, f"delay {by_s} next {side}", misdirects=side == HOST and by_s > 0.4)


FRAMES_A_BYTE = 5
"""A line to a CAN adapter that changes a share of its characters damages more of the frames."""


def _noise(stage: Stage) -> str:
    kind, share = stage.draw.choice(("drop", "corrupt")), stage.draw.choice((0.005, 0.03, 0.1))
    side = stage.draw.choice((HOST, DEVICE))
    for_s = stage.draw.choice((0.5, 1.0, 3.0))
    if isinstance(stage.twin.board, DrivesBoard):
        share *= FRAMES_A_BYTE
    if side == HOST:
        stage.disturb(for_s)
    words = f"{kind} {share} {side} for={for_s}"
    return inject(stage, words, misdirects=side == HOST and _no_check_bytes(stage))


def _garbage(stage: Stage) -> str:
    return inject(stage, f"garbage {stage.draw.choice((1, 8, 40, 300))}")


def _mute(stage: Stage) -> str:
    return inject(stage, f"mute for={stage.draw.choice((0.2, 1.0, 3.0, 8.0))}")


def _unplug(stage: Stage) -> str:
    stage.add_silence_bound("the cable was pulled")
    return inject(stage, f"unplug for={stage.draw.choice((0.05, 0.5, 2.0, 6.0))}")


def _brown_out(stage: Stage) -> str:
    for_s = stage.draw.choice((0.1, 0.5, 2.0))
    _note_restart(stage, range(len(stage.world.motors)), for_s)
    return inject(stage, f"brown-out for={for_s}")


def _reset(stage: Stage) -> str:
    _note_restart(stage, range(len(stage.world.motors)))
    return inject(stage, "reset")


def _lose_steps(stage: Stage) -> str:
    return inject(stage, f"lose-steps {motor(stage)} {stage.draw.choice((1, 5, 40))}")


def _stall(stage: Stage) -> str:
    return inject(stage, f"stall {motor(stage)} for={stage.draw.choice((0.3, 2.0))}")


def _switch(stage: Stage) -> str:
    state = stage.draw.choice(("open", "closed"))
    number, for_s = motor(stage), stage.draw.choice((0.5, 4.0))
    stage.stuck_until_s[number - 1] = stage.now_s + for_s
    return inject(stage, f"switch {number} {state} for={for_s}")


def _pendant(stage: Stage) -> str:
    """Turn a motor by hand, or press the pendant's STOP."""
    stage.look()
    board = stage.twin.board
    if isinstance(board, HasPendant) and stage.draw.random() < 0.5:
        board.press_named("STOP")
        return "the pendant's STOP"
    steps = [0] * len(stage.world.motors)
    steps[motor(stage) - 1] = stage.draw.choice((-60, -7, 3, 25))
    stage.watch.note_change(stage.now_s, _next_poll_by_s(stage))
    try:
        done = stage.turn_by_hand(Motors(steps))
    except ArmError as error:
        return f"no motor could be turned: {error}"
    turned = {at for at, count in enumerate(steps) if count}
    stage.watch.note_displaced(turned, stage.now_s)
    prompt = stage.now_s <= stage.referenced_s + PROMPT_S
    if done and prompt and stage.watch.referencing:
        stage.watch.lose_track(turned)
    return f"turned by hand: {steps}" if done else "no motor could be turned"


def _kill(stage: Stage) -> str:
    stage.pace.kill()
    return "killed"


def _kill_at_write(stage: Stage) -> str:
    stage.link.kill_after = stage.draw.randint(0, 6)
    stage.link.sent_share = stage.draw.random()
    # MKS drives get one order each, and drive it to its end
    stage.link.on_partial_write = lambda: stage.disturb(0.0)
    return f"killed at write {stage.link.kill_after}, {stage.link.sent_share:.0%} of it sent"


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


# -- Faults that only drives on a bus have: of frames, node ids, modes, and single drives ----------


def _lose_frames(stage: Stage) -> str:
    amount = stage.draw.choice(("next", "0.02", "0.1"))
    side = stage.draw.choice((HOST, DEVICE))
    if amount == "next":
        return inject(stage, f"drop next {side}")
    for_s = stage.draw.choice((0.5, 2.0))
    if side == HOST:
        stage.disturb(for_s)
    return inject(stage, f"drop {amount} {side} for={for_s}")


def _double_frames(stage: Stage) -> str:
    side = stage.draw.choice((HOST, DEVICE))
    return inject(stage, f"duplicate 0.2 {side} for={stage.draw.choice((0.5, 2.0))}")


def _overtake(stage: Stage) -> str:
    side, for_s = stage.draw.choice((HOST, DEVICE)), stage.draw.choice((0.5, 2.0))
    if side == HOST:
        stage.disturb(for_s)
    return inject(stage, f"overtake 0.2 {side} for={for_s}")


def _bus_off(stage: Stage) -> str:
    stage.add_silence_bound("the adapter left the bus")
    return inject(stage, f"bus-off for={stage.draw.choice((0.1, 1.0, 5.0))}")


def _alone(stage: Stage) -> str:
    for_s = stage.draw.choice((0.2, 1.0, 5.0))
    stage.disturb(for_s)
    return inject(stage, f"alone for={for_s}")


def _mute_drive(stage: Stage) -> str:
    return inject(stage, f"drive-mute {motor(stage)} for={stage.draw.choice((0.1, 0.6, 4.0))}")


def _dead_drive(stage: Stage) -> str:
    number, for_s = motor(stage), stage.draw.choice((0.1, 0.6, 4.0))
    _note_restart(stage, (number - 1,), for_s)
    return inject(stage, f"drive-dead {number} for={for_s}")


def _reset_drive(stage: Stage) -> str:
    number = motor(stage)
    _note_restart(stage, (number - 1,))
    return inject(stage, f"drive-reset {number}")


def _other_mode(stage: Stage) -> str:
    number, for_s = motor(stage), stage.draw.choice((0.5, 3.0))
    stage.disturb(for_s)
    return inject(stage, f"drive-mode {number} 2 for={for_s}")


def _other_id(stage: Stage) -> str:
    node = stage.draw.randint(1, 7)
    words = f"drive-id {motor(stage)} {node} for={stage.draw.choice((0.5, 3.0))}"
    return inject(stage, words, misdirects=True)  # orders for one drive move another


def _no_done(stage: Stage) -> str:
    return inject(stage, f"no-done {motor(stage)} for={stage.draw.choice((1.0, 6.0))}")


# -- The table -------------------------------------------------------------------------------------

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
    CampaignFault("frames lost", _lose_frames, DrivesBoard),
    CampaignFault("frames doubled", _double_frames, DrivesBoard),
    CampaignFault("frames overtaken", _overtake, DrivesBoard),
    CampaignFault("the adapter bus-off", _bus_off, DrivesBoard),
    CampaignFault("no acknowledgement", _alone, DrivesBoard),
    CampaignFault("a mute drive", _mute_drive, DrivesBoard),
    CampaignFault("a drive without power", _dead_drive, DrivesBoard),
    CampaignFault("a drive reset", _reset_drive, DrivesBoard),
    CampaignFault("a drive in another mode", _other_mode, DrivesBoard),
    CampaignFault("a drive with another id", _other_id, DrivesBoard),
    CampaignFault("no done report", _no_done, DrivesBoard),
)
NONE = "nothing"
"""The name of the row for missions without a fault."""
