"""What somebody asks of the arm, as values: they are handed from any thread to the engine's."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TypedDict

from armdrive.errors import BadArgument, BadRequest
from armdrive.errors.kinematic import refusal_of
from kinematics.errors import KinematicsError, finite


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


# What calls take as keywords, so that a type checker finds a name that is none. An arm of a model
# file may have joints of other names: those are given in a mapping.

Angles = Mapping[str, float]
"""Amounts by name, `{"shoulder_deg": 40}`: for joints that are named only as the program runs."""


class JointAngles(TypedDict, total=False):
    """Angles of the joints of the usual arms of five and six joints."""

    base_deg: float
    shoulder_deg: float
    elbow_deg: float
    forearm_roll_deg: float
    wrist_pitch_deg: float
    wrist_roll_deg: float


class JointJog(JointAngles, total=False):
    """What an increment turns those joints by; or with `duration_s=` directions from -1 to 1."""

    gripper_mm: float
    base: float
    shoulder: float
    elbow: float
    forearm_roll: float
    wrist_pitch: float
    wrist_roll: float
    gripper: float


class TipJog(TypedDict, total=False):
    """What an increment moves the tip by; or with `duration_s=` directions from -1 to 1."""

    x_mm: float
    y_mm: float
    z_mm: float
    pitch_deg: float
    roll_deg: float
    yaw_deg: float
    gripper_mm: float
    x: float
    y: float
    z: float
    pitch: float
    roll: float
    yaw: float
    gripper: float


def by_name(amounts: Angles | None, named: Mapping[str, object]) -> dict[str, float]:
    """Return the amounts of a mapping and of keywords together. Raises `BadRequest`."""
    given = amounts or {}
    if twice := given.keys() & named.keys():
        raise BadRequest(f"{min(twice)} is given twice: in the mapping and as a keyword")
    return {word: finite(word, value) for word, value in {**given, **named}.items()}


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
        if not isinstance(self.space, Space):
            raise BadArgument(f"space must be Space.JOINT or Space.CARTESIAN, not {self.space!r}")
        try:
            for name, amount in self.axes:
                finite(f"the jog of {name}", amount)
        except KinematicsError as error:
            raise refusal_of(error) from None
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
