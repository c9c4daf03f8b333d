"""Moves and jogs as values.

A move says where the arm should go. `arm.run`, `arm.start` and `arm.preview` take any move, and
each has a JSON form. A move may depend on the current position (joints that it does not name, the
tool's frame) or on a point's name; resolving it gives an absolute move.

A held jog is not a move. It is a lease that expires unless it is renewed, so it cannot be queued,
saved or repeated. `speed` is a fraction of the limits; lengths are in mm, and names of angles end
in their unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TypedDict, get_args

from armdrive.errors import BadArgument, BadRequest
from armdrive.errors.arguments import made_of, several
from armdrive.errors.kinematic import checked_number
from kinematics.errors import finite, suggestion
from kinematics.paths.routes import PathPart
from kinematics.spaces import POSE_EXAMPLE, Coordinates, Joints, Pose


class Space(Enum):
    """The space of a jog: joints, or the tip's Cartesian axes."""

    JOINT = "joint"
    CARTESIAN = "cartesian"


CARTESIAN_AXES = ("x", "y", "z", "pitch", "roll")  # mm for the first three, rad for the last two
YAW_AXIS = "yaw"  # the sixth Cartesian axis, in rad, of an arm with six joints
GRIPPER_AXIS = "gripper"  # part of both spaces; mm of opening
REST_S = 0.8  # a shorter standstill counts as part of a motion
BASE_FRAME = "base"  # the default frame of goals and jogs


# The keywords of calls, typed so that a type checker finds misspelt names. The joints of a model
# file may have other names; those are given in a mapping.

# Amounts by name, `{"shoulder_deg": 40}`, for joints whose names are known only at run time.
Angles = Mapping[str, float]


class JointAngles(TypedDict, total=False):
    """Joint angles of the usual arms with five or six joints."""

    base_deg: float
    shoulder_deg: float
    elbow_deg: float
    forearm_roll_deg: float
    wrist_pitch_deg: float
    wrist_roll_deg: float


class JointJog(JointAngles, total=False):
    """The increment of each joint; with `duration_s=`, directions from -1 to 1."""

    gripper_mm: float
    base: float
    shoulder: float
    elbow: float
    forearm_roll: float
    wrist_pitch: float
    wrist_roll: float
    gripper: float


class TipJog(Coordinates, total=False):
    """The increment of each tip axis; with `duration_s=`, directions from -1 to 1."""

    gripper_mm: float
    x: float
    y: float
    z: float
    pitch: float
    roll: float
    yaw: float
    gripper: float


def by_name(amounts: Angles | None, named: Mapping[str, object]) -> dict[str, float]:
    """Return the amounts from a mapping and from keywords. Raises `BadRequest` for duplicates."""
    given = amounts or {}
    if twice := given.keys() & named.keys():
        raise BadRequest(f"{min(twice)} is given twice: in the mapping and as a keyword")
    return {word: finite(word, value) for word, value in {**given, **named}.items()}


def joint_goal(
    goal: Joints | Angles | None, named: Mapping[str, object]
) -> Joints | dict[str, float]:
    """Return the goal of a joint motion: a posture with the named joints replaced, or their angles.

    Raises `KinematicsError` for a joint that the posture does not have.
    """
    if isinstance(goal, Joints):
        return goal.replace(**{word: finite(word, value) for word, value in named.items()})
    return by_name(goal, named)


