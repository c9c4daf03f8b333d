"""What the mathematics refuses, and why: every error names the quantity and what to do.

KinematicsError            root of the room
+-- BadNumber              not a finite number where one belongs
+-- JointLimit             a joint angle outside its range
+-- Unreachable            a pose no posture can reach (see nearest.py)
+-- PathBroken             a straight line leaves the reach, or changes posture, on its way
"""

from __future__ import annotations


class KinematicsError(ValueError):
    """Root of everything this room refuses."""


class BadNumber(KinematicsError):
    """A value that is not a finite number; `name` says which one."""

    def __init__(self, name: str, value: object) -> None:
        self.name = name
        self.value = value
        super().__init__(f"{name} must be a finite number, not {value!r}")


def finite(name: str, value: object) -> float:
    """Return `value` as a float, or raise `BadNumber` that names it.

    Text, None, booleans, NaN and infinities are refused: none of them is a length or an angle.
    """
    if isinstance(value, bool | str | bytes):
        raise BadNumber(name, value)
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise BadNumber(name, value) from None
    if number - number != 0.0:  # NaN and both infinities differ from themselves
        raise BadNumber(name, value)
    return number
