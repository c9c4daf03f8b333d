"""Tables of an arm file that are read joint by joint or motor by motor: homing, accelerations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from armdrive.armsections import HomingSettings
from armdrive.errors import ArmFileError
from armdrive.sections import number, refuse_unknown, require_table, within
from kinematics import Joints

if TYPE_CHECKING:
    from kinematics import ArmModel


def read_accelerations(
    table: Mapping[str, Any], names: tuple[str, ...]
) -> tuple[float | None, ...]:
    """Return the accelerations that the file gives, None for a joint that it says nothing of."""
    where = "accelerations_deg_s2"
    entries = require_table(table.get(where, {}), where)
    refuse_unknown(entries, list(names), where)
    for name, value in entries.items():
        within(f"{where}.{name}", number(value, f"{where}.{name}"), 0.1, 1e6)
    given = (entries.get(name) for name in names)
    found = tuple(None if value is None else math.radians(value) for value in given)
    return found if entries else ()


def read_homing(table: object, model: ArmModel) -> HomingSettings:
    """Return the device's own homing: where every joint stands afterwards, and the order."""
    entries = require_table(table, "homing")
    refuse_unknown(entries, ["joints_deg", "opening_mm", "groups"], "homing")
    angles = require_table(entries.get("joints_deg", {}), "homing.joints_deg")
    names = list(model.arm.joint_names)
    refuse_unknown(angles, names, "homing.joints_deg")
    missing = [name for name in names if name not in angles]
    if missing:
        raise ArmFileError(
            f"homing.joints_deg is missing {', '.join(missing)}: where every joint stands once the "
            "device has homed"
        )
    turned = tuple(math.radians(number(angles[n], f"homing.joints_deg.{n}")) for n in names)
    opening_mm = number(entries.get("opening_mm", 0.0), "homing.opening_mm")
    return HomingSettings(Joints(turned, tuple(names)), opening_mm, _groups(entries, model))


def _groups(entries: Mapping[str, Any], model: ArmModel) -> tuple[tuple[int, ...], ...]:
    count = len(model.transmission.motors) if model.transmission is not None else 0
    groups = entries.get("groups", [])
    good = isinstance(groups, list) and all(
        isinstance(group, list)
        and group
        and all(type(motor) is int and 1 <= motor <= count for motor in group)
        for group in groups
    )
    if not good:
        raise ArmFileError(
            f"homing.groups lists motors by number, 1 to {count}, in the order in which they home, "
            "for example [[3], [2], [1, 4, 5]]"
        )
    return tuple(tuple(group) for group in groups)
