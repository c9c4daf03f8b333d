"""Reading a file of points: TOML; what makes no sense is an error that names the key."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from armdrive.errors import ArmFileError, BadRequest, PointsFileError
from armdrive.points import Point, Step, StepList, Taught
from armdrive.sections import number, read_section, refuse_unknown, require_table
from armdrive.textfile import parse_toml
from kinematics import BadNumber, Joints

POINTS, SEQUENCES = "points", "sequences"
_TOP = (POINTS, SEQUENCES)
_POINT_KEYS = ("joints_deg", "gripper_mm", "taught", "note")
_LIST_KEYS = ("note", "steps")


def parse_points(text: str, names: tuple[str, ...]) -> Taught:
    """Read a file of points of an arm with these joints. Raises `PointsFileError`."""
    try:
        table = parse_toml(text, PointsFileError)
        refuse_unknown(table, list(_TOP), "")
        points = require_table(table.get(POINTS, {}), POINTS)
        sequences = require_table(table.get(SEQUENCES, {}), SEQUENCES)
        return Taught(
            {name: _point(row, f"{POINTS}.{name}", names) for name, row in points.items()},
            {name: _list(row, f"{SEQUENCES}.{name}") for name, row in sequences.items()},
        )
    except (ArmFileError, BadRequest, BadNumber) as error:
        raise PointsFileError(str(error)) from None


def _point(row: object, where: str, names: tuple[str, ...]) -> Point:
    entries = require_table(row, where)
    refuse_unknown(entries, list(_POINT_KEYS), where)
    at = f"{where}.joints_deg"
    angles = require_table(entries.get("joints_deg", {}), at)
    refuse_unknown(angles, list(names), at)
    missing = [name for name in names if name not in angles]
    if missing:
        raise ArmFileError(f"{at} is missing {', '.join(missing)}: a point says every joint")
    turned = tuple(math.radians(number(angles[name], f"{at}.{name}")) for name in names)
    opening = entries.get("gripper_mm")
    return Point(
        Joints(turned, names),
        None if opening is None else number(opening, f"{where}.gripper_mm"),
        _text(entries, "note", where),
        _moment(entries.get("taught"), f"{where}.taught"),
    )


def _list(row: object, where: str) -> StepList:
    entries = require_table(row, where)
    refuse_unknown(entries, list(_LIST_KEYS), where)
    steps = entries.get("steps", [])
    if not isinstance(steps, list):
        raise ArmFileError(f'{where}.steps is a list, for example [{{ point = "above" }}]')
    read = tuple(_step(each, f"{where}.steps[{index}]") for index, each in enumerate(steps, 1))
    return StepList(read, _text(entries, "note", where))


@dataclass(frozen=True, slots=True)
class _StepKeys:
    """The keys of a step but for `gripper`, which is text or a number."""

    point: str = ""
    how: str = "joint"
    speed: float = 1.0
    gripper: str = ""
    wait_s: float | None = None


def _step(row: object, where: str) -> Step:
    entries = dict(require_table(row, where))
    gripper = entries.get("gripper")
    if isinstance(gripper, int | float) and not isinstance(gripper, bool):
        gripper = number(entries.pop("gripper"), f"{where}.gripper")
    read = read_section(_StepKeys, entries, where)
    try:
        return Step(read.point, read.how, read.speed, gripper, read.wait_s)
    except BadRequest as error:
        raise ArmFileError(f"{where}: {error}") from None


def _text(entries: Mapping[str, Any], name: str, where: str) -> str:
    given = entries.get(name, "")
    if not isinstance(given, str):
        raise ArmFileError(f"{where}.{name} must be text, not {given!r}")
    return given


def _moment(given: object, where: str) -> datetime | None:
    if given is not None and not isinstance(given, datetime):
        raise ArmFileError(f"{where} is a date and a time, such as 2026-11-22T10:30:00")
    return given
