"""The steps of a sequence: how a person types one, and what the fingers do in it.

A step that is typed is read back from what it prints: `to pick along a line at 30%`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

from armdrive.errors import BadRequest, Refused
from armdrive.moves import GraspMove, GripperMove
from armdrive.programs.language.words import TEACH
from armdrive.storage.points import GRIPPER_WORDS, Point, Step, check_name
from armdrive.text.numbers import parse_speed

PATTERNS = ", ".join(f"`{row.pattern}`" for row in TEACH)
"""What a step looks like, for people."""

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
        return float(word)
    except ValueError:
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
    raise Refused("the point before this step says no opening of the fingers")
