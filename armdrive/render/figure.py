"""An arm, or any kinematic chain, as lines in space; and the ghost of an arm at its goal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from armdrive.render.camera import Dome
from armdrive.render.canvas import Ink, Layer, Letters, Stroke
from kinematics.chains.chain import Chain
from kinematics.chains.links import JointKind
from kinematics.frames.rotations import Matrix3, columns
from kinematics.frames.transforms import position_of, rotation_of
from kinematics.frames.vectors import Vector
from kinematics.geometry import ArmGeometry, Point
from kinematics.guards import Guards
from kinematics.limits import JointRange
from kinematics.spaces import Joints, Pose

_FINGERS = 0.4  # length of the fingers, as a share of the hand
_LEAST_FINGERS = 0.05  # share of the reach; keeps fingers visible if the hand is short or missing
_AXIS = 0.13  # length of the tool's axes, as a share of the reach
LETTER = 1.3  # distance of an axis's letter from its origin, in lengths of the axis

AXES = "xyz"
GOAL_LETTER = "G"

# The moving point before the tip, if a tool makes the tip differ from the finger tips.
_FINGER_TIPS = "fingers"


@dataclass(frozen=True, slots=True)
class Stance:
    """The geometry of an arm in one posture.

    `points` run from the table to the tip; `hand` holds the indices of wrist and finger tips.
    `axes` are the tool's x (out of the back of the hand), y (sideways) and z (along the hand).
    `opening_mm` is None for an arm without fingers, or if the opening is unknown. `reach_mm` is the
    arm's reach.
    """

    points: tuple[Point, ...]
    hand: tuple[int, int]
    axes: Matrix3
    opening_mm: float | None
    reach_mm: float

    @property
    def tip(self) -> Point:
        """The point that is moved to a goal."""
        return self.points[-1]


def stance(arm: ArmGeometry, joints: Joints, opening_mm: float | None, reach_mm: float) -> Stance:
    """Return the geometry of an arm in one posture."""
    points = arm.points(joints)
    last = len(points) - 1
    tips = last - 1 if _FINGER_TIPS in arm.moving_points else last
    return Stance(points, (tips - 1, tips), columns(arm.hand_axes(joints)), opening_mm, reach_mm)


def dome(arm: ArmGeometry) -> Dome:
    """Return the space within an arm's reach, centred on the last of its fixed points."""
    points = arm.points(Joints((0.0,) * len(arm.limits), arm.joint_names))
    still = len(points) - len(arm.moving_points) - 1
    reach_mm = sum(math.dist(a, b) for a, b in pairwise(points[max(still, 0) :]))
    return Dome(points[max(still, 0)], max(reach_mm, 1.0))


def figure(of: Stance) -> Layer:
    """Return the lines of the arm itself."""
    links = Stroke(Ink.ARM, _links(of))
    axes = _axes(of, of.reach_mm * _AXIS)
    fingers = tuple(Stroke(Ink.GRIPPER, line) for line in _fingers(of))
    return Layer((links, *fingers, *axes.strokes), axes.letters, of.points[1:-1])


def ghost(of: Stance) -> Layer:
    """Return the arm at its goal: dashed, with a letter at the tip."""
    lines = (_links(of), *_fingers(of))
    strokes = tuple(Stroke(Ink.GOAL, line) for line in lines)
    return Layer(strokes, (Letters(Ink.GOAL, of.tip, GOAL_LETTER),))


def _links(of: Stance) -> tuple[Point, ...]:
    """Return the line along the arm, with the palm if there are fingers."""
    wrist, tips = of.hand
    if of.opening_mm is None:
        return of.points
    return (*of.points[: wrist + 1], _palm(of), *of.points[tips + 1 :])


def _palm(of: Stance) -> Point:
    """Return the point where the fingers begin."""
    wrist, tips = (of.points[index] for index in of.hand)
    back = max(math.dist(wrist, tips) * _FINGERS, of.reach_mm * _LEAST_FINGERS)
    return _moved(tips, of.axes[2], -back)


