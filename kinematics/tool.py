"""A tool in the fingers: where its point is, seen from the finger tips.

Lengths in mm, along the axes of the hand's frame (`closed_form`): `along` the hand, away from
the wrist; `up` from the hand's back where the roll is zero; `side` completes a right-handed frame
of up, side, along: for a hand that points outwards it is to the right.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

from kinematics.errors import KinematicsError, finite

LONGEST_MM = 1000.0


@dataclass(frozen=True, slots=True)
class Tool:
    """The tool centre point, seen from the finger tips; no lengths are no tool.

    `radius_mm` is how thick it is, for the guards that look at links.
    """

    along_mm: float = 0.0
    up_mm: float = 0.0
    side_mm: float = 0.0
    radius_mm: float = 0.0

    def __post_init__(self) -> None:
        for each in fields(self):
            value = finite(f"tool.{each.name}", getattr(self, each.name))
            if abs(value) > LONGEST_MM:
                raise KinematicsError(
                    f"tool.{each.name} is within {LONGEST_MM:g} mm either way, not {value:g}"
                )
            object.__setattr__(self, each.name, value)
        if self.radius_mm < 0.0:
            raise KinematicsError(f"tool.radius_mm is 0 or more, not {self.radius_mm:g}")

    def __bool__(self) -> bool:
        return any((self.along_mm, self.up_mm, self.side_mm))
