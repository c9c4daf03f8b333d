"""What a caller asks of the arm, as values: moves, and the jogs that a person holds.

A move says where the arm is to go; `arm.run`, `arm.start` and `arm.preview` take any of them, and
each has a JSON form. It may be meant from where the arm stands (the joints that it does not name, a
point's name, the tool's frame): resolving it gives a move that means the same from anywhere.

A hold is no move. It is a lease that expires unless it is renewed, so it cannot be queued, written
down or repeated. `speed` is a fraction of the limits; lengths in mm, angles as the names say.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from types import NoneType
from typing import TypedDict, get_args

from armdrive.errors import BadArgument, BadRequest
from armdrive.errors.kinematic import checked_number
from kinematics.errors import finite, suggestion
from kinematics.paths.parts import ArcPart, JointPart, LinePart, PathPart, PosePart
from kinematics.spaces import Joints, Pose


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
        for name, amount in self.axes:
            checked_number(f"the jog of {name}", amount)
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


# The axes that an increment names, `shoulder_deg=2` or `x_mm=5`, and back.

LENGTHS = ("x", "y", "z", GRIPPER_AXIS)
"""Axes that are jogged in mm; the others are jogged in degrees."""

_OPTIONS = ("speed", "duration_s", "frame")
"""What a misspelt word may mean where axes are named."""


def jog_axes(words: Angles, *, in_steps: bool) -> tuple[tuple[str, float], ...]:
    """Return the axes that keywords such as `shoulder_deg=2` or `x_mm=5` name.

    Directions, which are not `in_steps`, have no unit. Raises `BadRequest`.
    """
    return tuple((_axis(word, in_steps), value) for word, value in words.items())


def _axis(word: str, in_steps: bool) -> str:
    if not in_steps:
        return word
    for unit in ("_deg", "_mm"):
        axis = word.removesuffix(unit)
        if axis != word and (unit == "_mm") == (axis in LENGTHS):
            return axis
    raise BadRequest(
        f"{word!r} names no increment: write for example shoulder_deg=2, x_mm=5 or gripper_mm=3, "
        f"or give duration_s= with directions such as shoulder=1{suggestion(word, _OPTIONS)}"
    )


# Moves.

A_POSE = "Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90)"

TOOL_FRAME = "tool"
"""The frame that goes with the hand: a goal in it is a change from where the hand is."""


def speed_fraction(speed: float) -> float:
    """Check a speed: a fraction of the limits, above 0 and up to 1. Raises `BadRequest`."""
    fraction = checked_number("speed", speed)
    if not 0.0 < fraction <= 1.0:
        raise BadRequest(f"speed is a fraction of the limits, above 0 and up to 1, not {speed!r}")
    return fraction


def _require(name: str, value: object, kinds: tuple[type, ...], words: str, example: str) -> None:
    if not isinstance(value, kinds):
        raise BadArgument(f"{name} must be {words}, not {value!r:.80}; for example {example}")


def _check_way(move: PoseMove | LineMove | ArcMove | PathMove) -> None:
    """Check what all moves of the tip have."""
    _require("frame", move.frame, (str,), "the name of a frame", '"base" or "tool"')
    speed_fraction(move.speed)


@dataclass(frozen=True, slots=True)
class JointMove:
    """Every joint turns in proportion, to angles: of all joints, or in degrees of those named.

    `JointMove({"shoulder_deg": 40, "elbow_deg": -60})` leaves the other joints as they are.
    """

    goal: Joints | Angles
    speed: float = 1.0

    def __post_init__(self) -> None:
        _require("goal", self.goal, (Joints, Mapping), "joint angles", '{"shoulder_deg": 40}')
        if isinstance(self.goal, Mapping):
            if not self.goal:
                raise BadRequest("name at least one joint, for example shoulder_deg=40")
            angles = {word: checked_number(word, value) for word, value in self.goal.items()}
            object.__setattr__(self, "goal", angles)
        speed_fraction(self.speed)


@dataclass(frozen=True, slots=True)
class PoseMove:
    """Every joint turns in proportion, to the nearest posture for a pose, or to a named point's."""

    goal: Pose | str
    speed: float = 1.0
    frame: str = BASE_FRAME

    def __post_init__(self) -> None:
        _require("goal", self.goal, (Pose, str), "a pose or the name of a point", A_POSE)
        _check_way(self)


