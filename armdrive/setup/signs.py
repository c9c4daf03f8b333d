"""Finds which way the motors count: each turns a little and back, and the user says what moved.

Each motor turns alone, slowly, a few degrees at most. Nothing moves before the user agrees.
"""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.arm import Arm
from armdrive.dialog.conversation import Look, Talk, agreed, say
from armdrive.errors import DeviceFault
from armdrive.setup.directions import (
    AGAIN,
    TRIAL_SPEED,
    DirectionCheck,
    SawMotion,
    Signs,
    ask_way,
    check_of,
)
from armdrive.status import State


def find_signs(arm: Arm, picture: Sequence[str] = ()) -> Talk[Signs]:
    """Turn each motor of a connected arm; return the motors that the user saw reversed.

    `picture` shows the posture to begin in. Motors that the user leaves out, or of which the user
    saw nothing, are unclear.
    """
    check = check_of(arm.config, None)
    yield from say(*picture, _explanation(arm))
    if not (
        yield from agreed(
            "Switch the motors on and begin?", "Anything but yes leaves the arm alone."
        )
    ):
        return Signs(unclear=tuple(motor.name for motor in check.transmission.motors))
    _make_ready(arm)
    while check.trial is not None:
        yield from _try(arm, check)
    return check.signs()


def _explanation(arm: Arm) -> str:
    return (
        "Have the arm stand roughly like this, clear of everything, fingers half open. Stand "
        "behind it: left and right are yours as you look along the arm, clockwise as you look "
        "along the hand. Keep a hand at the power switch; a stop takes up to "
        f"{arm.status.stop_time_s:.2f} s."
    )


def _try(arm: Arm, check: DirectionCheck) -> Talk[None]:
    """Turn the next motor there and back, and take the user's answer."""
    trial = check.trial
    if trial is None:
        return
    turn = f"Motor {trial.motor + 1} ({trial.name}) will turn {trial.steps} steps and back. Now?"
    if not (yield from agreed(turn, "no leaves this motor out.", default="yes")):
        check.saw(SawMotion.NOT_AT_ALL)
        return
    yield Look(moved=False)
    _turn(arm, check)
    yield Look(moved=True)
    _turn(arm, check)
    word, roll = yield from ask_way(trial)
    if word != AGAIN:
        check.note(trial.seen(word, roll))


def _turn(arm: Arm, check: DirectionCheck) -> None:
    """Turn one motor; a board that is locked until it has homed is unlocked by `reset`."""
    steps = check.steps(arm.abilities.motors)
    try:
        arm.move_motors(*steps, speed=TRIAL_SPEED)
    except DeviceFault:
        if check.away or arm.config.homing is None:
            raise
        arm.reset()
        _make_ready(arm)
        arm.move_motors(*steps, speed=TRIAL_SPEED)
    check.turned()


def _make_ready(arm: Arm) -> None:
    """Switch the motors on if they are off. Moves nothing."""
    if arm.status.state is State.DISABLED:
        arm.enable()
