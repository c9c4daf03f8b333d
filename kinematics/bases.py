"""Bases: right- and left-handed axes, and vectors observed in one basis or another.

A basis is a `Matrix3` with its three axes as columns, all observed in one common frame.
"""

from __future__ import annotations

from enum import Enum

from kinematics.errors import FlatBasis
from kinematics.rotations import Matrix3, columns, from_columns, multiply
from kinematics.vectors import Vector, cross, norm, reject, scale, triple, unit

FLAT = 1e-12
"""Share of the largest possible volume of three axes below which they count as one plane."""


class Handedness(Enum):
    """On which side of the plane of X and Y the Z axis is."""

    RIGHT = "right-handed"
    LEFT = "left-handed"


def handedness(x: Vector, y: Vector, z: Vector) -> Handedness:
    """Tell the handedness of three axes by the sign of x . (y x z). Raises `FlatBasis`."""
    return Handedness.RIGHT if _volume(x, y, z) > 0.0 else Handedness.LEFT


def third_axis(x: Vector, y: Vector, hand: Handedness = Handedness.RIGHT) -> Vector:
    """Return the unit Z axis normal to X and Y that gives the basis its handedness.

    Raises `ZeroVector` where X and Y are parallel, or one is zero.
    """
    z = unit(cross(unit(x), unit(y)))
    return z if hand is Handedness.RIGHT else scale(-1.0, z)


def basis_along(x: Vector, towards_y: Vector) -> Matrix3:
    """Return the right-handed orthonormal basis with X along `x` and Y as near to `towards_y`.

    Raises `ZeroVector` where the two are parallel, or one is zero.
    """
    x = unit(x)
    y = unit(reject(unit(towards_y), x))
    return from_columns(x, y, cross(x, y))


def inverse(matrix: Matrix3) -> Matrix3:
    """Return the inverse by cofactors (equation 2.18), of any basis, skew ones included.

    Raises `FlatBasis` where there is none.
    """
    x, y, z = columns(matrix)
    volume = _volume(x, y, z)
    return (
        scale(1.0 / volume, cross(y, z)),
        scale(1.0 / volume, cross(z, x)),
        scale(1.0 / volume, cross(x, y)),
    )


def change_of_basis(old: Matrix3, new: Matrix3) -> Matrix3:
    """Return the matrix that takes components in the old basis to components in the new one.

    Any two bases will do. Between orthonormal ones of the same handedness it is a rotation;
    between a right- and a left-handed one it is none, and its determinant is negative. Raises
    `FlatBasis`.
    """
    handedness(*columns(old))
    return multiply(inverse(new), old)


def _volume(x: Vector, y: Vector, z: Vector) -> float:
    volume = triple(x, y, z)
    if abs(volume) <= FLAT * norm(x) * norm(y) * norm(z):
        raise FlatBasis
    return volume