@dataclass(frozen=True, slots=True)
class LineMove:
    """Straight to a pose in x, y, z, pitch and roll; or to that of joint angles, or of a point.

    Of joint angles and of a point, the result's `note` says so where the line, which keeps the
    posture that it begins in, ends in another one.
    """

    goal: Pose | Joints | str
    speed: float = 1.0
    frame: str = BASE_FRAME

    def __post_init__(self) -> None:
        kinds, words = (Pose, Joints, str), "a pose, joint angles or the name of a point"
        _require("goal", self.goal, kinds, words, A_POSE)
        _check_way(self)


@dataclass(frozen=True, slots=True)
class ArcMove:
    """Along the arc of a circle through `via`, of which only x, y and z count, to a pose."""

    via: Pose
    goal: Pose
    speed: float = 1.0
    frame: str = BASE_FRAME

    def __post_init__(self) -> None:
        _require("via", self.via, (Pose,), "a pose", A_POSE)
        _require("goal", self.goal, (Pose,), "a pose", A_POSE)
        _check_way(self)


@dataclass(frozen=True, slots=True)
class PathMove:
    """Through several parts as one, audited as a whole, with blends between them."""

    parts: tuple[PathPart, ...]
    speed: float = 1.0
    frame: str = BASE_FRAME

    def __post_init__(self) -> None:
        kinds = (JointPart, PosePart, LinePart, ArcPart)
        for index, part in enumerate(self.parts):
            _require(f"parts[{index}]", part, kinds, "a part of a path", f"LinePart({A_POSE})")
        if not self.parts:
            raise BadRequest("a path needs at least one part, for example LinePart(pose)")
        object.__setattr__(self, "parts", tuple(self.parts))
        _check_way(self)
        if self.frame == TOOL_FRAME:
            raise BadRequest(
                "the tool's frame goes along with the arm: give a path in the base or in a frame "
                "of the arm file"
            )


@dataclass(frozen=True, slots=True)
class GripperMove:
    """Bring the fingers to an opening in mm; None opens them all the way, 0 closes them."""

    opening_mm: float | None = None
    speed: float = 1.0

    def __post_init__(self) -> None:
        if self.opening_mm is not None:
            object.__setattr__(self, "opening_mm", checked_number("opening_mm", self.opening_mm))
        speed_fraction(self.speed)


@dataclass(frozen=True, slots=True)
class GraspMove:
    """Close the fingers on whatever is between them, and press with about `force_n`."""

    force_n: float = 8.9

    def __post_init__(self) -> None:
        object.__setattr__(self, "force_n", checked_number("force_n", self.force_n))


@dataclass(frozen=True, slots=True)
class ParkMove:
    """Go to `goal`, by default the park posture; where a guard bars the way, rise first."""

    speed: float = 1.0
    goal: Pose | None = None

    def __post_init__(self) -> None:
        _require("goal", self.goal, (Pose, NoneType), "a pose", A_POSE)
        speed_fraction(self.speed)


@dataclass(frozen=True, slots=True)
class JogMove:
    """One increment of a jog. It is clipped to the limits, and the result says so."""

    jog: Jog
    speed: float = 0.25

    def __post_init__(self) -> None:
        _require("jog", self.jog, (Jog,), "a jog", "Jog.joint(shoulder=2)")
        speed_fraction(self.speed)


Motion = JointMove | PoseMove | LineMove | ArcMove | PathMove | GripperMove | ParkMove
"""A move whose end is known before it begins."""

SingleMove = Motion | GraspMove | JogMove


@dataclass(frozen=True, slots=True)
class MoveSequence:
    """Moves one after another, audited as a whole before the first one begins.

    A grasp can only be the last of them, since nobody knows yet where the fingers will meet
    something; a jog is none of them, since it may be clipped.
    """

    moves: tuple[SingleMove, ...]

    def __post_init__(self) -> None:
        flat = tuple(_flattened(self.moves))
        if not flat:
            raise BadRequest("a sequence needs at least one move")
        for index, move in enumerate(flat):
            _require(f"moves[{index}]", move, get_args(SingleMove), "a move", f"LineMove({A_POSE})")
        if any(isinstance(move, GraspMove) for move in flat[:-1]):
            raise BadRequest("a grasp is the last move of a sequence: plan the rest behind it")
        if any(isinstance(move, JogMove) for move in flat):
            raise BadRequest("a jog is no part of a sequence, since it may be clipped")
        object.__setattr__(self, "moves", flat)


Move = SingleMove | MoveSequence
"""What `arm.run`, `arm.start` and `arm.preview` take."""


def _flattened(moves: Iterable[Move]) -> Iterator[SingleMove]:
    for move in moves:
        if isinstance(move, MoveSequence):
            yield from move.moves
        else:
            yield move
