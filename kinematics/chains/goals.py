"""Goals of a hand: a frame, and which parts of it matter.

The hand's direction (z of its frame) is split as a five-axis arm has it: its pitch in the
vertical plane that the hand should lie in, and its heading, by which it leaves that plane. The
roll is about the hand, from x pointing upwards in that plane. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from enum import Enum

from kinematics.chains.chain import Chain
from kinematics.errors import KinematicsError, require
from kinematics.frames.orientations import rotation_vector
from kinematics.frames.rotations import Matrix3, columns, from_columns, multiply, transpose
from kinematics.frames.transforms import (
    Transform,
    check_transform,
    homogeneous,
    position_of,
    rotation_of,
    z_axis_of,
)
from kinematics.frames.vectors import (
    X_AXIS,
    Z_AXIS,
    Vector,
    add,
    cross,
    dot,
    norm,
    reject,
    scale,
    subtract,
    unit,
)
from kinematics.geometry import AXIS_MM
from kinematics.spaces import POSE_EXAMPLE, Pose, refuse_yaw

# A horizontal part smaller than this gives no heading.
VERTICAL = 1e-9


class Part(Enum):
    """A part of a goal."""

    POSITION = "position"
    HEADING = "heading"
    PITCH = "pitch"
    ROLL = "roll"


ALL_PARTS = frozenset(Part)

# How the hand is turned.
HAND_PARTS = ALL_PARTS - {Part.POSITION}

# The parts of a goal that leaves the hand's rotation about the world's z axis free.
HEADING_FREE = ALL_PARTS - {Part.HEADING}


@dataclass(frozen=True, slots=True)
class Goal:
    """A frame for the hand, in the world, and the parts of it that are required.

    `outwards` is the horizontal direction of the vertical plane that the hand should lie in.
    Parts that are not in `parts` are free. Make one by `frame_goal` or `pose_goal`. Raises
    `KinematicsError` for a goal without parts.
    """

    frame: Transform
    outwards: Vector
    parts: frozenset[Part] = ALL_PARTS

    def __post_init__(self) -> None:
        if not self.parts:
            raise KinematicsError(
                f"a goal asks at least one of {', '.join(part.value for part in Part)}"
            )

    @property
    def pitch_rad(self) -> float:
        """The elevation of the asked direction in its plane."""
        return self.pitch_of(z_axis_of(self.frame))

    def pitch_of(self, hand: Vector) -> float:
        """Return the elevation of a direction, seen in the goal's plane."""
        return math.atan2(hand[2], dot(hand, self.outwards))

    def wanted(self, now: Transform) -> Matrix3:
        """Return the goal's rotation for a hand that is at `now`; free parts stay as they are."""
        turned, target = rotation_of(now), rotation_of(self.frame)
        hand = self._direction(columns(turned)[2])
        if Part.ROLL not in self.parts:
            return _swung(turned, hand)
        x, _, z = columns(target)
        if hand == z:
            return target
        plane = self._plane(columns(turned)[2])
        return _rolled(hand, _level(hand, plane), _roll(x, z, self.outwards))

    def turn(self, now: Transform) -> tuple[Vector, tuple[tuple[Part, Vector, float], ...]]:
        """Return the rotation vector, in the world, that leads from `now` to the goal.

        Also return, for each required one of heading, pitch and roll, the axis about which it
        changes and the part of the vector along that axis.
        """
        turned, wanted = rotation_of(now), self.wanted(now)
        vector = rotation_vector(multiply(wanted, transpose(turned)))
        hand = (wanted[0][2], wanted[1][2], wanted[2][2])
        plane = self._plane((turned[0][2], turned[1][2], turned[2][2]))
        across = (-plane[1], plane[0], 0.0)
        named = (
            (Part.HEADING, cross(hand, across)),
            (Part.PITCH, across),
            (Part.ROLL, hand),
        )
        return vector, tuple(
            (part, axis, dot(vector, axis)) for part, axis in named if part in self.parts
        )

    def _direction(self, hand: Vector) -> Vector:
        """Return where the hand should point, given where it points now."""
        asked = z_axis_of(self.frame)
        heading, pitch = Part.HEADING in self.parts, Part.PITCH in self.parts
        if heading and pitch:
            return asked
        if heading:
            return _elevated(self.outwards, self.pitch_of(hand))
        return _elevated(self._plane(hand), self.pitch_rad) if pitch else hand

    def _plane(self, hand: Vector) -> Vector:
        """Return the outward direction of the plane: the goal's, or where it is free the hand's.

        A pitch beyond the vertical leans back over the plane's outward direction.
        """
        heading = None if Part.HEADING in self.parts else _heading(hand)
        if heading is None:
            return self.outwards
        return scale(math.copysign(1.0, math.cos(self.pitch_rad)), heading)


