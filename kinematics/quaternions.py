"""Unit quaternions (Hamilton's, scalar first): a rotation in four numbers, both ways.

Sources: J. J. Craig, "Introduction to Robotics", section 2.8 (Euler parameters); S. W. Shepperd,
"Quaternion from rotation matrix", 1978, for the way back that divides by no small number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinematics.errors import NotAUnitQuaternion, ZeroVector, finite
from kinematics.orientation_solution import DEGENERATE_RAD, Degeneracy, OrientationSolution
from kinematics.rotation_check import ROTATION_TOLERANCE, check_rotation
from kinematics.rotations import Matrix3
from kinematics.vectors import Vector, add, cross, dot, scale


@dataclass(frozen=True, slots=True)
class Quaternion:
    """w + x i + y j + z k of length 1: cos of half the angle, and sin of it along the axis.

    Raises `NotAUnitQuaternion` for another length, `BadNumber` for what is not finite. `a * b`
    turns by b and then by a, both about fixed axes, like the product of their matrices.
    """

    w: float
    x: float
    y: float
    z: float

    def __post_init__(self) -> None:
        for name in ("w", "x", "y", "z"):
            object.__setattr__(self, name, finite(name, getattr(self, name)))
        length = math.hypot(self.w, self.x, self.y, self.z)
        if abs(length - 1.0) > ROTATION_TOLERANCE:
            raise NotAUnitQuaternion(length)

    @classmethod
    def of(cls, w: float, x: float, y: float, z: float) -> Quaternion:
        """Scale four numbers to length 1. Raises `ZeroVector` where all are zero."""
        length = math.hypot(w, x, y, z)
        if length == 0.0:
            raise ZeroVector
        return cls(w / length, x / length, y / length, z / length)

    @property
    def vector(self) -> Vector:
        """The part along i, j and k."""
        return self.x, self.y, self.z

    def __mul__(self, other: Quaternion) -> Quaternion:
        w = self.w * other.w - dot(self.vector, other.vector)
        crossed = cross(self.vector, other.vector)
        x, y, z = add(
            add(scale(self.w, other.vector), scale(other.w, self.vector)),
            crossed,
        )
        return Quaternion.of(w, x, y, z)  # scaled, so that long products do not drift

    def __neg__(self) -> Quaternion:
        return Quaternion(-self.w, -self.x, -self.y, -self.z)

    def inverse(self) -> Quaternion:
        """Return the conjugate, which turns back."""
        return Quaternion(self.w, -self.x, -self.y, -self.z)

    def rotate(self, vector: Vector) -> Vector:
        """Return the vector turned: v + 2w (q x v) + 2 q x (q x v)."""
        turned = scale(2.0, cross(self.vector, vector))
        return add(add(vector, scale(self.w, turned)), cross(self.vector, turned))

    def rotation(self) -> Matrix3:
        """Return the rotation matrix."""
        w, x, y, z = self.w, self.x, self.y, self.z
        return (
            (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
            (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
            (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
        )


def solve_quaternion(matrix: Matrix3) -> OrientationSolution[Quaternion]:
    """Return the two quaternions of a rotation, each the negative of the other.

    The first has w > 0; at half a turn (`Degeneracy.HALF_TURN`, w = 0), where either is as good,
    it is the one whose first component that is not zero is positive. Raises `NotARotation`.
    """
    found = quaternion_of(check_rotation(matrix))
    if found.w > DEGENERATE_RAD / 2.0:
        return OrientationSolution(found, -found, None)
    if found.w < -DEGENERATE_RAD / 2.0:
        return OrientationSolution(-found, found, None)
    leading = next(part for part in found.vector if abs(part) > DEGENERATE_RAD)
    if leading < 0.0:
        found = -found
    return OrientationSolution(found, -found, Degeneracy.HALF_TURN)


def quaternion_of(matrix: Matrix3) -> Quaternion:
    """Return one of the two quaternions of a matrix that is known to be a rotation.

    It is not checked. Starts from whichever of the four components is the largest (Shepperd).
    """
    (a, b, c), (d, e, f), (g, h, i) = matrix
    squares = (1.0 + a + e + i, 1.0 + a - e - i, 1.0 - a + e - i, 1.0 - a - e + i)
    match squares.index(max(squares)):
        case 0:
            return Quaternion.of(squares[0], h - f, c - g, d - b)
        case 1:
            return Quaternion.of(h - f, squares[1], b + d, c + g)
        case 2:
            return Quaternion.of(c - g, b + d, squares[2], f + h)
        case _:
            return Quaternion.of(d - b, c + g, f + h, squares[3])
