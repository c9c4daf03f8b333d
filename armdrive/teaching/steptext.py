"""A step of a sequence in words, as it is printed and as a person types it.

to pick                to pick along a line at 30%        (`line` alone will do)
gripper open           gripper 30 mm at 50%               open, close, grasp, point, or mm
wait 0.5 s
"""

from __future__ import annotations

import re

from armdrive.errors import BadRequest
from armdrive.points import GRIPPER_WORDS, Step, check_name

FORMS = "`to POINT [along a line] [at 30%]`, `gripper open|close|grasp|point|MM`, `wait SECONDS`"

_SPEED = re.compile(r"(.*?)(?: at (\S+?) ?%)?")
_LINE = re.compile(r"(\S+)( (?:along a )?line)?")
_WIDTH = re.compile(r"(\S+?)(?: ?mm)?")
_WAIT = re.compile(r"(\S+?)(?: ?s)?")


def parse_step(text: str) -> Step:
    """Read a step; raises `BadRequest` that says what a step looks like."""
    head, _, rest = " ".join(text.split()).partition(" ")
    reader = _READERS.get(head)
    if reader is None or not rest:
        raise BadRequest(f"{text!r} is no step: a step is {FORMS}")
    return reader(rest)


def _to(rest: str) -> Step:
    words, speed = _at(rest)
    found = _LINE.fullmatch(words)
    if found is None:
        raise BadRequest(f"{rest!r} is no way to a point: {FORMS}")
    return Step(check_name(found[1]), "line" if found[2] else "joint", speed)


def _gripper(rest: str) -> Step:
    words, speed = _at(rest)
    if words in GRIPPER_WORDS:
        return Step(gripper=words, speed=speed)
    found = _WIDTH.fullmatch(words)
    if found is None:
        raise BadRequest(f"gripper is one of {', '.join(GRIPPER_WORDS)}, or mm, not {words!r}")
    return Step(gripper=_number(found[1], "an opening in mm"), speed=speed)


def _wait(rest: str) -> Step:
    found = _WAIT.fullmatch(rest)
    return Step(wait_s=_number(found[1] if found else rest, "a time in seconds"))


def _at(rest: str) -> tuple[str, float]:
    """Split off the speed."""
    found = _SPEED.fullmatch(rest)
    if found is None or found[2] is None:
        return rest, 1.0
    return found[1], _number(found[2], "a speed in percent") / 100.0


def _number(word: str, what: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise BadRequest(f"{word!r} is not {what}: {FORMS}") from None


_READERS = {"to": _to, "gripper": _gripper, "wait": _wait}
