"""What can happen to drives on a CAN bus beside what happens to any arm: frames, ids, modes."""

from __future__ import annotations

from armdrive.sim.device import DrivesOnBus

from .asking import DEVICE, HOST, Fault, ask, motor
from .stage import Stage
from .unled import cut_off, unled
from .untold import seen_by_s

NEAR_ZERO = 64
"""A drive that counted so few is where it was by its own word when it begins anew."""


def _lose_frames(stage: Stage) -> str:
    amount = stage.draw.choice(("next", "0.02", "0.1"))
    side = stage.draw.choice((HOST, DEVICE))
    if amount == "next":
        return ask(stage, f"lose-frame next {side}")
    for_s = stage.draw.choice((0.5, 2.0))
    if side == HOST:
        stage.watch.lagging.begin(stage.now_s, for_s)
    return ask(stage, f"lose-frame {amount} {side} --for {for_s}")


def _double_frames(stage: Stage) -> str:
    side = stage.draw.choice((HOST, DEVICE))
    return ask(stage, f"double-frame 0.2 {side} --for {stage.draw.choice((0.5, 2.0))}")


def _overtake(stage: Stage) -> str:
    side, for_s = stage.draw.choice((HOST, DEVICE)), stage.draw.choice((0.5, 2.0))
    if side == HOST:
        stage.late_orders_until_s = stage.now_s + for_s
    return ask(stage, f"overtake 0.2 {side} --for {for_s}")


def _bus_off(stage: Stage) -> str:
    cut_off(stage)
    stage.promise_silence("the adapter left the bus")
    return ask(stage, f"bus-off --for {stage.draw.choice((0.1, 1.0, 5.0))}")


def _alone(stage: Stage) -> str:
    for_s = stage.draw.choice((0.2, 1.0, 5.0))
    stage.unheard_until_s = stage.now_s + for_s
    if stage.watch.promised:
        stage.promise_silence("nobody acknowledged a stop")
    return ask(stage, f"alone --for {for_s}")


def _mute_drive(stage: Stage) -> str:
    number, for_s = motor(stage), stage.draw.choice((0.1, 0.6, 4.0))
    stage.untold_until_s[number - 1] = stage.now_s + for_s
    return ask(stage, f"drive-mute {number} --for {for_s}")


def _dead_drive(stage: Stage) -> str:
    number = motor(stage)
    _begins_anew(stage, number)
    return ask(stage, f"drive-dead {number} --for {stage.draw.choice((0.1, 0.6, 4.0))}")


def _reset_drive(stage: Stage) -> str:
    number = motor(stage)
    _begins_anew(stage, number)
    return ask(stage, f"drive-reset {number}")


def _begins_anew(stage: Stage, number: int) -> None:
    """Hear that what a drive counts falls to zero; one that counted next to none tells nothing."""
    stage.look()
    stage.watch.untold(stage.now_s)
    stage.watch.change(stage.now_s, seen_by_s(stage))
    if abs(stage.twin.device.registers[number - 1]) <= NEAR_ZERO:
        stage.watch.untold(motors={number - 1})


def _other_mode(stage: Stage) -> str:
    number, for_s = motor(stage), stage.draw.choice((0.5, 3.0))
    stage.watch.unled = unled(stage, number - 1, for_s)
    stage.untold_until_s[number - 1] = stage.now_s + for_s  # it takes no order, nor that one
    return ask(stage, f"drive-mode {number} 2 --for {for_s}")


def _other_id(stage: Stage) -> str:
    node = stage.draw.randint(1, 7)
    words = f"drive-id {motor(stage)} {node} --for {stage.draw.choice((0.5, 3.0))}"
    return ask(stage, words, strays=True)  # what is told to the one moves the other


def _no_done(stage: Stage) -> str:
    return ask(stage, f"no-done {motor(stage)} --for {stage.draw.choice((1.0, 6.0))}")


ON_A_BUS: tuple[Fault, ...] = (
    Fault("frames lost", _lose_frames, DrivesOnBus),
    Fault("frames twice", _double_frames, DrivesOnBus),
    Fault("frames overtaken", _overtake, DrivesOnBus),
    Fault("the adapter bus-off", _bus_off, DrivesOnBus),
    Fault("nobody acknowledges", _alone, DrivesOnBus),
    Fault("a mute drive", _mute_drive, DrivesOnBus),
    Fault("a drive without power", _dead_drive, DrivesOnBus),
    Fault("a drive reset", _reset_drive, DrivesOnBus),
    Fault("a drive in another mode", _other_mode, DrivesOnBus),
    Fault("a drive with another id", _other_id, DrivesOnBus),
    Fault('no word of "done"', _no_done, DrivesOnBus),
)
