"""From what a person saw of each motor to what its arm file ought to say instead.

Four things are told apart: a motor counts the other way, its steps per turn are wrong, another
motor is behind its number, or nothing moves. The first three are keys of the arm file.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from armdrive.interview.sight import WAYS
from armdrive.interview.signs import NOTHING, OTHER, Seen, Signs, Trial, conclude
from kinematics import Transmission

DIGITS = 9


class Saw(Enum):
    """What was seen of one motor, beside what ought to be seen."""

    AS_SHOWN = "it moved as shown"
    OTHER_WAY = "it moved the other way"
    NOT_AT_ALL = "nothing moved"
    ANOTHER = "another motor's part moved"
    TWICE = "about twice as far"
    HALF = "about half as far"


FARTHER: Mapping[Saw, float] = {Saw.TWICE: 2.0, Saw.HALF: 0.5}
"""How far it went, as a share of what the arm file says."""


@dataclass(frozen=True, slots=True)
class Look:
    """What was seen of one trial; `instead` names the motor whose part moved, `hand` how it turned.

    `hand` is a word of `WAYS["roll"]`, empty where it was not asked for.
    """

    trial: Trial
    saw: Saw
    instead: str = ""
    hand: str = ""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What all looks together say. `farther` is by motor; `order` the motor seen, by the one meant.

    Both leave out those that are right.
    """

    signs: Signs = field(default_factory=Signs)
    farther: Mapping[str, float] = field(default_factory=dict)
    order: Mapping[str, str] = field(default_factory=dict)

    @property
    def right(self) -> bool:
        """Whether nothing at all has to be changed or looked at."""
        return not (self.farther or self.order or any((self.signs.motors, self.signs.joints)))


@dataclass(frozen=True, slots=True)
class Change:
    """One key of an arm file, its new value, and why: `motors` are reached by their index."""

    path: tuple[str | int, ...]
    value: Any
    why: str

    @property
    def name(self) -> str:
        """The key as people write it."""
        return ".".join(map(str, self.path))


def judge(looks: Iterable[Look], roll_joint: str) -> Verdict:
    """Return what the looks say; a motor that was another one's tells nothing of directions."""
    looks = tuple(looks)
    order = {each.trial.name: each.instead for each in looks if each.saw is Saw.ANOTHER}
    farther = {each.trial.name: FARTHER[each.saw] for each in looks if each.saw in FARTHER}
    signs = conclude(map(_seen, looks), roll_joint)
    unclear = tuple(name for name in signs.unclear if name not in order)
    signs = Signs(signs.motors, signs.joints, unclear)
    return Verdict(signs, farther, order)


def _seen(look: Look) -> Seen:
    way = look.trial.ways[0]
    word = look.trial.expected.word(way)
    if look.saw is Saw.OTHER_WAY:
        word = next(each for each in WAYS[way] if each != word)
    gone = {Saw.NOT_AT_ALL: NOTHING, Saw.ANOTHER: OTHER}
    return Seen(look.trial, gone.get(look.saw, word), look.hand)


def swapped(verdict: Verdict) -> bool:
    """Tell whether those that changed places are the same as those in whose place they are."""
    return bool(verdict.order) and set(verdict.order) == set(verdict.order.values())


def changes(
    table: Mapping[str, Any], transmission: Transmission, verdict: Verdict
) -> tuple[Change, ...]:
    """Return the keys of an arm file's table that have to say something else, but for the order."""
    if "motors" in table:
        return tuple(_of_motors(table["motors"], verdict))
    return tuple(_of_preset(table, transmission, verdict))


def _of_preset(
    table: Mapping[str, Any], transmission: Transmission, verdict: Verdict
) -> Iterator[Change]:
    for section, names in (
        ("motor_signs", verdict.signs.motors),
        ("joint_signs", verdict.signs.joints),
    ):
        for name in names:
            known = table.get(section, {}).get(name, 1)
            yield Change((section, name), -known, Saw.OTHER_WAY.value)
    turning = len(transmission.joint_names)
    for index, motor in enumerate(transmission.motors):
        share = verdict.farther.get(motor.name)
        if share is None:
            continue
        if index >= turning:
            known = table.get("steps_per_mm", abs(motor.steps_per_unit))
            yield Change(("steps_per_mm",), _short(known / share), _far(share))
        else:
            own = abs(motor.steps_per_unit) * math.tau
            known = table.get("steps_per_turn", {}).get(motor.name, own)
            yield Change(("steps_per_turn", motor.name), _short(known / share), _far(share))


def _of_motors(motors: list[Mapping[str, Any]], verdict: Verdict) -> Iterator[Change]:
    """Give the changes of a list of motors: what follows a motor follows its direction as well."""
    turned = dict.fromkeys(verdict.signs.motors, -1)
    joints = dict.fromkeys(verdict.signs.joints, -1)
    for index, motor in enumerate(motors):
        name = str(motor.get("name"))
        own = turned.get(name, 1)
        sees = {key: one * own * joints.get(key, 1) for key, one in motor.get("sees", {}).items()}
        if "sees" not in motor and own < 0:
            sees = {"opening": -1}  # what a motor of fingers sees that says nothing
        if sees and sees != motor.get("sees"):
            yield Change(("motors", index, "sees"), sees, Saw.OTHER_WAY.value)
        share = verdict.farther.get(name)
        if share is not None:
            key = "steps_per_mm" if "steps_per_mm" in motor else "steps_per_turn"
            yield Change(("motors", index, key), _short(motor[key] / share), _far(share))
        yield from _follows(index, motor, own, turned, verdict.farther)


def _follows(
    index: int,
    motor: Mapping[str, Any],
    own: int,
    turned: Mapping[str, int],
    farther: Mapping[str, float],
) -> Iterator[Change]:
    """Give the steps that are added for another motor's: whole numbers, so only if they stay so."""
    known = motor.get("follows", {})
    mine = farther.get(str(motor.get("name")), 1.0)
    exact = {
        other: ratio * own * turned.get(other, 1) * farther.get(other, 1.0) / mine
        for other, ratio in known.items()
    }
    if all(one == int(one) for one in exact.values()):
        now = {other: int(one) for other, one in exact.items()}
    else:
        now = {other: ratio * own * turned.get(other, 1) for other, ratio in known.items()}
    if now != known:
        yield Change(("motors", index, "follows"), now, "its motors were corrected")


def _far(share: float) -> str:
    return f"it went {share:g} times as far as this said before"


def _short(steps: float) -> float:
    """Return the number without digits that no arm has."""
    return float(f"{steps:.{DIGITS}g}")
