"""The [guards] of an arm file: numbers, keep-out boxes, thickness of the links, sums of joints.

Angles are in degrees in the file and in rad in the guards.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from armdrive.errors import ArmFileError
from armdrive.text.toml import (
    Rule,
    TomlTable,
    between,
    joint_range,
    named,
    number,
    number_by,
    require_list,
    text,
)
from kinematics.errors import KinematicsError
from kinematics.geometry import ArmGeometry
from kinematics.guards.guards import AngleSum, Guards
from kinematics.guards.links import link_names
from kinematics.guards.shapes import Box

NUMBERS: Mapping[str, Rule] = MappingProxyType(
    {
        key: Rule(low, high, help=means)
        for key, low, high, means in (
            ("tolerance_mm", 0.0, 50.0, "how far below the table rounding may put the tip"),
            ("inner_radius_mm", 0.0, 5000.0, "the tip keeps this far from the base axis ..."),
            ("inner_height_mm", -5000.0, 5000.0, "... while it is lower than this"),
            ("outer_radius_mm", 0.0, 5000.0, "the tip goes no further out"),
            (
                "hand_wrist_radius_mm", 0.0, 5000.0,
                "a hand pointing backwards keeps its wrist this far away ...",
            ),
            ("hand_tip_radius_mm", 0.0, 5000.0, "... while its tip is nearer than this"),
            ("hand_height_mm", -5000.0, 5000.0, "... and lower than this"),
            (
                "base_radius_mm", 0.0, 5000.0,
                "the links keep out of a column this thick ...",
            ),
            ("base_top_mm", -5000.0, 5000.0, "... up to this height"),
        )
    }
)  # fmt: skip
"""The keys that are a number."""

RADIUS = between(0.0, 1000.0)

FOREARM = "forearm_elevation_deg"
"""Short for the sum that cable arms need: the forearm's angle above the horizontal."""

FOREARM_NAME = "forearm elevation"
FOREARM_SHARES = (("shoulder", 1.0), ("elbow", 1.0))


def guards_of(table: TomlTable, arm: ArmGeometry, known: Guards) -> Guards:
    """Return the known guards of an arm with the file's corrections."""
    before = table.problems.count
    table.allow([*NUMBERS, "radii_mm", FOREARM, "boxes", "sums"])
    changed: dict[str, Any] = {
        key: table.value(key, number_by(row), getattr(known, key)) for key, row in NUMBERS.items()
    }
    changed["radii_mm"] = table.value("radii_mm", _radii, known.radii_mm)
    if "boxes" in table.entries:
        boxes = [_box(row) for row in table.rows("boxes")]
        changed["boxes"] = tuple(box for box in boxes if box is not None)
        _require_different(table, "keep-out boxes", [box.name for box in changed["boxes"]])
    if "sums" in table.entries or FOREARM in table.entries:
        changed["sums"] = tuple(_sums(table, arm.joint_names))
        _require_different(table, "sums of joints", [one.name for one in changed["sums"]])
    if table.problems.count > before:
        return known
    found = replace(known, **changed)
    return table.problems.attempt(lambda: _fitting(found, arm), known)


def guard_table(
    guards: Guards, degrees: Callable[[float], float] = math.degrees
) -> dict[str, object]:
    """Return the keys and values of these guards as a file states them."""
    known: dict[str, object] = {key: getattr(guards, key) for key in NUMBERS}
    table = {key: value for key, value in known.items() if value is not None}
    if guards.radii_mm:
        table["radii_mm"] = list(guards.radii_mm)
    if guards.boxes:
        table["boxes"] = [
            {"name": box.name, "min_mm": list(box.min_mm), "max_mm": list(box.max_mm)}
            for box in guards.boxes
        ]
    if guards.sums:
        table["sums"] = [
            {
                "name": one.name,
                "joints": dict(one.shares),
                "range_deg": [degrees(one.low_rad), degrees(one.high_rad)],
            }
            for one in guards.sums
        ]
    return table


def _require_different(table: TomlTable, what: str, names: list[str]) -> None:
    if len(set(names)) != len(names):
        table.problems.note(f"{what} need different names, not {', '.join(names)}")


def _fitting(guards: Guards, arm: ArmGeometry) -> Guards:
    """Return the guards. Raises if the links' thickness is missing or does not fit the arm."""
    names = link_names(arm)
    if not guards.radii_mm and (guards.boxes or guards.base_radius_mm is not None):
        example = ", ".join("30" for _ in names)
        raise ArmFileError(
            "boxes and base_radius_mm need to know how thick the links are: under [guards] give "
            f"radii_mm = [{example}] for {', '.join(names)}; 0 for a line of no thickness"
        )
    try:
        guards.over(arm)
    except KinematicsError as error:
        raise ArmFileError(f"guards.radii_mm: {error}") from None
    return guards


def _radii(value: object, where: str) -> tuple[float, ...]:
    return tuple(RADIUS(one, where) for one in require_list(value, where, "[35, 30, 25]"))


def _corner(value: object, where: str) -> tuple[float, float, float]:
    listed = require_list(value, where, "[150, -60, 0]")
    if len(listed) != len("xyz"):
        raise ArmFileError(f"{where} must be x, y and z in mm, not {value!r}")
    x, y, z = (number(one, where) for one in listed)
    return x, y, z


def _box(row: TomlTable) -> Box | None:
    row.allow(["name", "min_mm", "max_mm"])
    name = row.required("name", named)
    low, high = (row.required(key, _corner) for key in ("min_mm", "max_mm"))
    if name is None or low is None or high is None:
        return None
    try:
        return Box(name, low, high)
    except KinematicsError as error:
        row.problems.note(f"{row.where}: {error}")
    return None


def _sums(table: TomlTable, joints: tuple[str, ...]) -> Iterator[AngleSum]:
    bounds = table.value(FOREARM, joint_range, None)
    if bounds is not None:
        if any(joint not in joints for joint, _ in FOREARM_SHARES):
            table.problems.note(
                f"guards.{FOREARM} is for arms with a shoulder and an elbow; this one's joints "
                f"are {', '.join(joints)}: write [[guards.sums]] with joints = {{ {joints[1]} = 1 "
                "} and range_deg = [low, high]"
            )
        yield AngleSum(FOREARM_NAME, FOREARM_SHARES, bounds.low_rad, bounds.high_rad)
    for row in table.rows("sums"):
        row.allow(["name", "joints", "range_deg"])
        shares = row.by_name("joints", joints, number)
        if not any(shares.values()):
            row.problems.note(
                f"{row.where} needs joints, for example joints = {{ {joints[1]} = 1 }}"
            )
        name = row.value("name", text, " + ".join(shares))
        if not name and shares:
            row.problems.note(f"{row.at('name')} must be text, not ''")
        bounds = row.required("range_deg", joint_range)
        if bounds is not None:
            yield AngleSum(name, tuple(shares.items()), bounds.low_rad, bounds.high_rad)
