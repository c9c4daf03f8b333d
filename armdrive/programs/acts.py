"""What a program asks of an arm, act by act: the seam between a program and its performer.

A program's machine gives acts; a performer carries each out and gives the machine its answer.
Acts are whole when given: places are absolute, numbers are computed, so that an act that was
interrupted can be written down, and be done again from wherever it broke off. Units: mm, deg where
a name says so, s; `speed` is a fraction of the limits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol, TypeAlias

from armdrive.moves import (
    GraspMove,
    GripperMove,
    JointMove,
    LineMove,
    Motion,
    MoveSequence,
    ParkMove,
    PoseMove,
)
from armdrive.programs.language.values import (
    ForwardKinematics,
    PlaceValue,
    Trouble,
    Value,
    backed,
    moved,
    number,
    out_of_bounds,
    place,
    pose_of,
    said,
    slot_of,
)
from armdrive.programs.language.words import WORDS
from armdrive.programs.problems import SourceMark
from kinematics.spaces import Joints, Pose

ProgramMove = Motion | GraspMove | MoveSequence
"""What a program moves by: no jog is in a program."""


@dataclass(frozen=True, slots=True)
class Go:
    """Carry out a move. A grasp is answered with its width in mm, 0 for nothing."""

    move: ProgramMove
    name: str = ""
    """What the program calls the place, for people."""


@dataclass(frozen=True, slots=True)
class Home:
    """Reference the arm, where nobody has yet."""


@dataclass(frozen=True, slots=True)
class Delay:
    """Let time pass on the arm's own clock."""

    time_s: float


@dataclass(frozen=True, slots=True)
class Outputs:
    """Switch outputs, counted from 1: on and off; the others stay."""

    on: tuple[int, ...] = ()
    off: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class AwaitInputs:
    """Wait until inputs, counted from 1, are high and low; with a deadline, answered with a bool.

    Answered True when they are; False when `within_s` is over first. Without it, it waits on.
    """

    high: tuple[int, ...] = ()
    low: tuple[int, ...] = ()
    within_s: float | None = None


@dataclass(frozen=True, slots=True)
class ReadInput:
    """Read an input, counted from 1; answered with a bool."""

    number: int


@dataclass(frozen=True, slots=True)
class Look:
    """Look where the arm stands; answered with `SeenInput`. Sends nothing that moves."""


@dataclass(frozen=True, slots=True)
class SeenInput:
    """Where the arm stands: the answer to `Look`. `opening_mm` is None where nobody knows it."""

    pose: Pose
    joints_deg: Mapping[str, float]
    opening_mm: float | None = None


@dataclass(frozen=True, slots=True)
class Remember:
    """Write a place down under a name, in the arm's own file of points."""

    name: str
    joints_deg: Mapping[str, float]
    opening_mm: float | None = None


@dataclass(frozen=True, slots=True)
class Say:
    """Tell the person a line of text."""

    text: str


@dataclass(frozen=True, slots=True)
class Hold:
    """Wait until a person lets the program go on."""

    text: str = ""


Act: TypeAlias = (
    Go | Home | Delay | Outputs | AwaitInputs | ReadInput | Look | Remember | Say | Hold
)
Answer: TypeAlias = float | bool | SeenInput | None

MOTIONS = (Go, Home)
"""The acts that move the arm."""


_MOVE_NAMES = MappingProxyType({GripperMove: "Fingers", GraspMove: "Grasp", ParkMove: "Ready"})


def act_name(act: Act) -> str:
    """Return what people are told that an act is."""
    if isinstance(act, Go):
        return _MOVE_NAMES.get(type(act.move), "Go")
    return type(act).__name__


@dataclass(frozen=True, slots=True)
class RunStage:
    """An act of a program, and where it stands there; `calls` are the calls that led to it."""

    act: Act
    mark: SourceMark
    calls: tuple[SourceMark, ...] = field(default=())


class ProgramMachine(Protocol):
    """A program under way, pure: it knows no arm and no clock."""

    def next(self) -> RunStage | None:
        """Return the act to be carried out now, the same until it is answered; None at the end."""

    def answer(self, answer: Answer) -> None:
        """Say what the act brought, and go on behind it."""

    def snapshot(self) -> dict[str, object]:
        """Return all that the program knows at this point, as plain JSON data."""


