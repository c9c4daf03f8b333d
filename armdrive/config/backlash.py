"""The backlash in an arm file, as whole motor steps: what a motor turns before the arm follows."""

from __future__ import annotations

import math
from collections.abc import Iterator

from armdrive.text.toml import TomlTable, between
from kinematics.transmission import Transmission

TURNING, SLIDING = "backlash_deg", "backlash_mm"
"""The keys, of an arm file or of one of its [[motors]]; the second of a gripper's motor."""

WIDTHS = {TURNING: between(0.0, 10.0), SLIDING: between(0.0, 5.0)}
"""More than that is a loose screw: no arithmetic mends it."""


def read_backlash(table: TomlTable, transmission: Transmission | None) -> tuple[int, ...]:
    """Return the steps of each motor, nothing where no motor has any."""
    if transmission is None:
        return ()
    given = _of_rows if "motors" in table.entries else _of_sections
    widths = [0] * len(transmission.motors)
    for motor, size in given(table, transmission):
        widths[motor] = math.floor(_steps_per_unit(transmission, motor) * size + 0.5)
    return tuple(widths) if any(widths) else ()


def backlash_keys(
    widths: tuple[int, ...], transmission: Transmission | None
) -> Iterator[tuple[str, str, float]]:
    """Give motor, key and value: what a file has to say so that its backlash is read as it is."""
    for index, width in enumerate(widths):
        if transmission is not None and width:
            name = transmission.motors[index].name
            size = width / _steps_per_unit(transmission, index)
            yield name, _key(transmission, index), round(size, 9)


def _key(transmission: Transmission, motor: int) -> str:
    return TURNING if motor < len(transmission.joint_names) else SLIDING


def _steps_per_unit(transmission: Transmission, motor: int) -> float:
    """Return the steps of a degree, or of a mm."""
    scale = math.pi / 180.0 if _key(transmission, motor) == TURNING else 1.0
    return abs(transmission.motors[motor].steps_per_unit) * scale


def _of_sections(table: TomlTable, transmission: Transmission) -> Iterator[tuple[int, float]]:
    names = [motor.name for motor in transmission.motors]
    count = len(transmission.joint_names)
    turning = table.by_name(TURNING, names[:count], WIDTHS[TURNING])
    yield from ((names.index(name), size) for name, size in turning.items())
    sliding = table.value(SLIDING, WIDTHS[SLIDING], None)
    if sliding is not None and not transmission.has_gripper:
        table.problems.note(f"{SLIDING} is of a gripper's motor, and this arm has none")
    elif sliding is not None:
        yield len(names) - 1, sliding


def _of_rows(table: TomlTable, transmission: Transmission) -> Iterator[tuple[int, float]]:
    names = [motor.name for motor in transmission.motors]
    for row in table.rows("motors"):
        for key in [key for key in WIDTHS if key in row.entries]:
            name = row.entries["name"]
            if name not in names:
                row.problems.note(
                    f"{row.at(key)}: gripper.kind says that no motor drives the gripper"
                )
            elif key != _key(transmission, names.index(name)):
                wanted = _key(transmission, names.index(name))
                row.problems.note(f"{row.at(key)}: the backlash of motor {name!r} is {wanted}")
            elif (size := row.value(key, WIDTHS[key], None)) is not None:
                yield names.index(name), size
