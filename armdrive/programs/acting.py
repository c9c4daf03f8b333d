"""The acts of the words: which one a word asks for, from values that have been computed."""

# ruff: noqa: ARG001 - one form for all functions of the table below

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.programs.acts import (
    Act,
    AwaitInputs,
    Delay,
    Fingers,
    Go,
    Grasp,
    Hold,
    Home,
    Outputs,
    Ready,
    Remember,
    Say,
)
from armdrive.programs.bounds import out_of_bounds, slot_of
from armdrive.programs.functions import backed, moved
from armdrive.programs.values import (
    ForwardKinematics,
    Place,
    Trouble,
    Value,
    number,
    place,
    pose_of,
    said,
)
from armdrive.programs.vocabulary import WORDS


@dataclass(frozen=True, slots=True)
class Setting:
    """What is so when an act is asked for."""

    speed: float
    opening_mm: float | None
    """What the fingers are to do with a move, where that is an opening in mm."""
    about: str
    fk: ForwardKinematics | None


Values = Sequence[Value]


def act_of(word: str, values: Values, setting: Setting) -> Act:
    """Return the act of a word. Raises `Trouble` for values that it does not take."""
    return _ACTS[word](word, values, setting)


def bounded(word: str, index: int, value: object) -> float:
    """Return a number that a word takes there. Raises `Trouble` where it is out of its bounds."""
    found = number(value)
    slot = slot_of(WORDS[word].slots, index)
    wrong = None if slot is None else out_of_bounds(slot, found)
    if wrong is not None:
        raise Trouble(wrong)
    return found


def _go(word: str, goal: Place, setting: Setting, opening_mm: float | None = None) -> Go:
    line = "_line" in word or word == "draw"
    opening = setting.opening_mm if opening_mm is None else opening_mm
    return Go(goal.goal, line, setting.speed, opening, setting.about)


def _move(word: str, values: Values, setting: Setting) -> Act:
    return _go(word, place(values[0]), setting)


def _move_with(word: str, values: Values, setting: Setting) -> Act:
    return _go(word, place(values[0]), setting, bounded(word, 1, values[1]))


def _approach(word: str, values: Values, setting: Setting) -> Act:
    pose = pose_of(place(values[0]), setting.fk)
    return _go(word, Place(backed(pose, number(values[1]))), setting)


def _draw(word: str, values: Values, setting: Setting) -> Act:
    pose = pose_of(place(values[0]), setting.fk)
    return _go(word, Place(moved(pose, *(number(value) for value in values[1:]))), setting)


def _ready(word: str, values: Values, setting: Setting) -> Act:
    return Ready(setting.speed)


def _home(word: str, values: Values, setting: Setting) -> Act:
    return Home()


def _open_now(word: str, values: Values, setting: Setting) -> Act:
    return Fingers(bounded(word, 0, values[0]) if values else None, setting.speed)


def _close_now(word: str, values: Values, setting: Setting) -> Act:
    return Fingers(0.0, setting.speed)


def _grasp(word: str, values: Values, setting: Setting) -> Act:
    return Grasp()


def _delay(word: str, values: Values, setting: Setting) -> Act:
    return Delay(bounded(word, 0, values[0]))


def _parted(word: str, values: Values) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the numbers that are on, and those with a minus, which are off."""
    counts = [int(bounded(word, index, value)) for index, value in enumerate(values)]
    on = tuple(dict.fromkeys(count for count in counts if count > 0))
    off = tuple(dict.fromkeys(-count for count in counts if count < 0))
    both = set(on) & set(off)
    if both:
        raise Trouble(f"{min(both)} cannot be both on and off")
    return on, off


def _signal(word: str, values: Values, setting: Setting) -> Act:
    return Outputs(*_parted(word, values))


def _wait(word: str, values: Values, setting: Setting) -> Act:
    return AwaitInputs(*_parted("wait", values))


def _wait_within(word: str, values: Values, setting: Setting) -> Act:
    limit = number(values[-1])
    if limit < 0.0:
        raise Trouble(f"a time is at least 0 s, not {said(limit)}")
    return AwaitInputs(*_parted("wait", values[:-1]), limit)


def told(values: Values) -> str:
    """Return values as one line for people."""
    return " ".join(said(value) for value in values)


def _say(word: str, values: Values, setting: Setting) -> Act:
    return Say(told(values))


def _hold(word: str, values: Values, setting: Setting) -> Act:
    return Hold(told(values))


def _remember(word: str, values: Values, setting: Setting) -> Act:
    found = place(values[0])
    return Remember(setting.about, found.joints_deg or {}, found.opening_mm)


_ACTS: Mapping[str, Callable[[str, Values, Setting], Act]] = MappingProxyType({
    "move": _move, "move_line": _move, "move_with": _move_with, "move_line_with": _move_with,
    "approach": _approach, "approach_line": _approach, "depart": _approach,
    "depart_line": _approach, "draw": _draw, "ready": _ready, "home": _home,
    "open_now": _open_now, "close_now": _close_now, "grasp": _grasp, "delay": _delay,
    "signal": _signal, "wait": _wait, "wait within": _wait_within, "type": _say, "hold": _hold,
    "remember": _remember,
})  # fmt: skip
