"""Named points of an arm, and sequences over them: values, checked when they are made.

A point is a posture: joint angles, which stay what they are whatever tool or frame is meant, and
the opening of the fingers. Units: rad, mm, s.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from types import MappingProxyType
from typing import Any

from armdrive.errors import ArmFileError, BadRequest, PointsFileError
from armdrive.status import joints_view
from armdrive.text.reading import parse_toml
from armdrive.text.toml import FORMAT_KEY, Problems, TomlTable, number, require_format, text
from kinematics.errors import BadNumber, finite
from kinematics.spaces import Joints

NAME = r"[A-Za-z][A-Za-z0-9_-]{0,39}"
"""What points and sequences may be called: one word, as in programs."""

WAYS = ("joint", "line")
"""How a step leads to its point."""

GRIPPER_WORDS = ("open", "close", "grasp", "point")
"""What a step may have the fingers do besides an opening in mm: `point` is the point's opening."""

LONGEST_WAIT_S = 3600.0


@dataclass(frozen=True, slots=True)
class Point:
    """One posture worth coming back to. `opening_mm` is None where nobody knew the fingers."""

    joints: Joints
    opening_mm: float | None = None
    note: str = ""
    taught: datetime | None = None

    def __post_init__(self) -> None:
        if self.opening_mm is not None:
            object.__setattr__(self, "opening_mm", finite("gripper_mm", self.opening_mm))


def point_view(point: Point) -> dict[str, Any]:
    """Return a point as plain data: what `--json` prints."""
    return {
        "joints": joints_view(point.joints),
        "gripper_mm": point.opening_mm,
        "note": point.note,
        "taught": None if point.taught is None else point.taught.isoformat(),
    }


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a sequence: to a point, or the fingers, or a wait; exactly one of them.

    `gripper` is one of `GRIPPER_WORDS` or an opening in mm, `how` one of `WAYS`, `speed` a fraction
    of the limits. Raises `BadRequest`.
    """

    point: str = ""
    how: str = "joint"
    speed: float = 1.0
    gripper: str | float | None = None
    wait_s: float | None = None

    def __post_init__(self) -> None:
        said = [bool(self.point), self.gripper is not None, self.wait_s is not None]
        if sum(said) != 1:
            raise BadRequest("a step is one of point, gripper and wait_s, and no two of them")
        if not self.point and self.how != WAYS[0]:
            raise BadRequest("how belongs to a step that leads to a point")
        if self.how not in WAYS:
            raise BadRequest(f"how is one of {', '.join(WAYS)}, not {self.how!r}")
        if not 0.0 < finite("speed", self.speed) <= 1.0:
            raise BadRequest(f"speed is above 0 and up to 1, not {self.speed:g}")
        if isinstance(self.gripper, str):
            if self.gripper not in GRIPPER_WORDS:
                raise BadRequest(
                    f"gripper is one of {', '.join(GRIPPER_WORDS)}, or mm, not {self.gripper!r}"
                )
        elif self.gripper is not None:
            finite("gripper", self.gripper)
        if self.wait_s is not None and not 0.0 <= finite("wait_s", self.wait_s) <= LONGEST_WAIT_S:
            raise BadRequest(f"wait_s is from 0 to {LONGEST_WAIT_S:g} s, not {self.wait_s:g}")

    def __str__(self) -> str:
        slowly = f" at {self.speed:.0%}" if self.speed < 1.0 else ""
        if self.point:
            return f"to {self.point}{' along a line' * (self.how == 'line')}{slowly}"
        if self.gripper is not None:
            what = self.gripper if isinstance(self.gripper, str) else f"{self.gripper:g} mm"
            return f"gripper {what}{slowly}"
        return f"delay {self.wait_s:g} s"


@dataclass(frozen=True, slots=True)
class StepList:
    """A named list of steps."""

    steps: tuple[Step, ...] = ()
    note: str = ""

    @property
    def points(self) -> tuple[str, ...]:
        """The points that it goes to, in its order."""
        return tuple(step.point for step in self.steps if step.point)


@dataclass(frozen=True, slots=True)
class Taught:
    """All that a file of points holds. Raises `BadRequest` for a step to a point there is not."""

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
                        f"which there is not; known are {known}"
                    )
        object.__setattr__(self, "points", MappingProxyType(dict(self.points)))
        object.__setattr__(self, "sequences", MappingProxyType(dict(self.sequences)))

    def users(self, point: str) -> tuple[str, ...]:
        """Return the sequences that go to a point."""
        return tuple(name for name, each in self.sequences.items() if point in each.points)


def check_name(name: str) -> str:
    """Return a name that a point or a sequence may have; raises `BadRequest`."""
    if not re.fullmatch(NAME, name):
        raise BadRequest(
            f"{name!r} is no name: one word of letters, digits, - and _ that begins with a letter, "
            "of at most 40 characters"
        )
    return name


# Reading a file of points: TOML; what makes no sense is an error that names the key.

POINTS, SEQUENCES = "points", "sequences"
POINT_KEYS = ("joints_deg", "gripper_mm", "taught", "note")
LIST_KEYS = ("note", "steps")


def parse_points(document: str, names: tuple[str, ...]) -> Taught:
    """Read a file of points of an arm with these joints. Raises `PointsFileError`."""
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
    angles = table.by_name("joints_deg", names, number, all_since=": a point says every joint")
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
