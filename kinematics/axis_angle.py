"""Orientation by an axis and an angle, both ways (Craig, "Introduction to Robotics", 2.8).

Angles in rad. Every rotation is one turn about one axis (Euler's theorem).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinematics.numbers import cos, sin
from kinematics.orientation_solution import DEGENERATE_RAD, Degeneracy, OrientationSolution
from kinematics.quaternions import Quaternion, quaternion_of, solve_quaternion
from kinematics.rotations import Matrix3
from kinematics.vectors import Z_AXIS, Vector, norm, scale, unit


@dataclass(frozen=True, slots=True)
class AxisAngle:
    """A turn by an angle in rad, right-handed about an axis, which is scaled to length 1.

    Raises `ZeroVector` for an axis without a direction.
    """

    axis: Vector
    angle_rad: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "axis", unit(self.axis))

    def quaternion(self) -> Quaternion:
        """Return the unit quaternion of the turn."""
        x, y, z = scale(math.sin(self.angle_rad / 2.0), self.axis)
        return Quaternion.of(math.cos(self.angle_rad / 2.0), x, y, z)

    def rotation(self) -> Matrix3:
        """Return the rotation matrix (Rodrigues' formula)."""
        x, y, z = self.axis
        c, s, half = cos(self.angle_rad), sin(self.angle_rad), sin(self.angle_rad / 2.0)
        v = 2.0 * half * half  # 1 - c, with all its digits
        return (
            (x * x * v + c, x * y * v - z * s, x * z * v + y * s),
            (x * y * v + z * s, y * y * v + c, y * z * v - x * s),
            (x * z * v - y * s, y * z * v + x * s, z * z * v + c),
        )


def solve_axis_angle(matrix: Matrix3) -> OrientationSolution[AxisAngle]:
    """Return the axis and angle of a rotation, and the opposite axis with the opposite angle.

    The first angle is from 0 to pi. Where nothing turns (`Degeneracy.NO_TURN`) the axis is Z and
    there is no second answer; at half a turn (`HALF_TURN`) the second answer is the opposite axis
    with the same angle. Raises `NotARotation`.
    """
    solved = solve_quaternion(matrix)
    half_sine = norm(solved.first.vector)
    if half_sine <= DEGENERATE_RAD / 2.0:
        return OrientationSolution(AxisAngle(Z_AXIS, 0.0), None, Degeneracy.NO_TURN)
    axis = solved.first.vector
    opposite = scale(-1.0, axis)
    if solved.degeneracy is Degeneracy.HALF_TURN:
        first, second = AxisAngle(axis, math.pi), AxisAngle(opposite, math.pi)
        return OrientationSolution(first, second, Degeneracy.HALF_TURN)
    angle = 2.0 * math.atan2(half_sine, solved.first.w)
    return OrientationSolution(AxisAngle(axis, angle), AxisAngle(opposite, -angle), None)


def rotation_vector(matrix: Matrix3) -> Vector:
    """Return the axis times the angle in rad: zero for no turn, and exact for the smallest ones.

    Raises `NotARotation`.
    """
    quaternion = solve_quaternion(matrix).first
    half_sine = norm(quaternion.vector)
    if half_sine == 0.0:
        return quaternion.vector
    angle = 2.0 * math.atan2(half_sine, quaternion.w)
    return scale(angle / half_sine, quaternion.vector)


def turn_between(first: Matrix3, second: Matrix3) -> float:
    """Return the angle from 0 to pi, in rad, that turns one rotation into another.

    The two are taken to be rotations; they are not checked.
    """
    turn = quaternion_of(first).inverse() * quaternion_of(second)
    return 2.0 * math.atan2(norm(turn.vector), abs(turn.w))
