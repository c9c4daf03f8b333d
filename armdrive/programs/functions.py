"""What the functions of a program compute, angles in deg."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from armdrive.programs.values import (
    ForwardKinematics,
    Place,
    Trouble,
    Value,
    number,
    place,
    pose_of,
)
from armdrive.programs.vocabulary import FIELDS
from kinematics import Pose


def _tan(angle_deg: float) -> float:
    if angle_deg % 180.0 == 90.0:
        raise Trouble("there is no tangent of a right angle")
    return math.tan(math.radians(angle_deg))


def _sqrt(value: float) -> float:
    if value < 0.0:
        raise Trouble("there is no square root of a negative number")
    return math.sqrt(value)


def _mod(value: float, divisor: float) -> float:
    if divisor == 0.0:
        raise Trouble("this divides by zero")
    return value % divisor


def _over(value: float, divisor: float) -> float:
    if divisor == 0.0:
        raise Trouble("this divides by zero")
    return value / divisor


NUMERIC: Mapping[str, Callable[..., float]] = MappingProxyType({
    "abs": abs,
    "min": lambda *values: min(values),
    "max": lambda *values: max(values),
    "mod": _mod,
    "sqrt": _sqrt,
    "sin": lambda angle_deg: math.sin(math.radians(angle_deg)),
    "cos": lambda angle_deg: math.cos(math.radians(angle_deg)),
    "tan": _tan,
    "atan2": lambda y, x: math.degrees(math.atan2(y, x)),
    "floor": lambda value: float(math.floor(value)),
    "round": lambda value: float(math.floor(value + 0.5)),
})  # fmt: skip
"""The functions of numbers alone."""

SUMS: Mapping[str, Callable[[float, float], float | bool]] = MappingProxyType({
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": _over,
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
})  # fmt: skip
"""What stands between two numbers; what compares for equality takes any two values alike."""


def moved(found: Pose, x_mm: float, y_mm: float, z_mm: float) -> Pose:
    """Return a pose moved along the axes of the base; the hand keeps pitch, roll and yaw."""
    return replace(found, x_mm=found.x_mm + x_mm, y_mm=found.y_mm + y_mm, z_mm=found.z_mm + z_mm)


def backed(found: Pose, distance_mm: float) -> Pose:
    """Return a pose so far back along the direction in which its hand points.

    The hand of an arm without a yaw lies in the vertical plane through the base axis and the tip,
    so that there is no pose of that direction beyond the axis: `Trouble`.
    """
    turned = found.yaw_rad
    heading = math.atan2(found.y_mm, found.x_mm) if turned is None else turned
    level = math.cos(found.pitch_rad) * distance_mm
    if turned is None and level > math.hypot(found.x_mm, found.y_mm) + 1e-6:
        raise Trouble(f"{distance_mm:g} mm back from there lies behind the axis of the base")
    return moved(
        found,
        -level * math.cos(heading),
        -level * math.sin(heading),
        -math.sin(found.pitch_rad) * distance_mm,
    )


def _at(values: Sequence[Value], _: ForwardKinematics | None) -> Place:
    x, y, z, pitch, *rest = (number(value) for value in values)
    roll = rest[0] if rest else 0.0
    yaw = rest[1] if len(rest) > 1 else None
    return Place(Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=pitch, roll_deg=roll, yaw_deg=yaw))


def _shifted(values: Sequence[Value], fk: ForwardKinematics | None) -> Place:
    x, y, z = (number(value) for value in values[1:])
    return Place(moved(pose_of(place(values[0]), fk), x, y, z))


def _above(values: Sequence[Value], fk: ForwardKinematics | None) -> Place:
    return _shifted((values[0], 0.0, 0.0, values[1]), fk)


PLACING: Mapping[str, Callable[[Sequence[Value], ForwardKinematics | None], Place]] = (
    MappingProxyType({"at": _at, "shifted": _shifted, "above": _above})
)
"""The functions that give places."""


def part_of(found: Place, name: str, fk: ForwardKinematics | None) -> float:
    """Return a part of a place by its name of `FIELDS`: mm or deg."""
    value = getattr(pose_of(found, fk), FIELDS[name])
    if value is None:
        raise Trouble("this arm has no yaw")
    return float(value)