@dataclass(frozen=True, slots=True)
class Jog:
    """A jog of one or more axes at once.

    The amounts of an increment are distances, in degrees (as a person types them) or mm. The
    amounts of a held jog are directions from -1 to 1 that share the speed. `frame` is the frame of
    x, y and z: "base", "tool", which turns with the hand, or a frame of the arm file. Pitch, roll
    and yaw are the same in every frame.
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
        """Jog the finger tips, for example `Jog.cartesian(z=-1)` or `(frame="tool", z=1)`."""
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
                f"a joint jog has no frame: jog x, y or z to use the frame {self.frame!r}"
            )

    def __str__(self) -> str:
        """Format as a log has it: `shoulder +2`, or `z -1 in the tool frame`."""
        axes = ", ".join(f"{name} {amount:+g}" for name, amount in self.axes)
        return axes if self.frame == BASE_FRAME else f"{axes} in the {self.frame} frame"

    def amount(self, name: str) -> float:
        """Return the amount for an axis; 0 if the jog does not name it."""
        return math.fsum(amount for axis, amount in self.axes if axis == name)


@dataclass(frozen=True, slots=True)
class ContinuousJog:
    """A held jog, its speed and the time at which it expires.

    `bounded`: its operator began it while limits and guards would end it. It ends if they no longer
    would, because the position is lost.
    """

    jog: Jog
    speed: float
    until_s: float
    bounded: bool = True

    def __post_init__(self) -> None:
        for name, share in self.jog.axes:
            if not -1.0 <= share <= 1.0:
                raise BadRequest(f"a held jog needs directions from -1 to 1, not {name}={share}")


@dataclass(frozen=True, slots=True)
class IncrementalJog:
    """One increment of a jog, its speed and the latest time at which it may start.

    `bounded` is as in `ContinuousJog`, from the moment of the request: it may have to wait. `holds`
    counts the held jogs before it: a later one shows that its key is held.
    """

    jog: Jog
    speed: float
    until_s: float = math.inf
    bounded: bool = True
    holds: int = 0


# The axes of an increment, named as in `shoulder_deg=2` or `x_mm=5`.

LENGTHS = ("x", "y", "z", GRIPPER_AXIS)  # axes in mm; the others are in degrees
_OPTIONS = ("speed", "duration_s", "frame")  # other keywords that may be meant by a misspelt axis


def jog_axes(words: Angles, *, in_steps: bool) -> tuple[tuple[str, float], ...]:
    """Return the axes for keywords such as `shoulder_deg=2` or `x_mm=5`. Raises `BadRequest`.

    Keywords of increments (`in_steps`) end in a unit; those of directions have none.
    """
    return tuple((_axis(word, in_steps), value) for word, value in words.items())


def _axis(word: str, in_steps: bool) -> str:
    name, _, unit = word.rpartition("_")
    axis = name if unit == ("mm" if name in LENGTHS else "deg") else None
    if in_steps and axis is None:
        raise BadRequest(
            f"{word!r} names no increment: write for example shoulder_deg=2, x_mm=5 or "
            "gripper_mm=3, or give duration_s= with directions such as "
            f"shoulder=1{suggestion(word, _OPTIONS)}"
        )
    if not in_steps and axis is not None:
        raise BadRequest(
            f"{word!r} is an increment, and duration_s needs directions from -1 to 1: write "
            f"{axis}=1, or leave out duration_s"
        )
    return axis or word


# Moves.


# Moves with the hand; a goal in this frame is a change of the current pose.
#
# Its x points up from the back of the hand, y sideways, z forward.
TOOL_FRAME = "tool"


def speed_fraction(speed: float) -> float:
    """Check a speed: a fraction of the limits, above 0 and up to 1. Raises `BadRequest`."""
    fraction = checked_number("speed", speed)
    if not 0.0 < fraction <= 1.0:
        raise BadRequest(f"speed is a fraction of the limits, above 0 and up to 1, not {speed!r}")
    return fraction


_POSE = made_of(Pose, "a pose", POSE_EXAMPLE)
_FRAME = made_of(str, "the name of a frame", '"base" or "tool"')


def _check_way(move: PoseMove | LineMove | ArcMove | PathMove) -> None:
    """Check the frame and speed of a move of the tip."""
    _FRAME("frame", move.frame)
    speed_fraction(move.speed)


def in_order(joints: Joints, names: tuple[str, ...]) -> Joints:
    """Return a posture in the order of an arm's joints. Raises `BadRequest` for other joints."""
    if joints.names == names:
        return joints
    if set(joints.names) != set(names):
        raise BadRequest(
            f"a goal for this arm needs the joints {', '.join(names)}, not "
            f"{', '.join(joints.names) or 'nothing'}"
        )
    return Joints(tuple(joints[name] for name in names), names)


@dataclass(frozen=True, slots=True)
class JointMove:
    """Move to joint angles, with all joints turning in proportion.

    The goal has the angles of all joints, or a mapping with degrees for some of them:
    `JointMove({"shoulder_deg": 40, "elbow_deg": -60})` leaves the other joints as they are.
    """

    goal: Joints | Angles
    speed: float = 1.0

    def __post_init__(self) -> None:
        made_of((Joints, Mapping), "joint angles", '{"shoulder_deg": 40}')("goal", self.goal)
        if isinstance(self.goal, Mapping):
            if not self.goal:
                raise BadRequest("name at least one joint, for example shoulder_deg=40")
            angles = {word: checked_number(word, value) for word, value in self.goal.items()}
            object.__setattr__(self, "goal", angles)
        speed_fraction(self.speed)


@dataclass(frozen=True, slots=True)
class PoseMove:
    """Move to the nearest posture for a pose, or to a named point; joints turn in proportion."""

    goal: Pose | str
    speed: float = 1.0
    frame: str = BASE_FRAME

    def __post_init__(self) -> None:
        words = "a pose or the name of a point"
        made_of((Pose, str), words, POSE_EXAMPLE)("goal", self.goal)
        _check_way(self)


