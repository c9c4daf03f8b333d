"""Checks of a connected arm for which a person looks or presses: directions and limit switches."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

from armdrive.config.arm import ArmConfig, HasLimits
from armdrive.dialog import About, ArmMotion, Dialog, Question, choice, number, yes_or_no
from armdrive.errors import DeviceFault, Refused, SettingsDiffer
from armdrive.errors.printable import command_line
from armdrive.errors.table import named
from armdrive.setup.directions import (
    FINGERS,
    TRIAL_SPEED,
    WAYS,
    SawMotion,
    SeenMotion,
    Sight,
    Signs,
    Trial,
    check_of,
    sight,
)
from armdrive.setup.filing import FileProposal, propose_keys
from armdrive.status import State, longest
from kinematics.text import shown_name

if TYPE_CHECKING:
    from armdrive.arm import Arm


# Which way the motors count: each turns a little and back, and the user says what moved.
#
# Each motor turns alone, slowly, a few degrees at most. Nothing moves before the user agrees. A
# motor is brought back before each question, so that nothing stands away while a person thinks.

# The first motion is this part of the second: with wrong steps in the arm file, a joint turns
# that many times too far.
SMALL_PART = 8
# A motion this many times as far as announced is noticed, however small it is.
MUCH_FARTHER = 2.5
# The arm file's steps are right if the motion that was seen differs by at most this share.
TOLERANCE = 0.2
MOST_SEEN = 10_000.0  # degrees or mm: more is a slip of the finger

NOTHING, OTHER, AGAIN = "nothing", "other", "again"


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
    arm.reset()  # a board that is locked until it has homed would turn nothing
    arm.enable()
    while (trial := check.trial) is not None:
        seen = _tried(dialog, arm, trial)
        if seen is not None:
            check.note(seen)
    return check.signs()


def before_trials(shown: str, stop_s: float | None) -> str:
    """Say where arm and user stand before motors turn; `shown` is where the posture is seen."""
    stop = "" if stop_s is None else f"; a stop takes up to {longest(stop_s)}"
    return (
        f"Have the arm stand roughly {shown}, clear of everything, fingers half open. Stand "
        "behind it: left and right are yours as you look along the arm, clockwise as you look "
        f"along the hand. Keep a hand at the power switch{stop}."
    )


def _tried(dialog: Dialog, arm: Arm, trial: Trial) -> SeenMotion | None:
    """Turn a motor a very little, then a little, and return what the user saw.

    None means that the user wants to see it again.
    """
    small_steps = max(trial.steps // SMALL_PART, 1)
    small = trial.amount * small_steps / trial.steps
    turn = (
        f"Motor {trial.motor + 1} ({trial.name}) will turn the {shown_name(trial.moves)} by about "
        f"{trial.shown(small)} and back, then by {trial.shown(trial.amount)} and back. Now?"
    )
    if not dialog.agreed(turn, "no leaves this motor out.", default="yes"):
        return SeenMotion(trial, SawMotion.NOT_AT_ALL)
    _there_and_back(dialog, arm, trial.motor, small_steps)
    if not _ask_small(dialog, trial, small):
        return SeenMotion(trial, SawMotion.ELSE_FAR, share=_ask_share(dialog, trial, small))
    _there_and_back(dialog, arm, trial.motor, trial.steps)
    word = _ask_way(dialog, trial)
    if word == AGAIN:
        return None
    if word in (NOTHING, OTHER):
        return SeenMotion(trial, SawMotion.NOT_AT_ALL if word == NOTHING else SawMotion.ANOTHER)
    saw = SawMotion.AS_SHOWN if trial.expects(word) else SawMotion.OTHER_WAY
    hand = _ask_hand(dialog, trial) if trial.turns_hand else None
    return SeenMotion(trial, saw, hand, share=_ask_share(dialog, trial, trial.amount))


def _there_and_back(dialog: Dialog, arm: Arm, motor: int, steps: int) -> None:
    dialog.person.look(moved=False)
    _turn(arm, motor, steps)
    dialog.person.look(moved=True)
    _turn(arm, motor, -steps)


def _turn(arm: Arm, motor: int, steps: int) -> None:
    counts = [0] * arm.abilities.motors
    counts[motor] = steps
    arm.move_motors(*counts, speed=TRIAL_SPEED)


def _ask_small(dialog: Dialog, trial: Trial, about: float) -> bool:
    """Ask whether a small motion was no larger than announced; it may be too small to be seen."""
    question = Question(
        f"Was that about {trial.shown(about)}, or too little to see?",
        "no: it was much more than that. Then its steps in the arm file are wrong, and it makes "
        "no larger motion.",
        yes_or_no,
        "yes",
        by_eye=lambda motion: "no" if _moved(trial, motion) > MUCH_FARTHER * about else "yes",
    )
    return bool(dialog.ask(question))


def _ask_way(dialog: Dialog, trial: Trial) -> str:
    """Ask which way a motor moved the arm."""
    words = (*(word for way in trial.ways for word in WAYS[way]), NOTHING, OTHER, AGAIN)

    def by_eye(motion: ArmMotion) -> str:
        seen = _sight(motion)
        return next((seen.word(way) for way in seen.visible() if way in trial.ways), NOTHING)

    question = Question(
        f"Which way did it go? {', '.join(words)}:",
        f"{OTHER}: something else moved, so this motor is wired in another one's place. {AGAIN}: "
        "show me again.",
        choice(words),
        by_eye=by_eye,
    )
    return str(dialog.ask(question))


def _ask_hand(dialog: Dialog, trial: Trial) -> bool | None:
    """Ask which way the hand turned; return whether that was expected, None if it was not seen."""
    words = (*WAYS["roll"], NOTHING)
    question = Question(
        f"And the hand turned about its own axis? {', '.join(words)}:",
        "Seen from behind the hand, looking towards the finger tips.",
        choice(words),
        by_eye=lambda motion: _sight(motion).word("roll"),
    )
    word = dialog.ask(question)
    return None if word == NOTHING else trial.expects(word)


def _ask_share(dialog: Dialog, trial: Trial, about: float) -> float:
    """Ask how far a motor moved; return it as a share of what was expected, 1 if it is right."""
    unit = "mm" if trial.moves == FINGERS else "degrees"
    question = Question(
        f"How far did the {shown_name(trial.moves)} move, in {unit}?",
        "Measure it, or judge it by eye: an error of a fifth is small enough to find a wrong gear.",
        number(0.001, MOST_SEEN),
        f"{about:.2g}",
        by_eye=lambda motion: f"{_moved(trial, motion):.3g}",
    )
    share = float(dialog.ask(question)) / about
    return 1.0 if abs(share - 1.0) <= TOLERANCE else float(f"{share:.3g}")


def _sight(motion: ArmMotion) -> Sight:
    """Return what is seen of a motion."""
    return sight(motion.arm, motion.before, motion.after, motion.opened_mm)


def _moved(trial: Trial, motion: ArmMotion) -> float:
    """Return how far the joint or the fingers moved, in degrees or mm."""
    return abs(motion.opened_mm if trial.moves == FINGERS else motion.turned_deg(trial.moves))


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
    NOTHING = "the board sees nothing of it, perhaps another switch"
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
        press = Question(
            f"Press the limit switch of {switch.motor} ({switch.axis}) by hand, and hold it. Type "
            "pressed, or none if it has none:",
            "The arm stands still throughout. The board should raise an alarm.",
            choice(("pressed", "none")),
            about=About.PRESS,
            motor=switch.index,
        )
        if dialog.ask(press) == "none":
            seen[switch.motor] = SawSwitch.NONE
            continue
        seen[switch.motor] = _reaction(arm, switch)
        release = Question(
            "Let go of it. Type released:",
            "The next switch follows.",
            choice(("released",)),
            about=About.RELEASE,
            motor=switch.index,
        )
        dialog.ask(release)
        _clear(arm)  # the release of a switch is a change too, and raises an alarm
    return seen


def _reaction(arm: Arm, switch: WiredSwitch) -> SawSwitch:
    """Return what the board makes of a switch that is pressed now; an alarm is reset."""
    alarmed = _clear(arm)
    if not arm.io.read() >> switch.bit & 1:
        return SawSwitch.NOTHING
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
