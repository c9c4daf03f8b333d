"""Named points of an arm, as values that are checked when created.

A point is a posture: the joint angles, which do not depend on a tool or a frame, and the gripper
opening. Units: rad, mm, s.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from datetime import datetime
from types import NoneType
from typing import Any

from armdrive.errors import ArmFileError, BadRequest, PointsFileError
from armdrive.errors import arguments as rules
from armdrive.errors.kinematic import checked_number
from armdrive.status import joints_view
from armdrive.text.reading import parse_toml
from armdrive.text.toml import FORMAT_KEY, Problems, TomlTable, number, require_format, text
from kinematics.errors import BadNumber
from kinematics.spaces import Joints

# A valid name of a point: one word.
NAME = r"[A-Za-z][A-Za-z0-9_-]{0,39}"

# Fingers whose opening changes by less than this between two places need no step of their own.
SAME_OPENING_MM = 1.0


def _is_storable(note: object) -> bool:
    """Return whether a file can hold a note: an argument that is not UTF-8 has lone surrogates."""
    return isinstance(note, str) and not any("\ud800" <= each <= "\udfff" for each in note)


_NOTE = rules.expected("text that a file can hold", "", _is_storable)
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
        _NOTE("note", self.note)
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


def check_name(name: str) -> str:
    """Return the name of a point; raises `BadRequest` if it is not valid."""
    if not re.fullmatch(NAME, name):
        raise BadRequest(
            f"{name!r} is not a valid name: use one word of at most 40 letters, digits, - and _ "
            "that begins with a letter"
        )
    return name


# Reads a file of points, which is TOML. An error names the key that is wrong.

POINTS = "points"
POINT_KEYS = ("joints_deg", "gripper_mm", "taught", "note")


def parse_points(document: str, names: tuple[str, ...]) -> dict[str, Point]:
    """Parse the points of an arm with these joints. Raises `PointsFileError`."""
    try:
        table = TomlTable(parse_toml(document, PointsFileError), "", Problems())
        require_format(table.entries)
        table.allow([FORMAT_KEY, POINTS])
        points = table.table(POINTS)
        read = {name: _point(points.table(name), names) for name in points.entries}
        found = table.problems.required(read)
        return {check_name(name): each for name, each in found.items() if each is not None}
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


def _moment(given: object, where: str) -> datetime:
    if not isinstance(given, datetime):
        raise ArmFileError(f"{where} is a date and a time, such as 2026-11-22T10:30:00")
    return given
