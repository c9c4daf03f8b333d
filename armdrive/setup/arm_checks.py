"""Checks of a connected arm for which a person looks or presses: directions and limit switches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

from armdrive.config.arm import ArmConfig, HasLimits
from armdrive.dialog import About, Dialog, Question, choice
from armdrive.errors import DeviceFault, Refused, SettingsDiffer
from armdrive.errors.printable import command_line
from armdrive.errors.table import named
from armdrive.setup.directions import (
    AGAIN,
    NOTHING,
    OTHER,
    TRIAL_SPEED,
    DirectionCheck,
    SawMotion,
    SeenMotion,
    Signs,
    Trial,
    ask_share,
    ask_small,
    ask_way,
    check_of,
)
from armdrive.setup.filing import FileProposal, propose_keys
from armdrive.status import State, longest
from kinematics.text import shown_name

if TYPE_CHECKING:
    from armdrive.arm import Arm


# Which way the motors count: each turns a little and back, and the user says what moved.
#
# Each motor turns alone, slowly, a few degrees at most. Nothing moves before the user agrees.


def find_signs(dialog: Dialog, arm: Arm, picture: Sequence[str] = ()) -> Signs:
    """Turn each motor of a connected arm; return what the user saw.

    `picture` shows the posture to begin in. Motors that the user leaves out, or of which the user
    saw nothing, are unclear.
    """
    check = check_of(arm.config, None)
    dialog.say(*picture, before_trials("like this", arm.status.stop_time_s))
    if not dialog.agreed(
        "Switch the motors on and begin?", "Anything but yes leaves the arm alone."
    ):
        return Signs(unclear=tuple(motor.name for motor in check.transmission.motors))
    arm.enable()
    while (trial := check.trial) is not None:
        _try(dialog, arm, check, trial)
    return check.signs()


def before_trials(shown: str, stop_s: float | None) -> str:
    """Say where arm and user stand before motors turn; `shown` is where the posture is seen."""
    stop = "" if stop_s is None else f"; a stop takes up to {longest(stop_s)}"
    return (
        f"Have the arm stand roughly {shown}, clear of everything, fingers half open. Stand "
        "behind it: left and right are yours as you look along the arm, clockwise as you look "
        f"along the hand. Keep a hand at the power switch{stop}."
    )


# The first motion is this part of the second: with wrong steps in the arm file, a joint turns
# that many times too far.
SMALL_PART = 8


def _try(dialog: Dialog, arm: Arm, check: DirectionCheck, trial: Trial) -> None:
    """Turn a motor a very little, then a little, and take the user's answers.

    It is brought back before each question, so that nothing stands away while a person thinks.
    """
    small_steps = max(trial.steps // SMALL_PART, 1)
    small = trial.amount * small_steps / trial.steps
    turn = (
        f"Motor {trial.motor + 1} ({trial.name}) will turn the {shown_name(trial.moves)} by about "
        f"{trial.shown(small)} and back, then by {trial.shown(trial.amount)} and back. Now?"
    )
    if not dialog.agreed(turn, "no leaves this motor out.", default="yes"):
        check.saw(SawMotion.NOT_AT_ALL)
        return
    _there_and_back(dialog, arm, trial, small_steps)
    if not ask_small(dialog, trial, small):
        share = ask_share(dialog, trial, small)
        check.note(SeenMotion(trial, SawMotion.ELSE_FAR, share=share))
        return
    _there_and_back(dialog, arm, trial, trial.steps)
    word, roll = ask_way(dialog, trial)
    if word == AGAIN:
        return
    seen = trial.seen(word, roll)
    if word not in (NOTHING, OTHER):
        seen = replace(seen, share=ask_share(dialog, trial, trial.amount))
    check.note(seen)


def _there_and_back(dialog: Dialog, arm: Arm, trial: Trial, steps: int) -> None:
    counts = [0] * arm.abilities.motors
    dialog.person.look(moved=False)
    counts[trial.motor] = steps
    _turn(arm, counts)
    dialog.person.look(moved=True)
    counts[trial.motor] = -steps
    arm.move_motors(*counts, speed=TRIAL_SPEED)


def _turn(arm: Arm, counts: Sequence[int]) -> None:
    """Turn one motor; a board that is locked until it has homed is unlocked by `reset`."""
    try:
        arm.move_motors(*counts, speed=TRIAL_SPEED)
    except DeviceFault:
        if arm.config.homing is None:
            raise
        arm.reset()
        arm.enable()
        arm.move_motors(*counts, speed=TRIAL_SPEED)


# Limit switches: the user presses each by hand while the arm stands.
#
# A board may accept that hard limits are on and still ignore its switches: the default build of
# grbl-Mega-5X for RAMPS boards does. So the setting proves nothing. A switch works if the board
# shows its pin and raises an alarm. The day on which all of them did is written into the arm file.

# An alarm is pushed within milliseconds; this is ample for the slowest wire.
SETTLE_S = 0.5

ALARMS = {named("ALARM").code, named("ALARM_VOUCHED").code}

# The key that the day is written under, in the section of the controller.
CHECKED = "hard_limits_checked"


@dataclass(frozen=True, slots=True)
class WiredSwitch:
    """The switch of a motor: its index and name, what the board calls its axis, its input bit."""

    index: int
    motor: str
    axis: str
    bit: int


class SawSwitch(Enum):
    """What the board made of a switch that was pressed."""

    ALARM = "the board sees it, and raises an alarm"
    PIN_ALONE = "the board sees it, and raises no alarm"
    ANOTHER = "the board sees another switch"
    NOTHING = "the board sees nothing"
    NONE = "it has no switch"


def switches_of(config: ArmConfig) -> tuple[WiredSwitch, ...]:
    """Return the switches of an arm. Raises `Refused` where its file counts on none."""
    device = config.device
    if not isinstance(device, HasLimits):
        raise Refused(
            f"the controller of {config.name} ({config.connection.dialect}) has no limit switches "
            "that armdrive can check"
        )
    if not device.hard_limits:
        fix = command_line("doctor", "--arm", config.name, "--fix")
        raise Refused(
            f"the arm file of {config.name} does not say that its controller stops at limit "
            f"switches: write hard_limits = true under [{config.connection.dialect}], then run "
            f"`{fix}`, which writes the board's setting or says where to change it"
        )
    transmission = config.model.transmission
    motors = () if transmission is None else transmission.motors
    wired = zip(motors, device.limit_inputs.items(), strict=False)  # a board may have more axes
    return tuple(
        WiredSwitch(index, motor.name, axis, bit)
        for index, (motor, (axis, bit)) in enumerate(wired)
    )


def make_ready(arm: Arm) -> None:
    """Unlock the board: a locked one raises no alarm. Raises `SettingsDiffer`. Moves nothing."""
    for each in arm.parts.core.differences:
        if "hard limits" in each.setting:
            fix = command_line("doctor", "--arm", arm.config.name, "--fix")
            todo = f"`{fix}` writes it" if each.fix else "change it there"
            raise SettingsDiffer(
                f"{each.setting} is {each.found} in the controller, expected {each.expected}: "
                f"{todo}"
            )
    arm.reset()


def check_switches(
    dialog: Dialog, arm: Arm, switches: Sequence[WiredSwitch]
) -> dict[str, SawSwitch]:
    """Ask for each switch to be pressed and released; return the board's reports, by motor.

    No motor moves, and none is switched on or off. After an alarm the position is suspect.
    """
    seen = {}
    for switch in switches:
        if _ask_for_press(dialog, switch):
            seen[switch.motor] = _reaction(arm, switch, switches)
            _ask_for_release(dialog, switch)
            _clear(arm)  # the release of a switch is a change too, and raises an alarm
        else:
            seen[switch.motor] = SawSwitch.NONE
    return seen


PRESSED, NONE, RELEASED = "pressed", "none", "released"


def _ask_for_press(dialog: Dialog, switch: WiredSwitch) -> bool:
    """Ask for a switch to be pressed; return False if the motor has none."""
    question = Question(
        f"Press the limit switch of {switch.motor} ({switch.axis}) by hand, and hold it. Type "
        f"{PRESSED}, or {NONE} if it has none:",
        "The arm stands still throughout. The board should raise an alarm.",
        choice((PRESSED, NONE)),
    )
    answer = dialog.ask(question, About.PRESS, switch.index)
    return bool(answer == PRESSED)


def _ask_for_release(dialog: Dialog, switch: WiredSwitch) -> None:
    words = f"Let go of it. Type {RELEASED}:"
    question = Question(words, "The next switch follows.", choice((RELEASED,)))
    dialog.ask(question, About.RELEASE, switch.index)


def _reaction(arm: Arm, switch: WiredSwitch, switches: Sequence[WiredSwitch]) -> SawSwitch:
    """Return what the board makes of a switch that is pressed now; an alarm is reset."""
    alarmed = _clear(arm)
    inputs = arm.io.read()
    if not inputs >> switch.bit & 1:
        others = any(inputs >> each.bit & 1 for each in switches)
        return SawSwitch.ANOTHER if others else SawSwitch.NOTHING
    return SawSwitch.ALARM if alarmed else SawSwitch.PIN_ALONE


def _clear(arm: Arm) -> bool:
    """Reset an alarm; return whether there was one. Raises `DeviceFault` for any other error."""
    arm.sleep(SETTLE_S)
    status = arm.status
    if status.state is not State.ERROR_STOP:
        return False
    if status.error_code not in ALARMS:
        raise DeviceFault(status.error)
    arm.reset()
    return True


def all_work(seen: Mapping[str, SawSwitch]) -> bool:
    """Return whether there are switches and each of them raised an alarm."""
    return SawSwitch.ALARM in seen.values() and set(seen.values()) <= {
        SawSwitch.ALARM,
        SawSwitch.NONE,
    }


def record(path: Path, config: ArmConfig, day: date) -> FileProposal:
    """Return the arm file with the day on which all switches were seen to work."""
    keys = {CHECKED: day.isoformat()}
    return propose_keys(path, config.connection.dialect, keys, "seen to raise an alarm")