@dataclass(frozen=True, slots=True)
class LineMove:
    """Move straight in x, y, z, pitch and roll: to a pose, or to the pose of angles or a point.

    The line keeps the posture in which it starts. If joint angles or a point were given and the
    line ends in a different posture, the result's `note` says so.
    """

    goal: Pose | Joints | str
    speed: float = 1.0
    frame: str = BASE_FRAME

    def __post_init__(self) -> None:
        words = "a pose, joint angles or the name of a point"
        made_of((Pose, Joints, str), words, POSE_EXAMPLE)("goal", self.goal)
        _check_way(self)


@dataclass(frozen=True, slots=True)
class ArcMove:
    """Move along a circular arc through `via` to a pose; only x, y and z of `via` matter."""

    via: Pose
    goal: Pose
    speed: float = 1.0
    frame: str = BASE_FRAME

    def __post_init__(self) -> None:
        _POSE("via", self.via)
        _POSE("goal", self.goal)
        _check_way(self)


_A_PART = f"LinePart({POSE_EXAMPLE})"
# The rule for the parts of a path.
PARTS = several(
    made_of(get_args(PathPart), "a part of a path", _A_PART), "a list of parts", f"[{_A_PART}]"
)


@dataclass(frozen=True, slots=True)
class PathMove:
    """Move along several parts, checked as a whole, with blends between them."""

    parts: Sequence[PathPart]
    speed: float = 1.0
    frame: str = BASE_FRAME

    def __post_init__(self) -> None:
        object.__setattr__(self, "parts", PARTS("parts", self.parts))
        if not self.parts:
            raise BadRequest("a path needs at least one part, for example LinePart(pose)")
        _check_way(self)
        if self.frame == TOOL_FRAME:
            raise BadRequest(
                "the tool's frame moves with the arm: give the path in the base frame or in a "
                "frame of the arm file"
            )


@dataclass(frozen=True, slots=True)
class GripperMove:
    """Move the fingers to an opening in mm; None opens them all the way, 0 closes them."""

    opening_mm: float | None = None
    speed: float = 1.0

    def __post_init__(self) -> None:
        if self.opening_mm is not None:
            object.__setattr__(self, "opening_mm", checked_number("opening_mm", self.opening_mm))
        speed_fraction(self.speed)


@dataclass(frozen=True, slots=True)
class GraspMove:
    """Close the fingers on an object, and grip it with about `force_n`."""

    force_n: float = 8.9

    def __post_init__(self) -> None:
        object.__setattr__(self, "force_n", checked_number("force_n", self.force_n))


@dataclass(frozen=True, slots=True)
class ParkMove:
    """Move to `goal`, by default the park posture; if a guard is in the way, rise first."""

    speed: float = 1.0
    goal: Pose | None = None

    def __post_init__(self) -> None:
        if self.goal is not None:
            _POSE("goal", self.goal)
        speed_fraction(self.speed)


@dataclass(frozen=True, slots=True)
class JogMove:
    """One increment of a jog. If the limits shorten it, the result says so."""

    jog: Jog
    speed: float = 0.25

    def __post_init__(self) -> None:
        made_of(Jog, "a jog", "Jog.joint(shoulder=2)")("jog", self.jog)
        speed_fraction(self.speed)


# A move whose end is known before it starts.
Motion = JointMove | PoseMove | LineMove | ArcMove | PathMove | GripperMove | ParkMove

SingleMove = Motion | GraspMove | JogMove


@dataclass(frozen=True, slots=True)
class MoveSequence:
    """Several moves in order, checked as a whole before the first one starts.

    Only the last move may be a grasp, because its end depends on the object. No move may be a jog,
    because a jog may be shortened.
    """

    moves: Sequence[SingleMove]

    def __post_init__(self) -> None:
        object.__setattr__(self, "moves", _MOVES("moves", self.moves))
        flat = tuple(_flattened(self.moves))
        if not flat:
            raise BadRequest("a sequence needs at least one move")
        if any(isinstance(move, GraspMove) for move in flat[:-1]):
            raise BadRequest("a grasp must be the last move of a sequence: plan the rest after it")
        if any(isinstance(move, JogMove) for move in flat):
            raise BadRequest("a sequence cannot contain a jog, because a jog may be shortened")
        object.__setattr__(self, "moves", flat)


# A move that `arm.run`, `arm.start` and `arm.preview` accept.
Move = SingleMove | MoveSequence

_A_MOVE = f"LineMove({POSE_EXAMPLE})"
# The rule for one move.
ONE_MOVE = made_of(get_args(Move), "a move", _A_MOVE)
_MOVES = several(ONE_MOVE, "a list of moves", f"[{_A_MOVE}]")


def _flattened(moves: Iterable[Move]) -> Iterator[SingleMove]:
    for move in moves:
        if isinstance(move, MoveSequence):
            yield from move.moves
        else:
            yield move
