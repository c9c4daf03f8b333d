"""Is a matrix a rotation? If not, which of the properties fails, and by how much.

The properties are those of chapter 2, section 2.3: columns of length 1, normal to each other,
and a determinant of 1. Units: rad, and mm in the position of a transform.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

from kinematics.errors import (
    KinematicsError,
    NotARotation,
    RotationFlaw,
    RotationProperty,
    finite,
)
from kinematics.frames import LAST_ROW, Transform, position_of, rotation_of, transform
from kinematics.rotations import Matrix3, columns, determinant
from kinematics.vectors import Vector, angle_between, dot, norm

ROTATION_TOLERANCE = 1e-9
"""How far lengths (of 1) and angles (rad) may be off: above rounding, below any arm's accuracy."""


def is_rotation(matrix: Matrix3, tolerance: float = ROTATION_TOLERANCE) -> bool:
    """Tell whether a matrix is a rotation. Raises as `rotation_flaws` does."""
    return not rotation_flaws(matrix, tolerance)


def check_rotation(matrix: Matrix3, tolerance: float = ROTATION_TOLERANCE) -> Matrix3:
    """Return the matrix in floats, or raise `NotARotation` with everything that is wrong."""
    matrix = finite_matrix(matrix)
    if not _plainly_rotation(matrix, tolerance):
        flaws = rotation_flaws(matrix, tolerance)
        if flaws:
            raise NotARotation(flaws)
    return matrix


def check_transform(frame: Transform, tolerance: float = ROTATION_TOLERANCE) -> Transform:
    """Return the transform in floats, or raise an error that says what is wrong with it.

    Raises `NotARotation` for its rotation part, `BadNumber` for what is not finite, and
    `KinematicsError` for a wrong shape or another last row than 0, 0, 0, 1.
    """
    _check_shape(frame, 4)
    if tuple(frame[3]) != LAST_ROW:
        raise KinematicsError(
            f"the last row of a homogeneous transform is 0, 0, 0, 1, not {tuple(frame[3])}"
        )
    x, y, z = position_of(frame)
    position = finite("x_mm", x), finite("y_mm", y), finite("z_mm", z)
    return transform(check_rotation(rotation_of(frame), tolerance), position)


def rotation_flaws(
    matrix: Matrix3, tolerance: float = ROTATION_TOLERANCE
) -> tuple[RotationFlaw, ...]:
    """Return every property of rotations that the matrix lacks; none for a rotation.

    Raises `BadNumber` for entries that are not finite numbers, and `KinematicsError` for another
    shape than three rows of three.
    """
    return tuple(_flaws(finite_matrix(matrix), tolerance))


def finite_matrix(matrix: Matrix3) -> Matrix3:
    """Return the matrix in floats; raises as `rotation_flaws` does."""
    _check_shape(matrix, 3)
    first, second, third = (
        (finite(f"row {row}, x", x), finite(f"row {row}, y", y), finite(f"row {row}, z", z))
        for row, (x, y, z) in enumerate(matrix, start=1)
    )
    return first, second, third


def _check_shape(rows: Sequence[Sequence[float]], size: int) -> None:
    if len(rows) != size or any(len(row) != size for row in rows):
        raise KinematicsError(f"{size} rows of {size} numbers are needed, not {rows!r}")


def _plainly_rotation(matrix: Matrix3, tolerance: float) -> bool:
    """Tell by products alone, which is quicker than the lengths and angles of the verdict."""
    x, y, z = columns(matrix)
    return (
        max(abs(dot(x, x) - 1.0), abs(dot(y, y) - 1.0), abs(dot(z, z) - 1.0)) <= tolerance
        and max(abs(dot(x, y)), abs(dot(y, z)), abs(dot(z, x))) <= tolerance / 2.0
        and determinant(matrix) > 0.0
    )


def _flaws(matrix: Matrix3, tolerance: float) -> Iterator[RotationFlaw]:
    named = dict(zip("xyz", columns(matrix), strict=True))
    for name, column in named.items():
        excess = norm(column) - 1.0
        if abs(excess) > tolerance:
            yield RotationFlaw(RotationProperty.UNIT_COLUMNS, name, excess)
    for first, second in combinations(named, 2):
        slant = _slant(named[first], named[second])
        if abs(slant) > tolerance:
            yield RotationFlaw(RotationProperty.NORMAL_COLUMNS, f"{first} and {second}", slant)
    volume = determinant(matrix)
    if volume < 0.0:
        yield RotationFlaw(RotationProperty.RIGHT_HANDED, "x, y and z", volume)


def _slant(u: Vector, v: Vector) -> float:
    """Return the angle beyond a right one; a zero vector is normal to everything."""
    if norm(u) == 0.0 or norm(v) == 0.0:
        return 0.0
    return angle_between(u, v) - math.pi / 2.0
