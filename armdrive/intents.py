"""What somebody asks of the arm, as values: they are handed from any thread to the engine's."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from armdrive.errors import BadRequest
from kinematics.errors import finite


class Space(Enum):
    """The space in which a jog is meant."""

    JOINT = "joint"
    CARTESIAN = "cartesian"


CARTESIAN_AXES = ("x", "y", "z", "pitch", "roll")
"""Axes of a Cartesian jog: mm for the first three, rad for the last two."""

YAW_AXIS = "yaw"
"""One more of an arm of six joints, in rad."""

GRIPPER_AXIS = "gripper"
"""The gripper's axis in either space, in mm of opening."""


@dataclass(frozen=True, slots=True)
class Jog:
    """A jog of one or more axes at once.

    In an increment the amounts are distances: degrees for angles (this is an edge where a person
    types), mm for the rest. In a held jog they are directions from -1 to 1 that share the speed.
    """

    space: Space
    axes: tuple[tuple[str, float], ...]

    @classmethod
    def joint(cls, **axes: float) -> Jog:
        """Jog joints, for example `Jog.joint(shoulder=1)`."""
        return cls(Space.JOINT, tuple(axes.items()))

    @classmethod
    def cartesian(cls, **axes: float) -> Jog:
        """Jog the finger tips, for example `Jog.cartesian(z=-1)`."""
        return cls(Space.CARTESIAN, tuple(axes.items()))

    def __post_init__(self) -> None:
        if not self.axes:
            raise BadRequest("a jog needs at least one axis, for example shoulder or z")
        for name, amount in self.axes:
            finite(f"the jog of {name}", amount)

    def amount(self, name: str) -> float:
        """Return how much of this axis is asked for; 0 where it is not named."""
        return math.fsum(amount for axis, amount in self.axes if axis == name)
