"""A straight line of the tip as many points at once: joint angles and times, for the five axes.

Lengths in mm, angles in rad, times in s, with numpy. The points are evenly spaced in x, y, z,
pitch and roll, and all on the start's branch: the answers of `line.py`, thousands at a time.
Where anything is irregular (a straight or folded elbow, a tip near the base axis, a limit), the
line is solved again point by point, which also finds out where and why it breaks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kinematics.batch_line_solve import Course, LineSolver, course_of
from kinematics.batch_line_times import LineTimer
from kinematics.batch_trig import Array
from kinematics.curves import LARGEST_BASE_TURN_RAD
from kinematics.errors import KinematicsError, PathBroken, finite
from kinematics.five_axis import FiveAxisArm
from kinematics.spaces import Joints, Pose
from kinematics.timing import timed
from kinematics.timing_limits import MotionLimits

JOINTS = 5


class DenseLine(NamedTuple):
    """Points of a line: joint angles (N, 5), and the time (N,) of each from the first."""

    joints: Array
    times_s: Array


class LinePlanner:
    """Plans lines of one arm in a given number of points; it keeps room for one plan at a time.

    `limits` are of the joints and, if there is one more coordinate, of a gripper that rests. A
    build-up time is refused: `timed` knows it. What keeps the limits, and how far: see
    batch_line_times.py.
    """

    def __init__(self, arm: FiveAxisArm, limits: MotionLimits, points: int) -> None:
        if points < 3:
            raise KinematicsError(f"a dense line needs at least 3 points, not {points}")
        if len(limits.speeds) < JOINTS:
            raise KinematicsError(
                f"limits of {JOINTS} joints are needed, not of {len(limits.speeds)}"
            )
        if limits.jerk_s > 0.0:
            raise KinematicsError("a dense line has no build-up time: give limits without jerk_s")
        self._arm = arm
        self._points = points
        self._solver = LineSolver(arm, points)
        self._timer = LineTimer(limits, JOINTS, points)
        count = len(limits.speeds)
        self._rest = (0.0,) * (count - JOINTS)
        self._limits = limits

    def plan(self, start: Joints, goal: Pose, speed: float = 1.0) -> DenseLine:
        """Return the line from a posture to a pose, from rest to rest, in new arrays.

        `speed` is a fraction (above 0, up to 1) of the speeds and motor rates. Raises
        `PathBroken`, which names the first point that cannot be followed; that is also one
        before which the base would turn by more than half a rad at once.
        """
        if not 0.0 < finite("speed", speed) <= 1.0:
            raise KinematicsError(
                f"speed is a fraction of the limits, above 0 and up to 1, not {speed!r}"
            )
        joints = np.empty((JOINTS, self._points))
        times_s = np.empty(self._points)
        course = course_of(self._arm, start.angles_rad, goal)  # type: ignore[arg-type]
        if course is None or not self._solver.solve(course, joints) or _leaps(course, joints):
            self._one_by_one(start, goal, joints)
        self._timer.fill(joints, speed, times_s)
        if not times_s[-1] < math.inf:  # a step without motion, or a line of such
            points = [(*point, *self._rest) for point in joints.T.tolist()]
            times_s[:] = timed(points, self._limits, speed).times_s
        return DenseLine(joints.T, times_s)

    def _one_by_one(self, start: Joints, goal: Pose, joints: Array) -> None:
        """Fill the joints as `line.py` solves them, one after the other."""
        line = self._arm.line(start, goal)
        before = start
        for index, share in enumerate(self._solver.shares.tolist()):
            reached = line.solve(share, before)
            reason = line.leap(before, reached)
            if reason is not None:
                raise PathBroken(share, line.pose(share), reason)
            joints[:, index] = reached.angles_rad
            before = reached


def _leaps(course: Course, joints: Array) -> bool:
    """Tell whether the base turns too far between two points.

    It does not where the line passes the base axis at a distance that a step is short of; the
    cross product of start and way is that distance times the way.
    """
    along, across = course.change[:2]
    allowed = LARGEST_BASE_TURN_RAD * (joints.shape[1] - 1)
    if along * along + across * across <= allowed * abs(course.start[0] * across):
        return False
    return bool(np.abs(np.diff(joints[0])).max() > LARGEST_BASE_TURN_RAD)