def frame_goal(
    frame: Transform, parts: frozenset[Part] = ALL_PARTS, centre: Vector = (0.0, 0.0, 0.0)
) -> Goal:
    """Return the goal of a full frame, or of some parts of it.

    The hand's own vertical plane is the goal's; a vertical hand lies in the plane through
    `centre` (the arm's base) and the position. Raises as `check_transform` does.
    """
    checked = check_transform(frame)
    away = subtract(position_of(checked), centre)
    outwards = _heading(z_axis_of(checked)) or _heading(away) or X_AXIS
    return Goal(checked, outwards, parts)


def pose_goal(pose: Pose, centre: Vector = (0.0, 0.0, 0.0)) -> Goal:
    """Return the goal of a five-axis pose: the hand in the plane of the base axis and the tip.

    `centre` is a point of the base axis. A tip on that axis leaves the plane free, and with it
    the heading; its pitch and roll then count in the plane the hand lies in.
    """
    require("a pose", pose, Pose, POSE_EXAMPLE)
    away = _heading(subtract(pose.position_mm, centre), AXIS_MM)
    on_axis, outwards = away is None, away or X_AXIS
    frame = hand_frame(pose, outwards)
    return Goal(frame, outwards, HEADING_FREE if on_axis else ALL_PARTS)


def hand_frame(pose: Pose, outwards: Vector) -> Transform:
    """Return the frame of a hand at a pose's place, pitch and roll, in the plane outwards."""
    hand, up = _elevated(outwards, pose.pitch_rad), upwards(outwards, pose.pitch_rad)
    return homogeneous(_rolled(hand, up, pose.roll_rad), pose.position_mm)


def upwards(outwards: Vector, pitch_rad: float) -> Vector:
    """Return the direction, normal to a hand of this pitch, that x has where the roll is zero."""
    return add(scale(-math.sin(pitch_rad), outwards), scale(math.cos(pitch_rad), Z_AXIS))


def turned_to(goal: Transform, frame: Transform) -> Transform:
    """Return a goal turned about z through its origin to come as near as it can to a frame."""
    (a, b, c, _), (d, e, f, _), _, _ = frame
    (u, v, w, x), (k, m, n, y), third, last = goal
    across = d * u + e * v + f * w - a * k - b * m - c * n
    along = a * u + b * v + c * w + d * k + e * m + f * n
    length = math.hypot(across, along)
    if length == 0.0:
        return goal
    p, q = along / length, across / length
    return (
        (p * u - q * k, p * v - q * m, p * w - q * n, x),
        (q * u + p * k, q * v + p * m, q * w + p * n, y),
        third,
        last,
    )


def _heading(v: Vector, least: float = VERTICAL) -> Vector | None:
    """Return the level direction of a vector; None where its level part is this short."""
    level = (v[0], v[1], 0.0)
    return unit(level) if norm(level) > least else None


def _elevated(outwards: Vector, pitch: float) -> Vector:
    return add(scale(math.cos(pitch), outwards), scale(math.sin(pitch), Z_AXIS))


def _level(hand: Vector, outwards: Vector) -> Vector:
    """Return the direction, normal to the hand, that x has where the roll is zero."""
    across = cross(Z_AXIS, outwards)
    up = cross(hand, across)
    return unit(up) if norm(up) > VERTICAL else Z_AXIS


def _roll(x: Vector, hand: Vector, outwards: Vector) -> float:
    level = _level(hand, outwards)
    return math.atan2(dot(x, cross(hand, level)), dot(x, level))


def _rolled(hand: Vector, level: Vector, roll: float) -> Matrix3:
    x = add(scale(math.cos(roll), level), scale(math.sin(roll), cross(hand, level)))
    return from_columns(x, cross(hand, x), hand)


def _swung(turned: Matrix3, hand: Vector) -> Matrix3:
    """Return a rotation turned, the shortest way, so that its z points along the hand."""
    x, _, z = columns(turned)
    middle, moved = add(z, hand), x  # opposite: about x, which is as good as any
    if norm(middle) > VERTICAL:  # else two mirrors: z to the middle, then to the hand
        middle = unit(middle)
        mirrored = subtract(x, scale(2.0 * dot(x, middle), middle))
        moved = subtract(mirrored, scale(2.0 * dot(mirrored, hand), hand))
    level = unit(reject(moved, hand))
    return from_columns(level, cross(hand, level), hand)


