"""The values of a program: numbers, truth, texts and places; and how they are written down."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TypeAlias

from armdrive.programs.language.words import (
    COMPARABLE,
    NEGATIVE,
    PARTS,
    SPEED,
    Slot,
    ValueKind,
)
from armdrive.text.numbers import speed_refusal
from kinematics.spaces import POSE_FIELDS, Pose
from kinematics.text import plain

# Returns the pose of an arm for the angles of all joints (deg, by name).
ForwardKinematics: TypeAlias = Callable[[Mapping[str, float]], Pose]


class LineFailure(Exception):
    """Why a line cannot be carried out; the machine adds its place."""


@dataclass(frozen=True, slots=True)
class PlaceValue:
    """A place: joint angles (deg, by name), a pose, or both.

    If both are known, the arm goes to the joint angles, because they also settle the elbow.
    """

    pose: Pose | None = None
    joints_deg: Mapping[str, float] | None = None
    opening_mm: float | None = None

    @property
    def goal(self) -> Pose | Mapping[str, float]:
        """The goal of a move to this place."""
        found = self.pose if self.joints_deg is None else self.joints_deg
        if found is None:
            raise LineFailure("this place has neither a pose nor joint angles")
        return found

    def __str__(self) -> str:
        if self.pose is not None:
            return str(self.pose)
        return ", ".join(
            f"{name} {value_text(angle)}°" for name, angle in (self.joints_deg or {}).items()
        )


Value: TypeAlias = float | bool | str | PlaceValue


def pose_of(place: PlaceValue, fk: ForwardKinematics | None) -> Pose:
    """Return the pose of a place. Raises `LineFailure` if it cannot be computed."""
    if place.pose is not None:
        return place.pose
    if fk is None or place.joints_deg is None:
        raise LineFailure("a place in joint angles has no x, y and z without an arm")
    return fk(place.joints_deg)


# A number of this size is shown as 1e+15, since further digits would mean nothing.
LONGEST_SHOWN = 1e15


def value_text(value: Value) -> str:
    """Return a value as people read it; a number has three decimals at most."""
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, float):
        if abs(value) >= LONGEST_SHOWN:
            return f"{value:g}"
        return plain(value, 3)
    return str(value)


def number(value: object) -> float:
    """Return a number. Raises `LineFailure` for anything else, and for infinity."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise LineFailure(f"a number is needed, not {value}")
    if not math.isfinite(value):
        raise LineFailure("this number is too large")
    return float(value)


def kind_of(value: Value) -> ValueKind:
    """Return the kind of a value."""
    if isinstance(value, bool):
        return ValueKind.TRUTH
    if isinstance(value, PlaceValue):
        return ValueKind.PLACE
    return ValueKind.TEXT if isinstance(value, str) else ValueKind.NUMBER


def truth(value: object) -> bool:
    """Return on or off. Raises `LineFailure` for anything else."""
    if not isinstance(value, bool):
        raise LineFailure(f"on or off is needed, not {value}")
    return value


def place(value: object) -> PlaceValue:
    """Return a place. Raises `LineFailure` for anything else."""
    if not isinstance(value, PlaceValue):
        raise LineFailure(f"a place is needed, not {value}")
    return value


# The functions of a program. Angles are in deg.


def _tan(angle_deg: float) -> float:
    if angle_deg % 180.0 == 90.0:
        raise LineFailure("a right angle has no tangent")
    return math.tan(math.radians(angle_deg))


def _sqrt(value: float) -> float:
    if value < 0.0:
        raise LineFailure("a negative number has no square root")
    return math.sqrt(value)


def _mod(value: float, divisor: float) -> float:
    if divisor == 0.0:
        raise LineFailure("this divides by zero")
    return value % divisor


def _over(value: float, divisor: float) -> float:
    if divisor == 0.0:
        raise LineFailure("this divides by zero")
    return value / divisor


