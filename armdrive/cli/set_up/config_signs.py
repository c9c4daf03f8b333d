"""Find which way the motors count: each one turns a little, and you say what you saw.

Nothing moves before you have agreed. Each motor turns alone, slowly, a few degrees at most, and
back again. The lines that belong into the arm file are printed; the file stays as it is.
"""

from __future__ import annotations

import argparse
import sys

from armdrive.arm import Arm
from armdrive.cli.arm_files import ArmText, read
from armdrive.cli.presenter import emit, say
from armdrive.cli.questions import agree, ask_value
from armdrive.cli.terminal_person import posture_drawing
from armdrive.config.arm import ArmConfig
from armdrive.connect import parts as connecting
from armdrive.connect.target import simulation_forced
from armdrive.dialog.conversation import Question, choice
from armdrive.errors import DeviceFault, OperatorNeeded
from armdrive.registry.arm_files import load_arm
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


def run(options: argparse.Namespace) -> int:
    """Find the directions, and print the lines."""
    text = read(options.name)
    config = load_arm(text.path)
    with connected(config, simulated=options.sim, alone=options.yes or options.json) as arm:
        signs = find_signs(arm, alone=options.yes or options.json)
    lines = lines_for(text, signs)
    if options.json:
        emit(
            {
                "reversed_motors": list(signs.motors),
                "reversed_joints": list(signs.joints),
                "unclear": list(signs.unclear),
                "lines": lines,
            }
        )
        return 1 if signs.unclear else 0
    for line in [*lines, *_unclear(signs)]:
        say(line)
    return 1 if signs.unclear else 0


WATCHED = "watch a real arm while its motors turn"


def connected(
    config: ArmConfig, *, simulated: bool, alone: bool = False, wanted: str = WATCHED
) -> _OpenArm:
    """Return the arm to be opened in a `with`. Raises `OperatorNeeded` for a real one alone."""
    simulated = simulated or simulation_forced()
    if not simulated and (alone or not sys.stdin.isatty()):
        raise OperatorNeeded(f"somebody has to {wanted}: answer at a terminal, or give --sim")
    return _OpenArm(config, simulated)


class _OpenArm:
    """An open arm that was not enabled: nothing is switched on before somebody has agreed."""

    def __init__(self, config: ArmConfig, simulated: bool) -> None:
        self._config = config
        self._simulated = simulated

    def __enter__(self) -> Arm:
        simulated = self._simulated
        open_arm = connecting.connect_simulated if simulated else connecting.connect_real
        self._arm = Arm(open_arm(self._config))
        return self._arm

    def __exit__(self, *_error: object) -> None:
        self._arm.close()


def find_signs(arm: Arm, *, alone: bool = False) -> Signs:
    """Turn each motor of a connected arm and return what was seen to be reversed.

    `alone`: nobody is asked, and the simulated arm is looked at. Motors that were left out, or of
    which nothing was seen, are unclear.
    """
    transmission = arm.core.transmission
    posture = found_posture(arm.model.arm)
    if not alone:
        _explain(arm)
        if not agree("Switch the motors on and begin?", "Anything but yes leaves the arm alone."):
            return Signs(unclear=tuple(motor.name for motor in transmission.motors))
    _make_ready(arm)
    seen = [
        _tried(arm, trial, alone=alone) for trial in trials(arm.model.arm, transmission, posture)
    ]
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


def _explain(arm: Arm) -> None:
    for line in posture_drawing(arm, found_posture(arm.model.arm), 30.0):
        say(line)
    bound = arm.status
    say(
        "Have the arm stand roughly like this, clear of everything, fingers half open. Stand "
        "behind it: left and right are yours as you look along the arm, clockwise as you look "
        "along the hand. Keep a hand at the power switch; a stop takes up to "
        f"{bound.stop_time_s:.2f} s."
    )


def _tried(arm: Arm, trial: Trial, *, alone: bool) -> SeenMotion:
    """Turn one motor and back, as often as asked, and return what was seen."""
    while True:
        if not alone and not agree(
            f"Motor {trial.motor + 1} ({trial.name}) will turn {trial.steps} steps and back. Now?",
            "no leaves this motor out.",
            "yes",
        ):
            return SeenMotion(trial, NOTHING)
        looked = _turn(arm, trial)
        word, roll = _of_twin(trial, looked) if looked else ("", "")
        if looked and not alone:
            say(f"  (seen on the simulated arm: {looked})")
        if not alone:
            word = ask_value(_what(trial, word))
        if word == AGAIN:
            continue
        if not alone and trial.turns_hand and word not in (NOTHING, OTHER):
            roll = ask_value(_hand(roll))
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


def lines_for(text: ArmText, signs: Signs) -> list[str]:
    """Return the lines of the arm file that turn the found directions over."""
    if "motors" in text.table:
        return [
            *(
                f"[[motors]] {name}: turn the signs of sees and follows over"
                for name in signs.motors
            ),
            *(f"[[motors]]: turn the sign of {joint} over in every sees" for joint in signs.joints),
        ] or ["every direction is right as it is"]
    lines = []
    for section, names in (("motor_signs", signs.motors), ("joint_signs", signs.joints)):
        known = dict(text.table.get(section, {}))
        turned = known | {name: -known.get(name, 1) for name in names}
        if names:
            lines += [f"[{section}]", *(f'"{name}" = {sign}' for name, sign in turned.items())]
    return lines or ["every direction is right as it is"]


def _unclear(signs: Signs) -> list[str]:
    if not signs.unclear:
        return []
    names = ", ".join(signs.unclear)
    return [f"not told: {names}. Look at plugs and drivers, then ask for this once more"]
