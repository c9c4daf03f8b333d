"""Directions of motors and joints from what a person saw: trials, answers, and their conclusion.

Each motor is turned alone, since the cables of a Mini-mover make one motor move several joints.
What ought to be seen follows from the model; where the other way was seen, the motor counts the
other way. The hand's turning tells of the two wrist motors together: where both turn it the other
way than their pitch says, it is the roll joint that is reversed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from armdrive.interview.readers import WrongAnswer
from armdrive.interview.sight import WAYS, Sight, sight
from kinematics import Joints, Transmission
from kinematics.geometry import ArmGeometry

TRIAL_MM = 10.0
TRIAL_RAD = math.radians(5.0)
TRIAL_OPENING_MM = 3.0
"""A trial is the shorter of these: what is seen at the tip, any joint's turn, the fingers' way."""

TRIAL_SPEED = 0.1
"""The share of the motors' speed at which they are tried."""

NOTHING, OTHER, AGAIN = "nothing", "other", "again"


@dataclass(frozen=True, slots=True)
class Trial:
    """One motor turned alone by some steps, and what ought to be seen of it."""

    motor: int
    name: str
    steps: int
    expected: Sight

    @property
    def ways(self) -> tuple[str, ...]:
        """The directions to ask for; the hand's turning only where nothing else is seen."""
        seen = self.expected.visible()
        return tuple(way for way in seen if way != "roll") or seen

    @property
    def turns_hand(self) -> bool:
        """Whether the hand's turning has to be asked for beside another direction."""
        return "roll" in self.expected.visible() and self.ways != ("roll",)

    def words(self) -> tuple[str, ...]:
        """Return the words that an answer may be."""
        return tuple(word for way in self.ways for word in WAYS[way])


@dataclass(frozen=True, slots=True)
class Seen:
    """What somebody saw of a trial: a word, and which way the hand turned where that was asked."""

    trial: Trial
    word: str
    roll: str = ""


@dataclass(frozen=True, slots=True)
class Signs:
    """What is reversed, and what could not be told."""

    motors: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    unclear: tuple[str, ...] = ()


def trials(arm: ArmGeometry, transmission: Transmission, posture: Joints) -> tuple[Trial, ...]:
    """Return a trial of each motor, the gripper's first: it makes room for the fingers."""
    order = list(range(len(transmission.motors)))
    if transmission.has_gripper:
        order = [order[-1], *order[:-1]]
    return tuple(_trial(arm, transmission, posture, motor) for motor in order)


def _trial(arm: ArmGeometry, transmission: Transmission, posture: Joints, motor: int) -> Trial:
    column = [row[motor] for row in transmission.inverse]
    count = len(transmission.joint_names)
    turning = column[:count]
    pulling = column[count] if transmission.has_gripper else 0.0
    probe = 1e-3 / max(*map(abs, turning), abs(pulling) * 1e-2)
    one = _seen(arm, posture, turning, pulling, probe)
    steps = min(
        TRIAL_MM * probe / max(one.strongest_mm, 1e-9),
        TRIAL_RAD / max(*map(abs, turning), 1e-12),
        TRIAL_OPENING_MM / abs(pulling) if pulling else math.inf,
    )
    whole = max(round(steps), 1)
    expected = _seen(arm, posture, turning, _own_pull(turning, pulling), whole)
    return Trial(motor, transmission.motors[motor].name, whole, expected)


def _own_pull(turning: list[float], pulling: float) -> float:
    """Return the fingers' way of the gripper's own motor: what follows another one is not asked."""
    return pulling if max(map(abs, turning)) == 0.0 else 0.0


def _seen(
    arm: ArmGeometry, posture: Joints, turning: list[float], pulling: float, steps: float
) -> Sight:
    angles = tuple(angle + steps * one for angle, one in zip(posture, turning, strict=True))
    return sight(arm, posture, Joints(angles, posture.names), pulling * steps)


def check_word(trial: Trial, word: str) -> None:
    """Raise `WrongAnswer` for a direction in which this motor does not move anything."""
    if word not in trial.words():
        raise WrongAnswer(
            f"the {trial.name} motor should move the arm {' or '.join(trial.words())}; if "
            f"something else moved, answer {OTHER}"
        )


def conclude(seen: Iterable[Seen], roll_joint: str) -> Signs:
    """Return what is reversed; `roll_joint` is the one that two wrist motors turn together."""
    motors, unclear, rolls = [], [], []
    for each in seen:
        if each.word in (NOTHING, OTHER):
            unclear.append(each.trial.name)
            continue
        check_word(each.trial, each.word)
        sign = _agreement(each.trial, each.word)
        if sign < 0:
            motors.append(each.trial.name)
        if each.trial.turns_hand and each.roll in WAYS["roll"]:
            rolls.append(sign * _agreement(each.trial, each.roll))
    if len(set(rolls)) > 1:
        unclear.append(roll_joint)
    joints = (roll_joint,) if rolls and set(rolls) == {-1} else ()
    return Signs(tuple(motors), joints, tuple(unclear))


def _agreement(trial: Trial, word: str) -> int:
    way = next(way for way, words in WAYS.items() if word in words)
    return 1 if trial.expected.word(way) == word else -1


def roll_joint(arm: ArmGeometry, posture: Joints) -> str:
    """Return the joint whose turning is seen as the hand's turning alone, the last such one."""
    found = posture.names[-1]
    for index, name in enumerate(posture.names):
        angles = [angle + (0.01 if at == index else 0.0) for at, angle in enumerate(posture)]
        seen = sight(arm, posture, Joints(tuple(angles), posture.names))
        if seen.visible() == ("roll",):
            found = name
    return found