def _fingers(of: Stance) -> tuple[tuple[Point, ...], ...]:
    """Return the outline of palm and fingers, with the fingers `opening_mm` apart."""
    if of.opening_mm is None:
        return ()
    side, half = of.axes[1], of.opening_mm / 2.0
    palm, tips = _palm(of), of.points[of.hand[1]]
    left = (_moved(tips, side, -half), _moved(palm, side, -half))
    right = (_moved(palm, side, half), _moved(tips, side, half))
    return ((*left, *right),)


def _axes(of: Stance, length_mm: float) -> Layer:
    strokes = tuple(Stroke(Ink.AXIS, (of.tip, _moved(of.tip, axis, length_mm))) for axis in of.axes)
    letters = tuple(
        Letters(Ink.AXIS, _moved(of.tip, axis, length_mm * LETTER), letter)
        for axis, letter in zip(of.axes, AXES, strict=True)
    )
    return Layer(strokes, letters)


def _moved(point: Point, along: Vector, by_mm: float) -> Point:
    x, y, z = point
    return x + along[0] * by_mm, y + along[1] * by_mm, z + along[2] * by_mm


# --- Any chain of links, those with slides included ----------------------------------------------
#
# A view needs an arm's points, the axes of its hand, and the limits of its joints. Prismatic joints
# are measured in mm back from full extension: a view scales its picture by the zero posture, which
# then is the longest one.

# No obstacles: a model stands alone.
NO_GUARDS = Guards(
    table=False, inner_radius_mm=None, outer_radius_mm=None, hand_wrist_radius_mm=None
)

FREE_MM = 500.0  # assumed limit of a prismatic joint without limits


@dataclass(frozen=True, slots=True)
class ChainFigure:
    """A chain with the interface that views need."""

    chain: Chain

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints from the base to the hand."""
        return self.chain.joint_names

    @property
    def limits(self) -> tuple[JointRange, ...]:
        """The limits of each joint; half a turn either way for a joint that turns endlessly."""
        return tuple(
            JointRange(low, high) if kind is JointKind.REVOLUTE else JointRange(low - high, 0.0)
            for kind, (low, high) in zip(self.chain.kinds, self._bounds, strict=True)
        )

    @property
    def moving_points(self) -> tuple[str, ...]:
        """Names of the points that move: the end of each link, and the tip."""
        return (*self.chain.joint_names, "tip")

    def joints(self, values: Sequence[float]) -> Joints:
        """Convert a chain's joint values (rad and mm) to those of the view."""
        shifted = (value - out for value, out in zip(values, self._outmost, strict=True))
        return Joints(tuple(shifted), self.joint_names)

    def points(self, joints: Joints) -> tuple[Point, ...]:
        """Return the base, the end of each link and the tip, in mm."""
        values = self._values(joints)
        frames = self.chain.frames(values)
        return *map(position_of, frames), position_of(self.chain.fk(values))

    def hand_axes(self, joints: Joints) -> Matrix3:
        """Return the tool's axes as the columns of a matrix."""
        return rotation_of(self.chain.fk(self._values(joints)))

    def fk(self, joints: Joints) -> Pose:
        """Return the position of the tip and the pitch of the tool's z axis."""
        frame = self.chain.fk(self._values(joints))
        along = frame[0][2], frame[1][2], frame[2][2]
        pitch = math.atan2(along[2], math.hypot(along[0], along[1]))
        return Pose(*position_of(frame), pitch)

    def _values(self, joints: Joints) -> tuple[float, ...]:
        return tuple(value + out for value, out in zip(joints, self._outmost, strict=True))

    @property
    def _bounds(self) -> tuple[tuple[float, float], ...]:
        """The limits in rad and mm, all finite."""
        return tuple(
            (
                low if math.isfinite(low) else -_free(kind),
                high if math.isfinite(high) else _free(kind),
            )
            for kind, (low, high) in zip(self.chain.kinds, self.chain.limits, strict=True)
        )

    @property
    def _outmost(self) -> tuple[float, ...]:
        return tuple(
            0.0 if kind is JointKind.REVOLUTE else high
            for kind, (_, high) in zip(self.chain.kinds, self._bounds, strict=True)
        )


@dataclass(frozen=True, slots=True)
class DrawnChain:
    """A model as a view needs it: the figure, and no guards."""

    arm: ChainFigure
    guards: Guards = NO_GUARDS


def _free(kind: JointKind) -> float:
    return math.pi if kind is JointKind.REVOLUTE else FREE_MM
