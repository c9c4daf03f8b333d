"""A taught sequence in other forms: as a program, and as rows for an arm's own memory.

A program has the points at the top, then the steps; notes become comments. It does exactly what the
sequence does, to the last digit of every angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.errors import OutOfBounds, Refused
from armdrive.motion.plan import audit, limit_error
from armdrive.moves import GraspMove
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
from armdrive.programs.language.values import out_of_bounds
from armdrive.programs.language.words import RESERVED, WIDTH
from armdrive.programs.teaching.steps import finger_move
from armdrive.registry import pendant_of
from armdrive.registry.pendant import PendantProgram
from armdrive.storage.points import Point, Step, StepList
from firmware_protocol.errors import BadField
from kinematics.spaces import Joints, Pose

BLANK = Remark()
MOVES = {"joint": "move", "line": "move_line"}
LEAST_DECIMALS, MOST_DECIMALS = 4, 17
"""An angle is written with the fewest decimals of a degree that give exactly the same angle."""


def program_of(
    name: str, steps: StepList, points: Mapping[str, Point], fk: Callable[[Joints], Pose]
) -> Tree:
    """Return a sequence as a program. Raises `Refused` if it cannot be one."""
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
    """Return the names of points in a program, where names have no dash."""
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
        raise Refused(f"the joint {wrong!r} has a name that a program cannot use: rename it")
    yield from (Remark(line) for line in point.note.splitlines())
    pairs = zip(point.joints.names, point.joints, strict=True)
    angles = tuple((joint, Number(exact_deg(angle))) for joint, angle in pairs)
    tip = str(fk(point.joints))
    yield Assign(name, JointsOf(angles), True, note=tip if old == name else f"{old}: {tip}")


def exact_deg(angle_rad: float) -> float:
    """Return the shortest number of degrees that is exactly this angle."""
    deg = math.degrees(angle_rad)
    rounds = (round(deg, places) + 0.0 for places in range(LEAST_DECIMALS, MOST_DECIMALS + 1))
    return next((each for each in rounds if math.radians(each) == angle_rad), deg)


def _spoken(
    steps: tuple[Step, ...], points: Mapping[str, Point], names: Mapping[str, str]
) -> Iterator[tuple[Step, Do]]:
    """Yield each step as a line, after a line for the speed if that changes."""
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
    move = finger_move(step, at)
    if isinstance(move, GraspMove):
        return Do("grasp")
    if move.opening_mm is None:
        return Do("open_now")
    if move.opening_mm == 0.0:
        return Do("close_now")
    if why := out_of_bounds(WIDTH, move.opening_mm):
        raise Refused(f"in a program, {why}")
    return Do("open_now", (Number(move.opening_mm),))


def _grouped(lines: Iterable[tuple[Step, Do]]) -> Iterator[Statement]:
    """Put a blank line before each joint motion that leaves a place.

    The line for a new speed belongs to the same step, and so is not parted from its motion.
    """
    before: Step | None = None
    for step, line in lines:
        if before is None or (_is_way(step) and before is not step and not _is_way(before)):
            yield BLANK
        yield line
        before = step


def _is_way(step: Step) -> bool:
    return bool(step.point) and step.how == "joint"


# As rows for an arm's own memory, so that its pendant can run them alone.
#
# Rows are not audited when the pendant runs them, so every motion between rows is audited here.
# Steps that the memory cannot hold (lines, delays, grasps) are refused with their number.


def rows_of(
    config: ArmConfig,
    steps: StepList,
    points: Mapping[str, Point],
    origin: tuple[int, ...] | None,
) -> PendantProgram:
    """Return a sequence as rows. Raises `Refused` and `OutOfBounds`.

    Rows are absolute in the registers of an arm with this `origin`. The opening of the first row is
    that of its point.
    """
    if origin is None:
        raise Refused("the origin of the arm's registers is unknown: home it first")
    maker = _Maker(config, points, origin)
    for number, step in enumerate(steps.steps, 1):
        try:
            maker.take(step)
        except OutOfBounds as error:
            raise OutOfBounds(
                f"step {number} ({step}): {error}",
                name=error.name,
                value=error.value,
                bound=error.bound,
            ) from None
        except (Refused, BadField) as error:
            raise Refused(f"step {number} ({step}) cannot be a row: {error}") from None
    if not maker.rows:
        raise Refused("the sequence has no steps: there is nothing to make rows of")
    return PendantProgram(tuple(maker.rows), origin)


class _Maker:
    """Makes rows one after another, each from where the one before ends."""

    def __init__(
        self, config: ArmConfig, points: Mapping[str, Point], origin: tuple[int, ...]
    ) -> None:
        self.rows: list[Any] = []
        self._config = config
        self._pendant = pendant_of(config)
        self._points = points
        self._origin = origin
        self._point: Point | None = None
        self._opening_mm: float | None = None

    def take(self, step: Step) -> None:
        """Make the row of a step."""
        if step.wait_s is not None:
            raise Refused("a delay in the arm's memory is not known")
        if step.how != "joint":
            raise Refused("it has joint motions only")
        if step.point:
            self._go(self._points[step.point])
        else:
            self._opening_mm = self._opening(step)
        if self._point is None:
            raise Refused("a row is a posture of the whole arm: begin with a step to a point")
        if self._opening_mm is None:
            raise Refused("the opening of the fingers there is unknown: teach it again")
        transmission = self._config.model.transmission
        if transmission is None:
            raise Refused("the arm file gives no motors")
        there = transmission.to_motors(self._point.joints, self._opening_mm)
        registers = tuple(at - zero for at, zero in zip(there, self._origin, strict=True))
        number = len(self.rows) + 1
        self.rows.append(self._pendant.row(self._config, number, step.speed, registers))

    def _go(self, point: Point) -> None:
        if self._opening_mm is None:
            self._opening_mm = point.opening_mm
        beyond = self._config.model.arm.violations(point.joints)
        if beyond:
            raise limit_error(beyond[0])
        start = point if self._point is None else self._point
        audit(self._config, [start.joints, point.joints])
        self._point = point

    def _opening(self, step: Step) -> float:
        move = finger_move(step, self._point)
        if isinstance(move, GraspMove):
            raise Refused("its rows cannot grasp: give a width")
        closed_mm, open_mm = self._config.model.gripper_range_mm
        width_mm = {None: open_mm, 0.0: closed_mm}.get(move.opening_mm, move.opening_mm)
        if width_mm is None or not closed_mm <= width_mm <= open_mm:
            raise Refused(f"the fingers open from {closed_mm:g} to {open_mm:g} mm")
        return width_mm
