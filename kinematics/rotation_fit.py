"""The rotation nearest to a matrix that rounding or measurement has spoiled.

Nearest in the sum of squared differences of the entries. Method: the rotation R that maximises
the trace of R^t M belongs to the quaternion that is the leading eigenvector of a symmetric 4x4
matrix made of M's entries (P. B. Davenport's q method; B. K. P. Horn, "Closed-form solution of
absolute orientation using unit quaternions", 1987). It finds a proper rotation for every matrix
that has a single nearest one, left-handed ones included.
"""

from __future__ import annotations

from kinematics.eigen import symmetric_eigen
from kinematics.errors import NoNearestRotation
from kinematics.quaternions import Quaternion
from kinematics.rotation_check import finite_matrix
from kinematics.rotations import Matrix3

TIE = 1e-9
"""Relative gap of the two leading eigenvalues below which rounding would choose the rotation."""


def nearest_rotation(matrix: Matrix3) -> Matrix3:
    """Return the rotation nearest to a matrix.

    Raises `NoNearestRotation` where several are equally near, and `BadNumber` or
    `KinematicsError` for entries that are not finite numbers or another shape than 3x3.
    """
    size = max(abs(entry) for row in finite_matrix(matrix) for entry in row)
    if size == 0.0:
        raise NoNearestRotation
    (a, b, c), (d, e, f), (g, h, i) = (tuple(x / size for x in row) for row in matrix)
    values, vectors = symmetric_eigen(
        [
            [a + e + i, h - f, c - g, d - b],
            [h - f, a - e - i, b + d, c + g],
            [c - g, b + d, e - a - i, f + h],
            [d - b, c + g, f + h, i - a - e],
        ]
    )
    if values[0] - values[1] <= TIE:
        raise NoNearestRotation
    return Quaternion.of(*vectors[0]).rotation()
