"""The [guards] of an arm file: numbers, keep-out boxes, how thick the links are, sums of joints.

Angles are in degrees in the file and in rad in what is made of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from armdrive.errors import ArmFileError
from armdrive.text.toml import joint_range, number, refuse_unknown, require_table, within
from kinematics.errors import KinematicsError
from kinematics.geometry import ArmGeometry
from kinematics.guards.guards import AngleSum, Guards
from kinematics.guards.links import link_names
from kinematics.guards.shapes import Box

NUMBERS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "tolerance_mm": (0.0, 50.0),
        "inner_radius_mm": (0.0, 5000.0),
        "inner_height_mm": (-5000.0, 5000.0),
        "outer_radius_mm": (0.0, 5000.0),
        "hand_wrist_radius_mm": (0.0, 5000.0),
        "hand_tip_radius_mm": (0.0, 5000.0),
        "hand_height_mm": (-5000.0, 5000.0),
        "base_radius_mm": (0.0, 5000.0),
        "base_top_mm": (-5000.0, 5000.0),
    }
)
"""Keys that are a number, and between what."""

RADIUS_MM = (0.0, 1000.0)

FOREARM = "forearm_elevation_deg"
"""Short for the sum that cable arms need: the forearm's angle above the horizontal."""

FOREARM_NAME = "forearm elevation"
FOREARM_SHARES = (("shoulder", 1.0), ("elbow", 1.0))


def guards_of(table: object, arm: ArmGeometry, known: Guards) -> Guards:
    """Return the known guards of an arm with what the file says of them put in their place.

    Raises `ArmFileError` that names the key.
    """
    entries = require_table(table, "guards")
    refuse_unknown(entries, [*NUMBERS, "radii_mm", FOREARM, "boxes", "sums"], "guards")
    changed: dict[str, Any] = {key: _number(entries, key) for key in NUMBERS if key in entries}
    if "radii_mm" in entries:
        changed["radii_mm"] = _radii(entries["radii_mm"])
    if "boxes" in entries:
        changed["boxes"] = _boxes(entries["boxes"])
    if "sums" in entries or FOREARM in entries:
        changed["sums"] = _sums(entries, arm.joint_names)
    return _fitting(replace(known, **changed), arm)


def guard_table(
    guards: Guards, degrees: Callable[[float], float] = math.degrees
) -> dict[str, object]:
    """Return the keys that mean these guards, with values that TOML can write."""
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


def _number(entries: Mapping[str, Any], key: str) -> float:
    where = f"guards.{key}"
    value = number(entries[key], where)
    within(where, value, *NUMBERS[key])
    return value


def _fitting(guards: Guards, arm: ArmGeometry) -> Guards:
    """Return the guards, or say what of the links is missing or does not fit the arm."""
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


def _radii(value: object) -> tuple[float, ...]:
    where = "guards.radii_mm"
    radii = tuple(number(one, where) for one in _listed(value, where, "[35, 30, 25]"))
    for one in radii:
        within(where, one, *RADIUS_MM)
    return radii


def _boxes(rows: object) -> tuple[Box, ...]:
    boxes = tuple(
        _box(row, f"guards.boxes[{index}]")
        for index, row in enumerate(_listed(rows, "guards.boxes", "[[guards.boxes]]"), 1)
    )
    names = [box.name for box in boxes]
    if len(set(names)) != len(names):
        raise ArmFileError(f"keep-out boxes need different names, not {', '.join(names)}")
    return boxes


def _box(row: object, where: str) -> Box:
    entries = require_table(row, where)
    refuse_unknown(entries, ["name", "min_mm", "max_mm"], where)
    name = entries.get("name")
    if not isinstance(name, str) or not name:
        raise ArmFileError(f'{where} needs a name, for example name = "vice"')
    corners = (_corner(entries, key, where) for key in ("min_mm", "max_mm"))
    try:
        return Box(name, *corners)
    except KinematicsError as error:
        raise ArmFileError(f"{where}: {error}") from None


def _corner(entries: Mapping[str, Any], key: str, where: str) -> tuple[float, float, float]:
    value = _listed(entries.get(key), f"{where}.{key}", "[150, -60, 0]")
    if len(value) != len("xyz"):
        raise ArmFileError(f"{where}.{key} must be x, y and z in mm, not {value!r}")
    x, y, z = (number(one, f"{where}.{key}") for one in value)
    return x, y, z


def _sums(entries: Mapping[str, Any], joints: tuple[str, ...]) -> tuple[AngleSum, ...]:
    found = []
    if FOREARM in entries:
        missing = [joint for joint, _ in FOREARM_SHARES if joint not in joints]
        if missing:
            raise ArmFileError(
                f"guards.{FOREARM} is for arms with a shoulder and an elbow; this one's joints "
                f"are {', '.join(joints)}: write [[guards.sums]] with joints = {{ {joints[1]} = 1 "
                "} and range_deg = [low, high]"
            )
        bounds = joint_range(entries[FOREARM], f"guards.{FOREARM}")
        found.append(AngleSum(FOREARM_NAME, FOREARM_SHARES, bounds.low_rad, bounds.high_rad))
    rows = _listed(entries.get("sums", []), "guards.sums", "[[guards.sums]]")
    found += [_sum(row, f"guards.sums[{index}]", joints) for index, row in enumerate(rows, 1)]
    names = [one.name for one in found]
    if len(set(names)) != len(names):
        raise ArmFileError(f"sums of joints need different names, not {', '.join(names)}")
    return tuple(found)


def _sum(row: object, where: str, joints: tuple[str, ...]) -> AngleSum:
    entries = require_table(row, where)
    refuse_unknown(entries, ["name", "joints", "range_deg"], where)
    given = require_table(entries.get("joints", {}), f"{where}.joints")
    refuse_unknown(given, list(joints), f"{where}.joints")
    shares = tuple(
        (joint, number(share, f"{where}.joints.{joint}")) for joint, share in given.items()
    )
    if not any(share for _, share in shares):
        raise ArmFileError(f"{where} needs joints, for example joints = {{ {joints[1]} = 1 }}")
    name = entries.get("name", " + ".join(given))
    if not isinstance(name, str) or not name:
        raise ArmFileError(f"{where}.name must be text, not {name!r}")
    bounds = joint_range(entries.get("range_deg"), f"{where}.range_deg")
    return AngleSum(name, shares, bounds.low_rad, bounds.high_rad)


def _listed(value: object, where: str, example: str) -> list[Any]:
    if not isinstance(value, list):
        raise ArmFileError(f"{where} must be a list, written for example {example}, not {value!r}")
    return value
