"""Joint angles of many points of one straight line, solved at once on the branch of its start.

Lengths in mm, angles in rad. What costs time at a few hundred points is the number of calls, so
all that is linear along the line, or in the squared distance of the wrist, is filled by one
product of rows, and the four directions (base, wrist, lift of the upper arm, half the elbow's
bend) are taken by one call. The base's direction is taken from that of the start, and a straight
line is seen from the base axis under less than half a circle: so it needs no unwinding.

Source: McKerrow, chapter 4, section 16, as `closed_form` writes it; the bend by half angles as in
batch_inverse.py.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kinematics.batch_trig import Array
from kinematics.closed_form import AXIS_MM, Angles, forward
from kinematics.five_axis import FiveAxisArm
from kinematics.limits import LIMIT_TOLERANCE_RAD, JointRange, wrap
from kinematics.spaces import Pose

REGULAR = 1e-12
"""Squares of the sine and cosine of half the bend below which the elbow is straight or folded."""


class Course(NamedTuple):
    """A line in the frame that the start's base angle turns with, in the arm's own plane.

    `start` and `change` are of: along, across, 0, height of the tip above the shoulder.
    """

    base: float
    back: bool
    sign: float
    start: tuple[float, float, float, float]
    change: tuple[float, float, float, float]
    pitch: float
    pitch_change: float
    roll: float
    roll_change: float


class LineSolver:
    """Room for the points of a line of one arm, and the constants of its closed form."""

    def __init__(self, arm: FiveAxisArm, points: int) -> None:
        self._arm = arm
        self.shares = np.linspace(0.0, 1.0, points)
        _, upper, fore, _ = arm.lengths
        part = 0.25 / (upper * fore)
        lift = 0.5 * upper / fore - part * (upper * upper + fore * fore)
        shares = (part, 0.0, part, -part)
        rest = (lift, 0.0, -part * (upper - fore) ** 2, part * (upper + fore) ** 2)
        self._shares_of_square = np.array(shares)[:, None]
        self._rest_of_square = np.array(rest)[:, None]
        rows = np.empty((8, points))  # x and y of: the base, the wrist, the lift, half the bend
        self._linear, self._triangle, self._bend = rows[:4], rows[4:], rows[6:]
        self._tip, self._wrist = rows[:2], rows[2:4]
        self._r, self._z = rows[2], rows[3]
        self._across, self._cosine, self._sine = rows[5], rows[6], rows[7]
        self._x, self._y = rows[0::2], rows[1::2]
        self._squares = np.empty((2, points))
        self._square, self._other = self._squares
        self._angles = np.empty((4, points))
        self._base, self._direction, self._lift, self._half = self._angles
        self._pitch, self._spare = np.empty((2, points))
        low, high = self._bounds = tuple(
            tuple(getattr(one, name) for one in arm.limits) for name in ("low_rad", "high_rad")
        )
        self._one_turn = all(b - a < math.tau for a, b in zip(low[1:4], high[1:4], strict=True))

    def solve(self, course: Course, joints: Array) -> bool:
        """Fill joints (5, N); False where anything is irregular, and a closer look is needed."""
        if not self._one_turn or not self._directions(course):
            return False
        base, shoulder, elbow, wrist, roll = joints
        np.add(self._base, course.base, base)
        (np.subtract if course.sign > 0.0 else np.add)(self._direction, self._lift, shoulder)
        np.multiply(self._half, 2.0 * course.sign, elbow)
        np.add(shoulder, elbow, wrist)
        np.subtract(self._pitch if course.pitch_change else course.pitch, wrist, wrist)
        np.multiply(self.shares, course.roll_change, roll)
        roll += course.roll
        return self._within(joints)

    def _directions(self, course: Course) -> bool:
        """Find the four directions; False where the elbow is straight, folded or out of reach."""
        linear, hand = self._linear, self._arm.hand_mm
        start, change = np.array((course.start, course.change))[:, :, None]
        np.multiply(change, self.shares, linear)
        linear += start
        np.multiply(self._tip, self._tip, self._squares)
        np.add(self._square, self._other, self._r)
        np.sqrt(self._r, self._r)
        if course.back:
            np.negative(self._r, self._r)
        self._take_hand(course, hand)
        np.multiply(self._wrist, self._wrist, self._squares)
        self._square += self._other
        np.multiply(self._shares_of_square, self._square, self._triangle)
        self._triangle += self._rest_of_square
        if not np.minimum.reduce(self._bend, axis=None) > REGULAR:
            return False
        np.sqrt(self._bend, self._bend)
        np.multiply(self._cosine, self._sine, self._across)
        np.arctan2(self._y, self._x, self._angles)
        return True

    def _take_hand(self, course: Course, hand: float) -> None:
        """Go back from the tip to the wrist."""
        if not course.pitch_change:
            self._r -= hand * math.cos(course.pitch)
            self._z -= hand * math.sin(course.pitch)
            return
        pitch, spare = self._pitch, self._spare
        np.multiply(self.shares, course.pitch_change, pitch)
        pitch += course.pitch
        for function, part in ((np.cos, self._r), (np.sin, self._z)):
            function(pitch, spare)
            spare *= hand
            part -= spare

    def _within(self, joints: Array) -> bool:
        """Tell whether all angles are within limits, snapped to those that rounding passed."""
        lows, highs = self._bounds
        least = np.minimum.reduce(joints, axis=1).tolist()
        most = np.maximum.reduce(joints, axis=1).tolist()
        for index in range(5):
            low, high = lows[index], highs[index]
            if least[index] < low or most[index] > high:
                tolerance = LIMIT_TOLERANCE_RAD
                if least[index] < low - tolerance or most[index] > high + tolerance:
                    return False
                np.clip(joints[index], low, high, joints[index])
        return True


def course_of(arm: FiveAxisArm, start: Angles, goal: Pose) -> Course | None:
    """Return the line from a posture to a pose, or None where its start is irregular.

    That is one beyond a limit, with a straight elbow, or with the tip on the base axis.
    """
    for angle, bounds in zip(start, arm.limits, strict=True):
        if not bounds.low_rad <= angle <= bounds.high_rad:
            return None
    base, shoulder, elbow, wrist, roll = start
    x, y, z, pitch, task_roll = forward(start, arm.lengths)
    cosine, sine = math.cos(base), math.sin(base)
    back = x * cosine + y * sine < 0.0
    if back:
        cosine, sine = -cosine, -sine
    along = x * cosine + y * sine
    goal_along = goal.x_mm * cosine + goal.y_mm * sine
    goal_across = goal.y_mm * cosine - goal.x_mm * sine
    if along <= AXIS_MM or abs(math.remainder(elbow, math.pi)) <= REGULAR:
        return None
    turn = wrap(goal.pitch_rad - pitch)
    return Course(
        base,
        back,
        math.copysign(1.0, elbow),
        (along, 0.0, 0.0, z - arm.base_height_mm),
        (goal_along - along, goal_across, 0.0, goal.z_mm - z),
        shoulder + elbow + wrist,
        -turn if back else turn,
        roll,
        _roll_change(roll, wrap(goal.roll_rad - task_roll), arm.limits[4]),
    )


def _roll_change(roll: float, change: float, bounds: JointRange) -> float:
    """Return the shorter way round, or the longer one where only that is within the range."""
    if _holds(bounds, roll + change):
        return change
    other = change - math.copysign(math.tau, change)
    return other if _holds(bounds, roll + other) else change


def _holds(bounds: JointRange, angle: float) -> bool:
    return abs(bounds.clamp(angle) - angle) <= LIMIT_TOLERANCE_RAD
