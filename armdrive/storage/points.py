"""Named points of an arm and sequences of steps to them, as values that are checked when created.

A point is a posture: the joint angles, which do not depend on a tool or a frame, and the gripper
opening. Units: rad, mm, s.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from types import MappingProxyType, NoneType
from typing import Any

from armdrive.errors import ArmFileError, BadRequest, PointsFileError
from armdrive.errors import arguments as rules
from armdrive.errors.kinematic import checked_number
from armdrive.status import joints_view
from armdrive.text.reading import parse_toml
from armdrive.text.toml import FORMAT_KEY, Problems, TomlTable, number, require_format, text
from kinematics.errors import BadNumber
from kinematics.spaces import Joints

NAME = r"[A-Za-z][A-Za-z0-9_-]{0,39}"
"""A valid name of a point or a sequence: one word, as in programs."""

WAYS = ("joint", "line")
"""The kinds of motion to a point."""

GRIPPER_WORDS = ("open", "close", "grasp", "point")
"""The gripper commands of a step, besides an opening in mm; `point` is the opening of the point."""

LONGEST_WAIT_S = 3600.0  # an hour; a longer one is probably a slip

SLOWEST_STEP = 0.01
"""The lowest speed that an edit or a conversion gives a step, as a share of the limits."""

SAME_OPENING_MM = 1.0
"""Fingers whose opening changes by less than this between two places need no step of their own."""

_JOINTS = rules.made_of(Joints, "joint angles", "arm.joints")
_DATE = rules.made_of((datetime, NoneType), "a date and a time", "datetime.now()")


@dataclass(frozen=True, slots=True)
class Point:
    """A saved posture. `opening_mm` is None if the gripper opening was unknown."""

    joints: Joints
    opening_mm: float | None = None
    note: str = ""
    taught: datetime | None = None

    def __post_init__(self) -> None:
        _JOINTS("joints", self.joints)
        rules.text("note", self.note)
        _DATE("taught", self.taught)
        if self.opening_mm is not None:
            object.__setattr__(self, "opening_mm", checked_number("opening_mm", self.opening_mm))


def point_view(point: Point) -> dict[str, Any]:
    """Return a point as plain data, as `--json` prints it."""
    return {
        "joints": joints_view(point.joints),
        "gripper_mm": point.opening_mm,
        "note": point.note,
        "taught": None if point.taught is None else point.taught.isoformat(),
    }


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a sequence: exactly one of a move to a point, a gripper command, or a wait.

    `gripper` is one of `GRIPPER_WORDS` or an opening in mm, `how` is one of `WAYS`, and `speed` a
    fraction of the limits. Raises `BadRequest`.
    """

    point: str = ""
    how: str = "joint"
    speed: float = 1.0
    gripper: str | float | None = None
    wait_s: float | None = None

    def __post_init__(self) -> None:
        rules.text("point", self.point)
        given = [bool(self.point), self.gripper is not None, self.wait_s is not None]
        if sum(given) != 1:
            raise BadRequest("a step has exactly one of point, gripper and wait_s")
        if not self.point and self.how != WAYS[0]:
            raise BadRequest("how belongs to a step that leads to a point")
        if self.how not in WAYS:
            raise BadRequest(f"how is one of {', '.join(WAYS)}, not {self.how!r}")
        if not 0.0 < checked_number("speed", self.speed) <= 1.0:
            raise BadRequest(f"speed is above 0 and up to 1, not {self.speed:g}")
        if isinstance(self.gripper, str):
            if self.gripper not in GRIPPER_WORDS:
                raise BadRequest(
                    f"gripper is one of {', '.join(GRIPPER_WORDS)}, or mm, not {self.gripper!r}"
                )
        elif self.gripper is not None:
            checked_number("gripper", self.gripper)
        if (
            self.wait_s is not None
            and not 0.0 <= checked_number("wait_s", self.wait_s) <= LONGEST_WAIT_S
        ):
            raise BadRequest(f"wait_s is from 0 to {LONGEST_WAIT_S:g} s, not {self.wait_s:g}")

    def __str__(self) -> str:
        slowly = f" at {self.speed:.0%}" if self.speed < 1.0 else ""
        if self.point:
            return f"to {self.point}{' along a line' * (self.how == 'line')}{slowly}"
        if self.gripper is not None:
            what = self.gripper if isinstance(self.gripper, str) else f"{self.gripper:g} mm"
            return f"gripper {what}{slowly}"
        return f"delay {self.wait_s:g} s"


