"""A straight line of the tip as many points at once: joint angles and times, for the five axes.

Lengths in mm, angles in rad, times in s, with numpy. The points are evenly spaced in x, y, z,
pitch and roll, and all on the start's branch: the answers of `follow`, thousands at a time.
Where anything is irregular (a straight or folded elbow, a tip near the base axis, a limit), the
line is solved again point by point, which also finds out where and why it breaks.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kinematics.errors import KinematicsError, PathBroken, finite
from kinematics.five_axis.arm import FiveAxisArm
from kinematics.five_axis.batch import Array
from kinematics.five_axis.closed_form import AXIS_MM, Angles, forward
from kinematics.limits import LIMIT_TOLERANCE_RAD, JointRange, wrap
from kinematics.paths.curves import LARGEST_BASE_TURN_RAD
from kinematics.paths.motion_limits import MotionLimits
from kinematics.paths.timing import timed
from kinematics.spaces import Joints, Pose

# Joint angles of many points of one straight line, solved at once on the branch of its start.
#
# What costs time at a few hundred points is the number of calls, so all that is linear along the
# line, or in the squared distance of the wrist, is filled by one product of rows, and the four
# directions (base, wrist, lift of the upper arm, half the elbow's bend) are taken by one call. The
# base's direction is taken from that of the start, and a straight line is seen from the base axis
# under less than half a circle: so it needs no unwinding.
#
# Source: McKerrow, chapter 4, section 16, as `closed_form` writes it; the bend by half angles as in
# `batch`.

REGULAR = 1e-12
"""Squares of the sine and cosine of half the bend below which the elbow is straight or folded."""


class LineCourse(NamedTuple):
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

    def solve(self, course: LineCourse, joints: Array) -> bool:
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

    def _directions(self, course: LineCourse) -> bool:
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

    def _take_hand(self, course: LineCourse, hand: float) -> None:
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


def course_of(arm: FiveAxisArm, start: Angles, goal: Pose) -> LineCourse | None:
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
    return LineCourse(
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


# The time of each of many points of a path, under speeds, accelerations and motor rates.
#
# The points are evenly spaced on the path's parameter, of which one unit is one point. Squared
# speeds are limited at every point, and their change from point to point, so the quickest profile
# is the least of lines of limited slope: a running sum of the slopes and a running least, forwards
# and backwards.
#
# The acceleration of a joint is its change by the path's own bend, times the squared speed, and by
# speeding up. Both are taken at the worst joint each, as if they always added up; the bend may have
# half of the limit at most, and speeding up what the fastest allowed speed leaves. So no speed is
# passed, an acceleration by no more than a joint's rate changes from one step to the next (2 % of
# it with a thousand points), and on strongly curved parts some is given away (`paths.timing` gives
# away less).

_TINY = 1e-300
"""Keeps a limit by a number from being a limit by nothing."""

_STEEPEST = 1e-6
"""Where nothing limits an acceleration: full speed within a millionth of the way to the next."""


class LineTimer:
    """Room for the points of a path, and the limits of its joints as rows of products."""

    def __init__(self, limits: MotionLimits, joints: int, points: int) -> None:
        speeds = np.diag([1.0 / speed for speed in limits.speeds[:joints]])
        motors = [np.array(row[:joints])[None] / limits.motor_hz for row in limits.motors]
        ramps = np.diag([1.0 / limit for limit in limits.accelerations[:joints]])
        bounded = ramps.any(axis=1)
        self._all_bounded, self.ramps = bool(bounded.all()), bool(bounded.any())
        self._limits = np.concatenate([speeds, *motors, ramps[bounded]])
        count, between = len(self._limits), points - 1
        fast = count - int(bounded.sum())
        self._changes = np.empty((joints, between))
        self._shares = np.empty((count, between))
        self._fast, self._hard = self._shares[:fast], self._shares[fast:]
        self._hard_before, self._hard_behind = self._hard[:, :-1], self._hard[:, 1:]
        self._bends = np.empty((count - fast, points - 2))
        self._bend = np.empty(points - 2)
        self._times, self._slopes, self._caps = np.empty((3, between))
        self._caps_before, self._caps_behind = self._caps[:-1], self._caps[1:]
        self._squares, self._bent, self._sums, self._double = np.zeros((4, points))
        self._inner, self._inner_bent = self._squares[1:-1], self._bent[1:-1]
        self._bent_before, self._bent_behind = self._bent[:-1], self._bent[1:]
        self._backwards, self._later_sums = self._squares[::-1], self._sums[1:]

    @np.errstate(all="ignore")
    def fill(self, joints: Array, speed: float, times_s: Array) -> None:
        """Fill the times of joints (5, N) of a path from rest to rest.

        The last of them is no number if the joints stand still from some point to the next.
        """
        times, shares = self._times, self._shares
        np.subtract(joints[:, 1:], joints[:, :-1], self._changes)
        np.matmul(self._limits, self._changes, out=shares)
        if self.ramps:
            np.subtract(self._hard_behind, self._hard_before, self._bends)
        np.abs(shares, shares)
        np.maximum.reduce(self._fast, axis=0, out=times)
        times_s[0] = 0.0
        if not self.ramps:
            times /= speed
            np.add.accumulate(times, out=times_s[1:])
            return
        self._limit(speed)
        speeds = self._pass()
        np.add(speeds[1:], speeds[:-1], times)
        np.divide(2.0, times, times)
        np.add.accumulate(times, out=times_s[1:])

    def _limit(self, speed: float) -> None:
        """Find the highest squared speed at every point, and its steepest change between them."""
        caps, slopes, bend, bends = self._caps, self._slopes, self._bend, self._bends
        inner, bent = self._inner, self._inner_bent
        np.multiply(self._times, self._times, caps)
        np.maximum.reduce(self._hard, axis=0, out=slopes)
        if not self._all_bounded:
            np.maximum(slopes, caps * _STEEPEST, out=slopes)
        np.divide(speed * speed, caps, caps)
        np.minimum(self._caps_behind, self._caps_before, out=inner)
        np.abs(bends, bends)
        np.maximum.reduce(bends, axis=0, out=bend)
        bend += _TINY
        np.divide(0.5, bend, bent)
        np.minimum(inner, bent, out=inner)
        np.multiply(inner, bend, bent)
        np.maximum(self._bent_behind, self._bent_before, out=caps)
        np.subtract(1.0, caps, caps)
        np.divide(caps, slopes, slopes)

    def _pass(self) -> Array:
        """Return the speed at every point: squares whose change nowhere passes its limit."""
        squares, sums, both = self._squares, self._sums, self._double
        np.add.accumulate(self._slopes, out=self._later_sums)
        np.multiply(sums, 4.0, both)
        sums *= 2.0
        squares -= sums
        np.minimum.accumulate(squares, out=squares)
        squares += both
        np.minimum.accumulate(self._backwards, out=self._backwards)
        squares -= sums
        squares[0] = squares[-1] = 0.0  # but for rounding, they are
        np.sqrt(squares, sums)
        return sums


JOINTS = 5


class DenseLine(NamedTuple):
    """Points of a line: joint angles (N, 5), and the time (N,) of each from the first."""

    joints: Array
    times_s: Array


class LinePlanner:
    """Plans lines of one arm in a given number of points; it keeps room for one plan at a time.

    `limits` are of the joints and, if there is one more coordinate, of a gripper that rests. A
    build-up time is refused: `timed` knows it. How far limits are kept is said at `LineTimer`.
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
        """Fill the joints as `follow` solves them, one after the other."""
        line = self._arm.line(start, goal)
        before = start
        for index, share in enumerate(self._solver.shares.tolist()):
            reached = line.solve(share, before)
            reason = line.leap(before, reached)
            if reason is not None:
                raise PathBroken(share, line.pose(share), reason)
            joints[:, index] = reached.angles_rad
            before = reached


def _leaps(course: LineCourse, joints: Array) -> bool:
    """Tell whether the base turns too far between two points.

    It does not where the line passes the base axis at a distance that a step is short of; the
    cross product of start and way is that distance times the way.
    """
    along, across = course.change[:2]
    allowed = LARGEST_BASE_TURN_RAD * (joints.shape[1] - 1)
    if along * along + across * across <= allowed * abs(course.start[0] * across):
        return False
    return bool(np.abs(np.diff(joints[0])).max() > LARGEST_BASE_TURN_RAD)
