"""Functions of any kind of number: one formula runs on floats, on counting numbers, on symbols.

Plain numbers go straight to `math`. Numbers of another kind have methods of the same names
(`sin()`, `cos()`, `sqrt()`, `y.atan2(x)`, and `x.atan2_of(y)` for when only x is of that kind) and
their own arithmetic. `number` and `numbers` check what a caller passes. `last_that` searches for a
plain number by halving. Angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from kinematics.errors import KinematicsError, finite, hand_angle
from kinematics.text import counted

# An angle this near to a whole number of quarter turns is one: cos(pi / 2) is not 6e-17.
#
# On an arm of a metre it is worth 1e-9 mm.
QUARTER_TOLERANCE_RAD = 1e-12

_QUARTERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


def is_own_kind(x: Any) -> bool:
    """Return whether a value is a number with functions of its own, such as a symbol."""
    return type(x) is not float and hasattr(x, "sin")


def number(name: str, value: Any) -> Any:
    """Return a plain number as a float, one of another kind as it is; raises `BadNumber`."""
    return value if is_own_kind(value) else finite(name, value)


def numbers(what: str, values: Any, names: Sequence[str]) -> tuple[Any, ...]:
    """Return the numbers of a list, one for each name.

    Raises `KinematicsError` if the count is wrong or the value is not a list, and `BadNumber` for
    an entry that is not a finite number.
    """
    given = as_list(values)
    if given is None or len(given) != len(names):
        got = repr(values) if given is None else str(len(given))
        raise KinematicsError(
            f"{what} needs {counted(len(names), 'number')} ({', '.join(names)}), not {got}"
        )
    found = []
    for name, value in zip(names, given, strict=True):
        plain = type(value) is float and value - value == 0.0  # the usual case, quickly
        found.append(value if plain else number(f"{name} of {what}", value))
    return tuple(found)


def goal_numbers(what: str, values: Any, names: Sequence[str]) -> tuple[Any, ...]:
    """Return the numbers of a goal as `numbers` does, its angles within two turns.

    Raises `BadNumber` for a larger angle (a name that ends in `_rad`): it is probably in degrees.
    """
    given = numbers(what, values, names)
    for name, value in zip(names, given, strict=True):
        if name.endswith("_rad") and not is_own_kind(value):
            hand_angle(f"{name} of {what}", value, f"math.radians({value:g})")
    return given


def as_list(values: Any) -> tuple[Any, ...] | None:
    """Return the entries of an iterable; None for text and for anything else."""
    if isinstance(values, str | bytes):
        return None
    try:
        return tuple(values)
    except TypeError:
        return None


def sin(x: Any) -> Any:
    """Return the sine of an angle."""
    return x.sin() if is_own_kind(x) else math.sin(x)


def cos(x: Any) -> Any:
    """Return the cosine of an angle."""
    return x.cos() if is_own_kind(x) else math.cos(x)


def sqrt(x: Any) -> Any:
    """Return the square root. Raises ValueError for a plain number below zero."""
    return x.sqrt() if is_own_kind(x) else math.sqrt(x)


def atan2(y: Any, x: Any) -> Any:
    """Return the angle, from -pi to pi, of the direction x along and y across."""
    if is_own_kind(y):
        return y.atan2(x)
    if is_own_kind(x):
        return x.atan2_of(y)
    return math.atan2(y, x)


def cos_sin(angle: Any) -> tuple[Any, Any]:
    """Return cosine and sine of an angle, exact at whole numbers of quarter turns.

    For link tables, where an angle this near to pi / 2 means 90 degrees.
    """
    if is_own_kind(angle):
        return angle.cos(), angle.sin()
    quarters = round(angle / (math.pi / 2))
    if abs(angle - quarters * (math.pi / 2)) <= QUARTER_TOLERANCE_RAD:
        return _QUARTERS[quarters % 4]
    return math.cos(angle), math.sin(angle)


# Halving an interval this often leaves the last digits of a double.
HALVINGS = 52


def last_that(
    holds: Callable[[float], bool], low: float, high: float, halvings: int = HALVINGS
) -> float:
    """Return the number furthest from `low` towards `high` for which something holds, by halving.

    It holds at `low`, and changes at most once on the way; `high` may be below.
    """
    if holds(high):
        return high
    for _ in range(halvings):
        middle = (low + high) / 2.0
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low
