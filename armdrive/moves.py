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

REST_S = 0.8
"""An arm that stood for less was on its way."""

BASE_FRAME = "base"
"""The frame in which a jog is meant unless it names another."""


@dataclass(frozen=True, slots=True)
class Jog:
    """A jog of one or more axes at once.

    In an increment the amounts are distances: degrees for angles (this is an edge where a person
    types), mm for the rest. In a held jog they are directions from -1 to 1 that share the speed.
    `frame` says whose x, y and z are meant: "base", "tool", which turns with the hand, or a frame
    of the arm file. Pitch, roll and yaw are the same in all of them.
    """

    space: Space
    axes: tuple[tuple[str, float], ...]
    frame: str = BASE_FRAME

    @classmethod
    def joint(cls, **axes: float) -> Jog:
        """Jog joints, for example `Jog.joint(shoulder=1)`."""
        return cls(Space.JOINT, tuple(axes.items()))

    @classmethod
    def cartesian(cls, *, frame: str = BASE_FRAME, **axes: float) -> Jog:
        """Jog the finger tips, for example `Jog.cartesian(z=-1)`, or `z=1` of the tool's frame."""
        return cls(Space.CARTESIAN, tuple(axes.items()), frame)

    def __post_init__(self) -> None:
        if not self.axes:
            raise BadRequest("a jog needs at least one axis, for example shoulder or z")
        for name, amount in self.axes:
            finite(f"the jog of {name}", amount)
        if self.space is Space.JOINT and self.frame != BASE_FRAME:
            raise BadRequest(
                f"joints turn in no frame: a jog in the frame {self.frame!r} is Cartesian (x, y, z)"
            )

    def amount(self, name: str) -> float:
        """Return how much of this axis is asked for; 0 where it is not named."""
        return math.fsum(amount for axis, amount in self.axes if axis == name)


@dataclass(frozen=True, slots=True)
class ContinuousJog:
    """A jog that somebody holds, until when, and how fast."""

    jog: Jog
    speed: float
    until_s: float

    def __post_init__(self) -> None:
        for name, share in self.jog.axes:
            if not -1.0 <= share <= 1.0:
                raise BadRequest(f"a held jog goes in directions from -1 to 1, not {name}={share}")


@dataclass(frozen=True, slots=True)
class IncrementalJog:
    """One increment of a jog, how fast, and until when it may begin."""

    jog: Jog
    speed: float
    until_s: float = math.inf
