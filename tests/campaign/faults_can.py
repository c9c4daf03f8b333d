"""The faults that only drives on a CAN bus have: of frames, node ids, modes, and single drives."""

from armdrive.sim.bus import DrivesBoard

from .injection import DEVICE, HOST, CampaignFault, inject, motor
from .missed_orders import excuse_cut_off, orders_ignored
from .power_loss import RESET_S, next_poll_by_s
from .stage import Stage

NEAR_ZERO = 64
"""After a restart, a drive that had counted no more than this seems to be where it was."""


def _lose_frames(stage: Stage) -> str:
    amount = stage.draw.choice(("next", "0.02", "0.1"))
    side = stage.draw.choice((HOST, DEVICE))
    if amount == "next":
        return inject(stage, f"lose-frame next {side}")
    for_s = stage.draw.choice((0.5, 2.0))
    if side == HOST:
        stage.orders_lost_until_s = stage.now_s + for_s
        stage.watch.lost_targets.begin(stage.now_s, for_s)
    return inject(stage, f"lose-frame {amount} {side} --for {for_s}")


def _double_frames(stage: Stage) -> str:
    side = stage.draw.choice((HOST, DEVICE))
    return inject(stage, f"double-frame 0.2 {side} --for {stage.draw.choice((0.5, 2.0))}")


def _overtake(stage: Stage) -> str:
    side, for_s = stage.draw.choice((HOST, DEVICE)), stage.draw.choice((0.5, 2.0))
    if side == HOST:
        stage.late_orders_until_s = stage.now_s + for_s
    return inject(stage, f"overtake 0.2 {side} --for {for_s}")


def _bus_off(stage: Stage) -> str:
    excuse_cut_off(stage)
    stage.add_silence_bound("the adapter left the bus")
    return inject(stage, f"bus-off --for {stage.draw.choice((0.1, 1.0, 5.0))}")


def _alone(stage: Stage) -> str:
    for_s = stage.draw.choice((0.2, 1.0, 5.0))
    stage.commands_lost_until_s = stage.now_s + for_s
    if stage.watch.must_stop:
        stage.add_silence_bound("a stop got no acknowledgement")
    return inject(stage, f"alone --for {for_s}")


def _mute_drive(stage: Stage) -> str:
    number, for_s = motor(stage), stage.draw.choice((0.1, 0.6, 4.0))
    stage.no_hold_until_s[number - 1] = stage.now_s + for_s
    return inject(stage, f"drive-mute {number} --for {for_s}")


def _dead_drive(stage: Stage) -> str:
    number, for_s = motor(stage), stage.draw.choice((0.1, 0.6, 4.0))
    _drive_restarts(stage, number, for_s)
    return inject(stage, f"drive-dead {number} --for {for_s}")


def _reset_drive(stage: Stage) -> str:
    number = motor(stage)
    _drive_restarts(stage, number, RESET_S)
    return inject(stage, f"drive-reset {number}")


def _drive_restarts(stage: Stage, number: int, for_s: float) -> None:
    """Note that the count of a drive falls to zero; excuse it if the count was near zero.

    The drive starts again after `for_s`.
    """
    stage.look()
    stage.note_drive_restarts((number - 1,), for_s)
    stage.watch.excuse_restart(stage.now_s)
    stage.watch.note_change(stage.now_s, next_poll_by_s(stage))
    if abs(stage.twin.device.registers[number - 1]) <= NEAR_ZERO:
        stage.watch.excuse_restart(motors={number - 1})


def _other_mode(stage: Stage) -> str:
    number, for_s = motor(stage), stage.draw.choice((0.5, 3.0))
    stage.watch.missed_orders = orders_ignored(stage, number - 1, for_s)
    stage.no_hold_until_s[number - 1] = stage.now_s + for_s  # it ignores an order to hold
    return inject(stage, f"drive-mode {number} 2 --for {for_s}")


def _other_id(stage: Stage) -> str:
    node = stage.draw.randint(1, 7)
    words = f"drive-id {motor(stage)} {node} --for {stage.draw.choice((0.5, 3.0))}"
    return inject(stage, words, misdirects=True)  # orders for one drive move another


def _no_done(stage: Stage) -> str:
    return inject(stage, f"no-done {motor(stage)} --for {stage.draw.choice((1.0, 6.0))}")


ON_A_BUS: tuple[CampaignFault, ...] = (
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
