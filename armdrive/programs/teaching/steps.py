"""The steps of a sequence: how a person types one, what the fingers do in it, and how to edit them.

A step that is typed is read back from what it prints: `to pick along a line at 30%`. Steps are
counted from 1, as people and `armdrive points show` count them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

from armdrive.errors import BadRequest, Refused
from armdrive.moves import GraspMove, GripperMove
from armdrive.programs.language.words import TEACH
from armdrive.storage.points import (
    GRIPPER_WORDS,
    LONGEST_WAIT_S,
    SLOWEST_STEP,
    Point,
    Step,
    StepList,
    check_name,
)
from armdrive.text.numbers import number, parse_speed
from kinematics.errors import finite

PATTERNS = ", ".join(f"`{row.pattern}`" for row in TEACH)
"""The forms of a step, for people."""

_SPEED = re.compile(r"(.*?)(?: at (\S+(?: %)?))?")
_LINE = re.compile(r"(\S+)( (?:along a )?line)?")
_WIDTH = re.compile(r"(\S+?)(?: ?mm)?")
_TIME = re.compile(r"(\S+?)(?: ?s)?")


def parse_step(text: str) -> Step:
    """Read a step. Raises `BadRequest` with what a step looks like."""
    head, _, rest = " ".join(text.split()).partition(" ")
    reader = _READERS.get(head)
    if head == "wait":
        raise BadRequest(f"write `delay {rest or '2'}` to wait for seconds, not {text!r}")
    if reader is None or not rest:
        raise BadRequest(f"{text!r} is not a step: a step is {PATTERNS}")
    return reader(rest)


def _to(rest: str) -> Step:
    words, speed = _at(rest)
    found = _LINE.fullmatch(words)
    if found is None:
        raise BadRequest(f"{rest!r} does not lead to a point: a step is {PATTERNS}")
    return Step(check_name(found[1]), "line" if found[2] else "joint", speed)


def _gripper(rest: str) -> Step:
    words, speed = _at(rest)
    if words in GRIPPER_WORDS:
        return Step(gripper=words, speed=speed)
    found = _WIDTH.fullmatch(words)
    if found is None:
        raise BadRequest(f"gripper is one of {', '.join(GRIPPER_WORDS)}, or mm, not {words!r}")
    return Step(gripper=_number(found[1], "an opening in mm"), speed=speed)


def _delay(rest: str) -> Step:
    found = _TIME.fullmatch(rest)
    return Step(wait_s=_number(found[1] if found else rest, "a time in seconds"))


def _at(rest: str) -> tuple[str, float]:
    """Split off the speed."""
    found = _SPEED.fullmatch(rest)
    if found is None or found[2] is None:
        return rest, 1.0
    return found[1], parse_speed(found[2])


def _number(word: str, what: str) -> float:
    try:
        return number(word)
    except BadRequest:
        raise BadRequest(f"{word!r} is not {what}: a step is {PATTERNS}") from None


_READERS: Mapping[str, Callable[[str], Step]] = MappingProxyType(
    dict(zip((row.name for row in TEACH), (_to, _gripper, _delay), strict=True))
)

# What a sequence does at a step.


def last_point(steps: Sequence[Step]) -> str:
    """Return the name of the point that a sequence is at after these steps; "" before the first."""
    return next((step.point for step in reversed(steps) if step.point), "")


def grip_after(step: Step, at: Point | None) -> str | float | None:
    """Return the word or the opening that a step gives the fingers, None if it is not known.

    `at` is the point that the sequence is at; the word `point` stands for its opening.
    """
    if step.gripper == "point":
        return None if at is None else at.opening_mm
    return step.gripper


def finger_move(step: Step, at: Point | None) -> GripperMove | GraspMove:
    """Return the move of a step of the fingers. Raises `Refused` for a point without an opening."""
    grip = grip_after(step, at)
    match grip:
        case "grasp":
            return GraspMove()
        case "open":
            return GripperMove(None, step.speed)
        case "close":
            return GripperMove(0.0, step.speed)
        case int() | float():
            return GripperMove(float(grip), step.speed)
    raise Refused("the point before this step states no opening of the fingers")


# Editing: insert, remove, move, re-time, reverse. All of it raises `BadRequest` with the number.


@dataclass(frozen=True, slots=True)
class Edited:
    """The result of an edit, with notes about steps it left out or clipped."""

    steps: StepList
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Timing:
    """A new speed or wait, or factors for the present ones."""

    speed: float | None = None
    wait_s: float | None = None
    factor: float = 1.0
    wait_factor: float = 1.0

    def __post_init__(self) -> None:
        for name in ("factor", "wait_factor"):
            if finite(name, getattr(self, name)) <= 0.0:
                raise BadRequest(f"{name} is above 0, not {getattr(self, name):g}")


def inserted(steps: StepList, at: int, new: Iterable[Step]) -> StepList:
    """Return the sequence with new steps, the first of which becomes number `at`."""
    _in_range("place", at, len(steps.steps) + 1)
    before, behind = steps.steps[: at - 1], steps.steps[at - 1 :]
    return replace(steps, steps=(*before, *new, *behind))


def removed(steps: StepList, first: int, last: int | None = None) -> StepList:
    """Return the sequence without the steps from `first` to `last`."""
    first, last = span(steps, first, last)
    return replace(steps, steps=(*steps.steps[: first - 1], *steps.steps[last:]))


def moved(steps: StepList, old: int, new: int) -> StepList:
    """Return the sequence with step `old` as step `new`; the others keep their order."""
    count = len(steps.steps)
    _in_range("step", old, count)
    _in_range("place", new, count)
    rest = list(steps.steps)
    rest.insert(new - 1, rest.pop(old - 1))
    return replace(steps, steps=tuple(rest))


def retimed(
    steps: StepList, timing: Timing, first: int | None = None, last: int | None = None
) -> Edited:
    """Return the sequence with other speeds and waits, in all steps or from `first` to `last`."""
    begin, end = (1, len(steps.steps)) if first is None else span(steps, first, last)
    notes: list[str] = []
    made = [
        _retimed(step, timing, number, notes) if begin <= number <= end else step
        for number, step in enumerate(steps.steps, 1)
    ]
    return Edited(replace(steps, steps=tuple(made)), tuple(notes))


def reverse(steps: StepList, points: Mapping[str, Point]) -> Edited:
    """Return the way back: from the last point to the first, by the same kinds of motion.

    A step of the fingers is replaced by the one before it. The opening before the first such step
    is unknown, so that step is left out. Delays stay where they were.
    """
    notes: list[str] = []
    goals = [step for step in steps.steps if step.point]
    made = [replace(goals[-1], how="joint")] if goals else []
    grips = _known_grips(steps, points)
    for index in range(len(steps.steps), 0, -1):
        step = steps.steps[index - 1]
        if step.point:
            before = last_point(steps.steps[: index - 1])
            made += [replace(step, point=before)] if before else []
        elif step.gripper is None:
            made.append(step)
        elif (was := grips[index - 1]) is not None:
            made.append(replace(step, gripper=was))
        else:
            notes.append(
                f"step {index} ({step}) is left out: "
                "the opening of the fingers before it is unknown"
            )
    return Edited(replace(steps, steps=tuple(made)), tuple(notes))


def span(steps: StepList, first: int, last: int | None) -> tuple[int, int]:
    """Return a valid range of steps. Raises `BadRequest`."""
    last = first if last is None else last
    _in_range("step", first, len(steps.steps))
    _in_range("step", last, len(steps.steps))
    if last < first:
        raise BadRequest(f"step {last} comes before step {first}")
    return first, last


def _in_range(what: str, number: int, most: int) -> None:
    if not 1 <= number <= most:
        there = f"from 1 to {most}" if most else "none: the sequence is empty"
        raise BadRequest(f"there is no {what} {number}: they are {there}")


def _retimed(step: Step, timing: Timing, number: int, notes: list[str]) -> Step:
    if step.wait_s is not None:
        wait_s = step.wait_s * timing.wait_factor if timing.wait_s is None else timing.wait_s
        return replace(step, wait_s=min(round(wait_s, 3), LONGEST_WAIT_S))
    asked = timing.speed if timing.speed is not None else round(step.speed * timing.factor, 4)
    speed = asked if timing.speed is not None else min(max(asked, SLOWEST_STEP), 1.0)
    if speed != asked:
        notes.append(f"step {number} goes at {speed:.0%}, not at {asked:.0%}")
    return replace(step, speed=speed)


def _known_grips(steps: StepList, points: Mapping[str, Point]) -> list[str | float | None]:
    """Return the grip before each step, None while it is unknown."""
    grip: str | float | None = None
    before: list[str | float | None] = []
    for index, step in enumerate(steps.steps):
        before.append(grip)
        if step.gripper is not None:
            grip = grip_after(step, points.get(last_point(steps.steps[:index])))
    return before