# The task of a driven chain's hand: its frame as a pose, and a pose as a goal.
#
# The hand points along z of the tool's frame; x of that frame is its roll reference. Three kinds of
# arms have three tasks. An arm of six joints takes any frame: its pitch is the elevation of the
# hand, its yaw the direction of the vertical plane that the hand lies in, and its roll is counted
# from upwards in that plane. Five joints leave the yaw to the arm. Where such an arm keeps its hand
# in the plane of base axis and tip, as the Mini-mover's build does, pitch counts outwards in that
# plane and may pass the vertical, as `FiveAxisArm` has it. Lengths in mm, angles in rad.

# A hand that leaves the plane of base axis and tip by less than this lies in it.
PLANE_SINE = 1e-9

# Random postures in which a hand must lie in the plane: one alone may do so by chance.
_LOOKS = 8


class HandTask(Enum):
    """What an arm can ask of its hand."""

    IN_PLANE = "position, pitch in the arm's plane, roll"
    ELEVATION = "position, elevation of the hand, roll; the heading is the arm's"
    WHOLE = "position, pitch, roll and yaw"


def task_of(chain: Chain) -> HandTask:
    """Return the task of a chain of five or six joints; `KinematicsError` for any other number."""
    if len(chain) == 6:
        return HandTask.WHOLE
    if len(chain) != 5:
        raise KinematicsError(
            f"an arm that is to be driven has five or six joints, not {len(chain)}"
        )
    draw = random.Random(1)  # noqa: S311 - any postures will do
    postures = (tuple(draw.uniform(-3.0, 3.0) for _ in chain.links) for _ in range(_LOOKS))
    centre = position_of(chain.base)
    planar = all(abs(_off_plane(chain.fk(values), centre)) < PLANE_SINE for values in postures)
    return HandTask.IN_PLANE if planar else HandTask.ELEVATION


def pose_of(frame: Transform, task: HandTask, centre: Vector) -> Pose:
    """Return the pose of the hand's frame; `centre` is a point of the base axis."""
    x, _, hand = columns(rotation_of(frame))
    if task is HandTask.IN_PLANE:
        outwards = _outwards(frame, centre)
        pitch = math.atan2(hand[2], dot(hand, outwards))
    else:
        outwards = _heading(hand) or X_AXIS
        pitch = math.atan2(hand[2], math.hypot(hand[0], hand[1]))
    up = upwards(outwards, pitch)
    roll = math.atan2(dot(x, cross(hand, up)), dot(x, up))
    yaw = math.atan2(outwards[1], outwards[0]) if task is HandTask.WHOLE else None
    return Pose(*position_of(frame), pitch, roll, yaw)


def goal_of(pose: Pose, task: HandTask, centre: Vector) -> Goal:
    """Return what a pose asks of the hand. Raises `KinematicsError` for a missing or extra yaw."""
    require("a pose", pose, Pose, POSE_EXAMPLE)
    if task is not HandTask.WHOLE:
        refuse_yaw(pose)
    elif pose.yaw_rad is None:
        raise KinematicsError(
            "this arm has six joints, so its poses need a yaw: yaw_deg in Python, --yaw of a "
            "command, or the sixth number of a program's `at`"
        )
    if task is HandTask.IN_PLANE:
        return pose_goal(pose, centre)
    heading = pose.yaw_rad or 0.0
    outwards = (math.cos(heading), math.sin(heading), 0.0)
    frame = hand_frame(pose, outwards)
    if task is HandTask.WHOLE:
        return Goal(frame, outwards)
    return Goal(frame, _heading(z_axis_of(frame)) or outwards, HEADING_FREE)


def _outwards(frame: Transform, centre: Vector) -> Vector:
    """Return the level direction from the base axis to the tip, or on it that of the hand."""
    away = _heading(subtract(position_of(frame), centre), AXIS_MM)
    return away or _heading(z_axis_of(frame)) or X_AXIS


def _off_plane(frame: Transform, centre: Vector) -> float:
    """Return the sine by which the hand leaves the plane of base axis and tip."""
    return dot(z_axis_of(frame), cross(Z_AXIS, _outwards(frame, centre)))
