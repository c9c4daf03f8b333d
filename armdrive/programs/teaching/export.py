"""A taught sequence as a program: points at the top, then the steps, the notes as comments.

What the program does is what the sequence does, act by act and to the last digit of every angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping

from armdrive.errors import Refused
from armdrive.programs.language.syntax import (
    NAME,
    Assign,
    Do,
    JointsOf,
    Name,
    Number,
    Remark,
    Statement,
    Tree,
)
from armdrive.programs.language.words import RESERVED
from armdrive.storage.points import Point, Step, StepList
from kinematics.spaces import Joints, Pose

BLANK = Remark()
MOVES = {"joint": "move", "line": "move_line"}
FINGERS = {"open": "open_now", "close": "close_now", "grasp": "grasp"}
LEAST_DECIMALS, MOST_DECIMALS = 4, 17
"""An angle is written with as few decimals of a degree as give the very same angle."""


def program_of(
    name: str, steps: StepList, points: Mapping[str, Point], fk: Callable[[Joints], Pose]
) -> Tree:
    """Return the program that a sequence is. Raises `Refused` where it cannot be one."""
    if not steps.steps:
        raise Refused(f"the sequence {name!r} has no steps: there is nothing to export")
    used = tuple(dict.fromkeys(steps.points))
    names = program_names(used)
    heading = [Remark(f"The sequence {name}, as it was taught.")]
    heading += [Remark(line) for line in steps.note.splitlines()]
    places = [each for old in used for each in _place(old, names[old], points[old], fk)]
    body = _grouped(_spoken(steps.steps, points, names))
    return Tree((*heading, BLANK, *places, *body))


def program_names(points: Iterable[str]) -> dict[str, str]:
    """Return what points are called in a program, whose names are words without a dash."""
    names: dict[str, str] = {}
    taken = set(RESERVED)
    for point in points:
        plain = point.replace("-", "_")
        tries = (plain, *(f"{plain}_{number}" for number in range(2, len(taken) + 3)))
        names[point] = next(each for each in tries if each.lower() not in taken)
        taken.add(names[point].lower())
    return names


def _place(old: str, name: str, point: Point, fk: Callable[[Joints], Pose]) -> Iterator[Statement]:
    """Yield a point's notes, and the line that gives it its name."""
    wrong = next((joint for joint in point.joints.names if not NAME.fullmatch(joint)), None)
    if wrong is not None:
        raise Refused(f"the joint {wrong!r} has a name that a program cannot say: rename it")
    yield from (Remark(line) for line in point.note.splitlines())
    pairs = zip(point.joints.names, point.joints, strict=True)
    angles = tuple((joint, Number(exact_deg(angle))) for joint, angle in pairs)
    tip = str(fk(point.joints))
    yield Assign(name, JointsOf(angles), True, note=tip if old == name else f"{old}: {tip}")


def exact_deg(angle_rad: float) -> float:
    """Return the shortest number of degrees that is this very angle."""
    deg = math.degrees(angle_rad)
    rounds = (round(deg, places) + 0.0 for places in range(LEAST_DECIMALS, MOST_DECIMALS + 1))
    return next((each for each in rounds if math.radians(each) == angle_rad), deg)


def _spoken(
    steps: tuple[Step, ...], points: Mapping[str, Point], names: Mapping[str, str]
) -> Iterator[tuple[Step, Do]]:
    """Yield each step as a line, with one for the speed before it where that changes."""
    speed, last = 1.0, ""
    for step in steps:
        last = step.point or last
        timed = step.wait_s is None and step.gripper != "grasp"
        if timed and step.speed != speed:
            speed = step.speed
            yield step, Do("speed", (Number(speed, percent=True),))
        if step.point:
            yield step, Do(MOVES[step.how], (Name(names[step.point]),))
        elif step.gripper is not None:
            yield step, _fingers(step, points.get(last))
        else:
            yield step, Do("delay", (Number(step.wait_s or 0.0),))


def _fingers(step: Step, at: Point | None) -> Do:
    if isinstance(step.gripper, str) and step.gripper in FINGERS:
        return Do(FINGERS[step.gripper])
    width = step.gripper
    if width == "point":
        width = None if at is None else at.opening_mm
        if width is None:
            raise Refused("the point before a step of the fingers says no opening of them")
    if not isinstance(width, int | float) or width < 0.0:
        raise Refused(f"a program opens the fingers from 0 mm on, not to {width} mm")
    return Do("open_now", (Number(float(width)),))


def _grouped(lines: Iterable[tuple[Step, Do]]) -> Iterator[Statement]:
    """Set what is done at a place apart from the next way that leads away by a joint motion."""
    before: Step | None = None
    for step, line in lines:
        leads_away = bool(step.point) and step.how == "joint"
        if before is None or (leads_away and before is not step and not _is_way(before)):
            yield BLANK
        yield line
        before = step


def _is_way(step: Step) -> bool:
    return bool(step.point) and step.how == "joint"
