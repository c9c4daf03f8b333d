"""The backlash in an arm file, as whole motor steps: what a motor turns before the arm follows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from armdrive.errors import ArmFileError
from armdrive.text.toml import number, refuse_unknown, require_table, within
from kinematics.transmission import Transmission

MOST_DEG = 10.0
MOST_MM = 5.0
"""More than that is a loose screw: no arithmetic mends it."""

TURNING, SLIDING = "backlash_deg", "backlash_mm"
"""The keys, of an arm file or of one of its [[motors]]; the second of a gripper's motor."""


def read_backlash(table: Mapping[str, Any], transmission: Transmission | None) -> tuple[int, ...]:
    """Return the steps of each motor, nothing where no motor has any. Raises `ArmFileError`."""
    if transmission is None:
        return ()
    names = [motor.name for motor in transmission.motors]
    count = len(transmission.joint_names)
    given = _of_rows(table["motors"]) if "motors" in table else _of_sections(table, names, count)
    widths = [0] * len(names)
    for name, (key, where, value) in given.items():
        if name not in names:
            raise ArmFileError(f"{where}: gripper.kind says that no motor drives the gripper")
        motor = names.index(name)
        wanted = TURNING if motor < count else SLIDING
        if key != wanted:
            raise ArmFileError(f"{where}: the backlash of motor {name!r} is {wanted}")
        scale = math.pi / 180.0 if key == TURNING else 1.0
        size = number(value, where)
        within(where, size, 0.0, MOST_DEG if key == TURNING else MOST_MM)
        widths[motor] = math.floor(
            abs(transmission.motors[motor].steps_per_unit) * scale * size + 0.5
        )
    return tuple(widths) if any(widths) else ()


def backlash_keys(widths: tuple[int, ...], transmission: Transmission) -> Iterator[Keyed]:
    """Give what a file has to say of each motor so that its backlash is read as it is."""
    for index, (width, motor) in enumerate(zip(widths, transmission.motors, strict=False)):
        turning = index < len(transmission.joint_names)
        per_unit = abs(motor.steps_per_unit) * (math.pi / 180.0 if turning else 1.0)
        if width:
            yield motor.name, TURNING if turning else SLIDING, round(width / per_unit, 9)


Keyed = tuple[str, str, float]
"""A motor, the key of its backlash, and the value."""

Given = dict[str, tuple[str, str, object]]
"""By motor: the key, where it stands, and its value."""


def _of_sections(table: Mapping[str, Any], names: list[str], count: int) -> Given:
    turning = require_table(table.get(TURNING, {}), TURNING)
    refuse_unknown(turning, names[:count], TURNING)
    given: Given = {name: (TURNING, f"{TURNING}.{name}", value) for name, value in turning.items()}
    if SLIDING in table:
        if len(names) == count:
            raise ArmFileError(f"{SLIDING} is of a gripper's motor, and this arm has none")
        given[names[-1]] = (SLIDING, SLIDING, table[SLIDING])
    return given


def _of_rows(rows: list[Mapping[str, Any]]) -> Given:
    return {
        row["name"]: (key, f"motors[{index}].{key}", row[key])
        for index, row in enumerate(rows, 1)
        for key in (TURNING, SLIDING)
        if key in row
    }