# The acts of the words: which one a word asks for, from values that have been computed.

# ruff: noqa: ARG001 - one form for all functions of the table below


@dataclass(frozen=True, slots=True)
class RunSetting:
    """What is so when an act is asked for."""

    speed: float
    opening_mm: float | None
    """What the fingers are to do with a move, where that is an opening in mm."""
    about: str
    fk: ForwardKinematics | None


Values = Sequence[Value]


def act_of(word: str, values: Values, setting: RunSetting) -> Act:
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


def _go(word: str, goal: PlaceValue, setting: RunSetting, opening_mm: float | None = None) -> Go:
    move = _move_to(goal.goal, setting.speed, line="_line" in word or word == "draw")
    opening = setting.opening_mm if opening_mm is None else opening_mm
    if opening is None:
        return Go(move, setting.about)
    return Go(MoveSequence((GripperMove(opening, setting.speed), move)), setting.about)


def _move_to(goal: Pose | Mapping[str, float], speed: float, *, line: bool) -> Motion:
    if isinstance(goal, Pose):
        return LineMove(goal, speed) if line else PoseMove(goal, speed)
    joints = Joints.of(*goal.values(), names=tuple(goal))
    return LineMove(joints, speed) if line else JointMove(joints, speed)


def _move(word: str, values: Values, setting: RunSetting) -> Act:
    return _go(word, place(values[0]), setting)


def _move_with(word: str, values: Values, setting: RunSetting) -> Act:
    return _go(word, place(values[0]), setting, bounded(word, 1, values[1]))


def _approach(word: str, values: Values, setting: RunSetting) -> Act:
    pose = pose_of(place(values[0]), setting.fk)
    return _go(word, PlaceValue(backed(pose, number(values[1]))), setting)


def _draw(word: str, values: Values, setting: RunSetting) -> Act:
    pose = pose_of(place(values[0]), setting.fk)
    return _go(word, PlaceValue(moved(pose, *(number(value) for value in values[1:]))), setting)


def _ready(word: str, values: Values, setting: RunSetting) -> Act:
    return Go(ParkMove(setting.speed))


def _home(word: str, values: Values, setting: RunSetting) -> Act:
    return Home()


def _open_now(word: str, values: Values, setting: RunSetting) -> Act:
    return Go(GripperMove(bounded(word, 0, values[0]) if values else None, setting.speed))


def _close_now(word: str, values: Values, setting: RunSetting) -> Act:
    return Go(GripperMove(0.0, setting.speed))


def _grasp(word: str, values: Values, setting: RunSetting) -> Act:
    return Go(GraspMove())


def _delay(word: str, values: Values, setting: RunSetting) -> Act:
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


def _signal(word: str, values: Values, setting: RunSetting) -> Act:
    return Outputs(*_parted(word, values))


def _wait(word: str, values: Values, setting: RunSetting) -> Act:
    return AwaitInputs(*_parted("wait", values))


def _wait_within(word: str, values: Values, setting: RunSetting) -> Act:
    limit = number(values[-1])
    if limit < 0.0:
        raise Trouble(f"a time is at least 0 s, not {said(limit)}")
    return AwaitInputs(*_parted("wait", values[:-1]), limit)


def told(values: Values) -> str:
    """Return values as one line for people."""
    return " ".join(said(value) for value in values)


def _say(word: str, values: Values, setting: RunSetting) -> Act:
    return Say(told(values))


def _hold(word: str, values: Values, setting: RunSetting) -> Act:
    return Hold(told(values))


def _remember(word: str, values: Values, setting: RunSetting) -> Act:
    found = place(values[0])
    return Remember(setting.about, found.joints_deg or {}, found.opening_mm)


_ACTS: Mapping[str, Callable[[str, Values, RunSetting], Act]] = MappingProxyType({
    "move": _move, "move_line": _move, "move_with": _move_with, "move_line_with": _move_with,
    "approach": _approach, "approach_line": _approach, "depart": _approach,
    "depart_line": _approach, "draw": _draw, "ready": _ready, "home": _home,
    "open_now": _open_now, "close_now": _close_now, "grasp": _grasp, "delay": _delay,
    "signal": _signal, "wait": _wait, "wait within": _wait_within, "type": _say, "hold": _hold,
    "remember": _remember,
})  # fmt: skip
