"""Which way the motors count: each one turns a little, and somebody says what was to be seen.

Each motor turns alone, slowly, a few degrees at most, and back again. Nothing moves before that is
agreed to.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from armdrive.arm import Arm
from armdrive.dialog.conversation import AskPerson, Question, choice, yes_or_no
from armdrive.errors import DeviceFault
from armdrive.setup.dialog_runner import DialogPerson
from armdrive.setup.directions import (
    AGAIN,
    NOTHING,
    OTHER,
    TRIAL_SPEED,
    WAYS,
    SeenMotion,
    Sight,
    Signs,
    Trial,
    conclude,
    roll_joint,
    sight,
    trials,
)
from armdrive.sim.world.body import found_posture
from armdrive.status import State


def find_signs(arm: Arm, person: DialogPerson | None, picture: Sequence[str] = ()) -> Signs:
    """Turn each motor of a connected arm and return what was seen to be reversed.

    Without a person nobody is asked, and the simulated arm is looked at. `picture` shows the
    posture to begin in. Motors that were left out, or of which nothing was seen, are unclear.
    """
    transmission = arm.core.transmission
    posture = found_posture(arm.model.arm)
    if person is not None:
        for line in (*picture, _explanation(arm)):
            person.tell(line)
        why = "Anything but yes leaves the arm alone."
        if not _agrees(person, "Switch the motors on and begin?", why):
            return Signs(unclear=tuple(motor.name for motor in transmission.motors))
    _make_ready(arm)
    seen = [_tried(arm, trial, person) for trial in trials(arm.model.arm, transmission, posture)]
    return conclude(seen, roll_joint(arm.model.arm, posture))


def _make_ready(arm: Arm) -> None:
    """Switch the motors on where they are off. Moves nothing."""
    if arm.status.state is State.DISABLED:
        arm.enable()


def _move(arm: Arm, trial: Trial, sign: int) -> None:
    """Turn one motor; a board that is locked until it has homed is unlocked by `reset`."""
    steps = [0] * arm.abilities.motors
    steps[trial.motor] = sign * trial.steps
    try:
        arm.move_motors(*steps, speed=TRIAL_SPEED)
    except DeviceFault:
        if sign < 0 or arm.config.homing is None:
            raise
        arm.reset()
        _make_ready(arm)
        arm.move_motors(*steps, speed=TRIAL_SPEED)


def _explanation(arm: Arm) -> str:
    return (
        "Have the arm stand roughly like this, clear of everything, fingers half open. Stand "
        "behind it: left and right are yours as you look along the arm, clockwise as you look "
        "along the hand. Keep a hand at the power switch; a stop takes up to "
        f"{arm.status.stop_time_s:.2f} s."
    )


def _agrees(person: DialogPerson, words: str, why: str, default: str = "no") -> bool:
    return bool(person.answer(AskPerson(Question("", words, why, yes_or_no, default))))


def _tried(arm: Arm, trial: Trial, person: DialogPerson | None) -> SeenMotion:
    """Turn one motor and back, as often as asked, and return what was seen."""
    if person is None:
        looked = _turn(arm, trial)
        return SeenMotion(trial, *(_of_twin(trial, looked) if looked else ("", "")))
    turn = f"Motor {trial.motor + 1} ({trial.name}) will turn {trial.steps} steps and back. Now?"
    while True:
        if not _agrees(person, turn, "no leaves this motor out.", "yes"):
            return SeenMotion(trial, NOTHING)
        looked = _turn(arm, trial)
        word, roll = _of_twin(trial, looked) if looked else ("", "")
        if looked:
            person.tell(f"  (seen on the simulated arm: {looked})")
        word = person.answer(AskPerson(_what(trial, word)))
        if word == AGAIN:
            continue
        if trial.turns_hand and word not in (NOTHING, OTHER):
            roll = person.answer(AskPerson(_hand(roll)))
        return SeenMotion(trial, word, roll)


def _turn(arm: Arm, trial: Trial) -> Sight | None:
    """Turn there and back; return what a simulated observer saw half-way."""
    twin = arm.twin
    before = (twin.world.joints, twin.world.opening_mm) if twin else None
    _move(arm, trial, 1)
    seen = None
    if twin is not None and before is not None:
        opened_mm = twin.world.opening_mm - before[1]
        seen = sight(twin.world.body.arm, before[0], twin.world.joints, opened_mm)
    _move(arm, trial, -1)
    return seen


def _of_twin(trial: Trial, seen: Sight) -> tuple[str, str]:
    ways = [way for way in seen.visible() if way in trial.ways]
    roll = seen.word("roll") if "roll" in seen.visible() else ""
    return (seen.word(ways[0]) if ways else NOTHING, roll)


def _what(trial: Trial, default: str) -> Question:
    words = (*trial.words(), NOTHING, OTHER, AGAIN)
    return Question(
        trial.name,
        f"What did you see first? {', '.join(words)}:",
        f"{OTHER}: something else moved, so the wiring's order differs. {AGAIN}: show me again.",
        choice(words),
        default or None,
    )


def _hand(default: str) -> Question:
    words = (*WAYS["roll"], NOTHING)
    return Question(
        "roll",
        f"And the hand turned about its own axis? {', '.join(words)}:",
        "Seen from behind the hand, looking towards the finger tips.",
        choice(words),
        default or None,
    )


def lines_for(table: Mapping[str, Any], signs: Signs) -> list[str]:
    """Return the lines of the arm file that turn the found directions over."""
    if "motors" in table:
        return [
            *(
                f"[[motors]] {name}: turn the signs of sees and follows over"
                for name in signs.motors
            ),
            *(f"[[motors]]: turn the sign of {joint} over in every sees" for joint in signs.joints),
        ] or ["every direction is right as it is"]
    lines = []
    for section, names in (("motor_signs", signs.motors), ("joint_signs", signs.joints)):
        known = dict(table.get(section, {}))
        turned = known | {name: -known.get(name, 1) for name in names}
        if names:
            lines += [f"[{section}]", *(f'"{name}" = {sign}' for name, sign in turned.items())]
    return lines or ["every direction is right as it is"]