_A_STEP = 'Step("pick")'
_STEPS = rules.several(rules.made_of(Step, "a step", _A_STEP), "a list of steps", f"[{_A_STEP}]")


@dataclass(frozen=True, slots=True)
class StepList:
    """A named list of steps."""

    steps: tuple[Step, ...] = ()
    note: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", _STEPS("steps", self.steps))
        rules.text("note", self.note)

    @property
    def points(self) -> tuple[str, ...]:
        """The points that the sequence goes to, in order."""
        return tuple(step.point for step in self.steps if step.point)


@dataclass(frozen=True, slots=True)
class Taught:
    """The contents of a file of points. Raises `BadRequest` for a step to an unknown point."""

    points: Mapping[str, Point] = field(default_factory=dict)
    sequences: Mapping[str, StepList] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in (*self.points, *self.sequences):
            check_name(name)
        for name, each in self.sequences.items():
            for place, step in enumerate(each.steps, 1):
                if step.point and step.point not in self.points:
                    known = ", ".join(self.points) or "none"
                    raise BadRequest(
                        f"step {place} of sequence {name!r} goes to the point {step.point!r}, "
                        f"which does not exist; known are {known}"
                    )
        object.__setattr__(self, "points", MappingProxyType(dict(self.points)))
        object.__setattr__(self, "sequences", MappingProxyType(dict(self.sequences)))

    def users(self, point: str) -> tuple[str, ...]:
        """Return the names of the sequences that use a point."""
        return tuple(name for name, each in self.sequences.items() if point in each.points)


def check_name(name: str) -> str:
    """Return the name of a point or a sequence; raises `BadRequest` if it is not valid."""
    if not re.fullmatch(NAME, name):
        raise BadRequest(
            f"{name!r} is not a valid name: use one word of at most 40 letters, digits, - and _ "
            "that begins with a letter"
        )
    return name


# Reads a file of points, which is TOML. An error names the key that is wrong.

POINTS, SEQUENCES = "points", "sequences"
POINT_KEYS = ("joints_deg", "gripper_mm", "taught", "note")
LIST_KEYS = ("note", "steps")


def parse_points(document: str, names: tuple[str, ...]) -> Taught:
    """Parse the points of an arm with these joints. Raises `PointsFileError`."""
    try:
        table = TomlTable(parse_toml(document, PointsFileError), "", Problems())
        require_format(table.entries)
        table.allow([FORMAT_KEY, POINTS, SEQUENCES])
        points, sequences = table.table(POINTS), table.table(SEQUENCES)
        found = {name: _point(points.table(name), names) for name in points.entries}
        lists = {name: _list(sequences.table(name)) for name in sequences.entries}
        table.problems.require_none()
        return Taught({name: each for name, each in found.items() if each is not None}, lists)
    except (ArmFileError, BadRequest, BadNumber) as error:
        raise PointsFileError(str(error)) from None


def _point(table: TomlTable, names: tuple[str, ...]) -> Point | None:
    table.allow(POINT_KEYS)
    angles = table.by_name("joints_deg", names, number, all_since=": a point states every joint")
    if len(angles) < len(names):
        return None
    return Point(
        Joints(tuple(math.radians(angles[name]) for name in names), names),
        table.value("gripper_mm", number, None),
        table.value("note", text, ""),
        table.value("taught", _moment, None),
    )


def _list(table: TomlTable) -> StepList:
    table.allow(LIST_KEYS)
    steps = [row.section(Step) for row in table.rows("steps", '[{ point = "above" }]')]
    return StepList(tuple(step for step in steps if step), table.value("note", text, ""))


def _moment(given: object, where: str) -> datetime:
    if not isinstance(given, datetime):
        raise ArmFileError(f"{where} is a date and a time, such as 2026-11-22T10:30:00")
    return given
