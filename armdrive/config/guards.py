"""The [guards] of an arm file: numbers, keep-out boxes, thickness of the links, sums of joints.

Angles are in degrees in the file and in rad in the guards.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

from armdrive.errors import ArmFileError
from armdrive.text.toml import TomlTable, joint_range, number, setting, text
from kinematics.errors import KinematicsError
from kinematics.geometry import ArmGeometry
from kinematics.guards.guards import AngleSum, Guards, link_names
from kinematics.guards.shapes import Box


def _mm(means: str, low: float = 0.0) -> Any:
    """Declare a length; one that is left out is that of the arm's model."""
    return setting(None, means, low=low, high=5000.0)


@dataclass(frozen=True, slots=True)
class GuardSettings:
    """The keys of [guards] without its arrays; a key that is left out keeps the model's guard."""

    tolerance_mm: float | None = setting(
        None, "how far below the table rounding may put the tip", low=0.0, high=50.0
    )
    inner_radius_mm: float | None = _mm("the tip keeps this far from the base axis ...")
    inner_height_mm: float | None = _mm("... while it is lower than this", -5000.0)
    outer_radius_mm: float | None = _mm("the tip goes no further out")
    hand_wrist_radius_mm: float | None = _mm(
        "a hand pointing backwards keeps its wrist this far away ..."
    )
    hand_tip_radius_mm: float | None = _mm("... while its tip is nearer than this")
    hand_height_mm: float | None = _mm("... and lower than this", -5000.0)
    base_radius_mm: float | None = _mm("the links keep out of a column this thick ...")
    base_top_mm: float | None = _mm("... up to this height", -5000.0)
    radii_mm: tuple[float, ...] | None = setting(
        None, "how thick each link is, from the upper arm to the hand", low=0.0, high=1000.0
    )


ARRAYS = ("boxes", "sums")
"""The arrays of tables in [guards]."""

FOREARM = "forearm_elevation_deg"
"""Short for the sum that cable arms need: the forearm's angle above the horizontal."""

FOREARM_NAME = "forearm elevation"
FOREARM_SHARES = (("shoulder", 1.0), ("elbow", 1.0))


def guards_of(table: TomlTable, arm: ArmGeometry, known: Guards) -> Guards:
    """Return the known guards of an arm with the file's corrections."""
    before = table.problems.count
    given = table.section(GuardSettings, elsewhere=(FOREARM, *ARRAYS)) or GuardSettings()
    changed: dict[str, Any] = {
        each.name: value
        for each in fields(given)
        if (value := getattr(given, each.name)) is not None
    }
    if "boxes" in table.entries:
        boxes = [row.section(Box) for row in table.rows("boxes")]
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
    known = {each.name: getattr(guards, each.name) for each in fields(GuardSettings)}
    known["boxes"] = [asdict(box) for box in guards.boxes]
    known["sums"] = [
        {
            "name": one.name,
            "joints": dict(one.shares),
            "range_deg": [degrees(one.low_rad), degrees(one.high_rad)],
        }
        for one in guards.sums
    ]
    return {key: value for key, value in known.items() if value not in (None, (), [])}


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