# The functions and operators of numbers alone.
NUMERIC: Mapping[str, Callable[..., float | bool]] = MappingProxyType({
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _over,
    NEGATIVE: operator.neg,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
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


def moved(found: Pose, x_mm: float, y_mm: float, z_mm: float) -> Pose:
    """Return a pose moved along the axes of the base, with the same pitch, roll and yaw."""
    return replace(found, x_mm=found.x_mm + x_mm, y_mm=found.y_mm + y_mm, z_mm=found.z_mm + z_mm)


def backed(found: Pose, distance_mm: float) -> Pose:
    """Return a pose moved back along the direction in which its hand points.

    The hand of an arm without a yaw lies in the vertical plane through the base axis and the tip.
    Beyond the axis no pose has that direction: then this raises `LineFailure`.
    """
    turned = found.yaw_rad
    heading = math.atan2(found.y_mm, found.x_mm) if turned is None else turned
    level = math.cos(found.pitch_rad) * distance_mm
    if turned is None and level > math.hypot(found.x_mm, found.y_mm) + 1e-6:
        raise LineFailure(f"{distance_mm:g} mm back from there lies behind the axis of the base")
    return moved(
        found,
        -level * math.cos(heading),
        -level * math.sin(heading),
        -math.sin(found.pitch_rad) * distance_mm,
    )


def _at(values: Sequence[Value], _: ForwardKinematics | None) -> PlaceValue:
    x, y, z, pitch, *rest = (number(value) for value in values)
    roll = rest[0] if rest else 0.0
    yaw = rest[1] if len(rest) > 1 else None
    return PlaceValue(Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=pitch, roll_deg=roll, yaw_deg=yaw))


def _shifted(values: Sequence[Value], fk: ForwardKinematics | None) -> PlaceValue:
    x, y, z = (number(value) for value in values[1:])
    return PlaceValue(moved(pose_of(place(values[0]), fk), x, y, z))


def _above(values: Sequence[Value], fk: ForwardKinematics | None) -> PlaceValue:
    return _shifted((values[0], 0.0, 0.0, values[1]), fk)


# The functions that return places.
PLACING: Mapping[str, Callable[[Sequence[Value], ForwardKinematics | None], PlaceValue]] = (
    MappingProxyType({"at": _at, "shifted": _shifted, "above": _above})
)


def computed(name: str, values: Sequence[Value], fk: ForwardKinematics | None) -> Value:
    """Return what a function or an operator makes of values. Raises `LineFailure`.

    The interpreter itself evaluates `and` and `or`, and what asks the arm.
    """
    if name in PLACING:
        return PLACING[name](values, fk)
    if name in PARTS:
        part = getattr(pose_of(place(values[0]), fk), POSE_FIELDS[name[1:]])
        if part is None:
            raise LineFailure("this arm has no yaw")
        return float(part)
    if name == "not":
        return not truth(values[0])
    if name in ("==", "!="):
        one, other = values
        if kind_of(one) is not kind_of(other) or kind_of(one) not in COMPARABLE:
            raise LineFailure(f"{value_text(one)} and {value_text(other)} cannot be compared")
        return (one == other) is (name == "==")
    result = NUMERIC[name](*map(number, values))
    return result if isinstance(result, bool) else number(result)


# Bounds. Constants are checked before a program runs, other numbers when they are computed.


def slot_of(slots: Sequence[Slot], index: int) -> Slot | None:
    """Return the slot of the value at an index, or None if there are too many values."""
    if index < len(slots):
        return slots[index]
    return slots[-1] if slots and slots[-1].many else None


def fewest(slots: Sequence[Slot]) -> int:
    """Return the least number of values."""
    return sum(not slot.optional for slot in slots)


def out_of_bounds(slot: Slot, value: float, *, percent: bool = False) -> str | None:
    """Return why a slot refuses a number, or None if it is within bounds.

    `percent` says that the number was written as a percentage.
    """
    shown = value_text(value)
    if slot is SPEED and not 0.0 < value <= 1.0:
        return speed_refusal(100.0 * value if percent else value, percent=percent)
    if slot.not_zero and value == 0.0:
        return f"the {slot.title} counts from 1, so 0 is not allowed"
    if slot.whole and value != int(value):
        bound = "a whole number"
    elif slot.least is not None and value < slot.least:
        bound = f"at least {value_text(slot.least)}"
    elif slot.most is not None and value > slot.most:
        bound = f"at most {value_text(slot.most)}"
    else:
        return None
    return f"the {slot.title} must be {bound}, not {shown}"
