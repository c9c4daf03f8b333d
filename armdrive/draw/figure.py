"""An arm in one posture as lines in space: links, joints, fingers and tool axes; or its ghost."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from armdrive.draw.camera import Dome
from armdrive.draw.inks import Ink, Layer, Letters, Stroke
from kinematics.frames.rotations import Matrix3, columns
from kinematics.frames.vectors import Vector
from kinematics.geometry import ArmGeometry, Point
from kinematics.spaces import Joints

_FINGERS = 0.4
"""Share of the hand that is fingers."""

_LEAST_FINGERS = 0.05
"""As a share of the reach: shorter ones could not be seen, and some arms have no hand at all."""

_AXIS = 0.13
"""Length of the tool's axes, as a share of the reach."""

_LETTER = 1.3
"""Where an axis has its letter, in lengths of the axis."""

AXES = "xyz"
GOAL_LETTER = "G"

_OWN_TIPS = "fingers"
"""What the moving point before the tip is called where a tool is held beside the hand."""


@dataclass(frozen=True, slots=True)
class Stance:
    """Where everything of an arm is in a posture.

    `points` go from the table to the tip, `hand` holds the places of wrist and finger tips among
    them. `axes` are the tool's x, y and z: up from the hand's back, its side, along it.
    `opening_mm` is None where there are no fingers, or nobody knows. `reach_mm` is the arm's.
    """

    points: tuple[Point, ...]
    hand: tuple[int, int]
    axes: Matrix3
    opening_mm: float | None
    reach_mm: float

    @property
    def tip(self) -> Point:
        """The point that goals are meant for."""
        return self.points[-1]


def stance(arm: ArmGeometry, joints: Joints, opening_mm: float | None, reach_mm: float) -> Stance:
    """Return where everything of an arm is in a posture."""
    points = arm.points(joints)
    last = len(points) - 1
    tips = last - 1 if _OWN_TIPS in arm.moving_points else last
    return Stance(points, (tips - 1, tips), columns(arm.hand_axes(joints)), opening_mm, reach_mm)


def dome(arm: ArmGeometry) -> Dome:
    """Return what an arm can fill: about the last of its points that never moves."""
    points = arm.points(Joints((0.0,) * len(arm.limits), arm.joint_names))
    still = len(points) - len(arm.moving_points) - 1
    reach_mm = sum(math.dist(a, b) for a, b in pairwise(points[max(still, 0) :]))
    return Dome(points[max(still, 0)], max(reach_mm, 1.0))


def figure(of: Stance) -> Layer:
    """Return the arm itself."""
    links = Stroke(Ink.ARM, _links(of))
    axes = _axes(of, of.reach_mm * _AXIS)
    fingers = tuple(Stroke(Ink.GRIPPER, line) for line in _fingers(of))
    return Layer((links, *fingers, *axes.strokes), axes.letters, of.points[1:-1])


def ghost(of: Stance) -> Layer:
    """Return where the arm is to go: dashed, with a letter at its tip."""
    lines = (_links(of), *_fingers(of))
    strokes = tuple(Stroke(Ink.GOAL, line) for line in lines)
    return Layer(strokes, (Letters(Ink.GOAL, of.tip, GOAL_LETTER),))


def _links(of: Stance) -> tuple[Point, ...]:
    """Return the line along the arm, as far as the palm where there are fingers."""
    wrist, tips = of.hand
    if of.opening_mm is None:
        return of.points
    return (*of.points[: wrist + 1], _palm(of), *of.points[tips + 1 :])


def _palm(of: Stance) -> Point:
    """Return the point where the fingers part."""
    wrist, tips = (of.points[index] for index in of.hand)
    back = max(math.dist(wrist, tips) * _FINGERS, of.reach_mm * _LEAST_FINGERS)
    return _moved(tips, of.axes[2], -back)


def _fingers(of: Stance) -> tuple[tuple[Point, ...], ...]:
    """Return two fingers as far apart as they are open, with the palm between them."""
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
        Letters(Ink.AXIS, _moved(of.tip, axis, length_mm * _LETTER), letter)
        for axis, letter in zip(of.axes, AXES, strict=True)
    )
    return Layer(strokes, letters)


def _moved(point: Point, along: Vector, by_mm: float) -> Point:
    x, y, z = point
    return x + along[0] * by_mm, y + along[1] * by_mm, z + along[2] * by_mm
