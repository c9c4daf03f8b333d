"""Frames in frames: homogeneous transforms, and whether a matrix is a rotation.

A `Transform` holds rotation and position in one (chapter 2, section 2.4): a 4x4 matrix of plain
numbers, four rows, the last one 0, 0, 0, 1; positions in mm, angles in rad. The transform T of a
frame R1 in a frame R0 takes a point observed in R1 to the same point observed in R0, as O0A = O0O1
+ M O1A (equation 2.27). Works on any kind of number.

`transform`, `invert` and whatever else takes a frame from a caller check it, by `check_rotation`
and `check_transform`. `homogeneous` and `inverted` do the same unchecked, for frames that this
library has computed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import cast

from kinematics.errors import (
    KinematicsError,
    NotARotation,
)
from kinematics.frames.numbers import as_list, number, numbers
from kinematics.frames.rotations import (
    IDENTITY,
    Matrix3,
    columns,
    determinant,
    rotate,
    transpose,
)
from kinematics.frames.vectors import (
    Vector,
    add,
    angle_between,
    norm,
    scale,
)

Row4 = tuple[float, float, float, float]
Transform = tuple[Row4, Row4, Row4, Row4]

LAST_ROW: Row4 = (0.0, 0.0, 0.0, 1.0)
# The identity: a frame that coincides with its reference.
IN_PLACE: Transform = (
    (1.0, 0.0, 0.0, 0.0),
    (0.0, 1.0, 0.0, 0.0),
    (0.0, 0.0, 1.0, 0.0),
    LAST_ROW,
)


def transform(rotation: Matrix3, position: Vector) -> Transform:
    """Return the transform of a frame turned by `rotation` with its origin at `position`.

    Raises as `check_transform` does.
    """
    return homogeneous(check_rotation(rotation), _checked_position(position))


def homogeneous(rotation: Matrix3, position: Vector) -> Transform:
    """Return what `transform` does; nothing is checked."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    x, y, z = position
    return (a, b, c, x), (d, e, f, y), (g, h, i, z), LAST_ROW


def translation(x: float, y: float, z: float) -> Transform:
    """Return the transform of a frame that is moved and not turned."""
    return homogeneous(IDENTITY, _checked_position((x, y, z)))


def rotation_of(frame: Transform) -> Matrix3:
    """Return the rotation part: the frame's unit vectors as columns."""
    (a, b, c, _), (d, e, f, _), (g, h, i, _), _ = frame
    return (a, b, c), (d, e, f), (g, h, i)


def position_of(frame: Transform) -> Vector:
    """Return the position part: the frame's origin."""
    return frame[0][3], frame[1][3], frame[2][3]


def z_axis_of(frame: Transform) -> Vector:
    """Return the frame's z axis: of a hand's frame, its approach."""
    return frame[0][2], frame[1][2], frame[2][2]


def compose(*frames: Transform) -> Transform:
    """Return the product of a chain of transforms, each in the one before it; of none, identity.

    Only the affine part is multiplied out, since the last row stays what it is.
    """
    if not frames:
        return IN_PLACE
    product = frames[0]
    for factor in frames[1:]:
        product = _product(product, factor)
    return product


def _product(left: Transform, right: Transform) -> Transform:
    """Return the product written out, which is twice as fast as one of vectors and matrices."""
    (a, b, c, x), (d, e, f, y), (g, h, i, z), _ = left
    (m, n, o, ahead), (p, q, r, aside), (s, t, u, up), _ = right
    return (
        (
            a * m + b * p + c * s,
            a * n + b * q + c * t,
            a * o + b * r + c * u,
            x + (a * ahead + b * aside + c * up),
        ),
        (
            d * m + e * p + f * s,
            d * n + e * q + f * t,
            d * o + e * r + f * u,
            y + (d * ahead + e * aside + f * up),
        ),
        (
            g * m + h * p + i * s,
            g * n + h * q + i * t,
            g * o + h * r + i * u,
            z + (g * ahead + h * aside + i * up),
        ),
        LAST_ROW,
    )


def invert(frame: Transform) -> Transform:
    """Return the inverse: the reference observed from the frame (equations 2.17 and 2.27).

    Raises as `check_transform` does: a matrix that is no rotation has another inverse.
    """
    return inverted(check_transform(frame))


def inverted(frame: Transform) -> Transform:
    """Return what `invert` does, the rotation transposed; nothing is checked."""
    back = transpose(rotation_of(frame))
    return homogeneous(back, scale(-1.0, rotate(back, position_of(frame))))


def transform_point(frame: Transform, point: Vector) -> Vector:
    """Return a point observed in a frame as observed in its reference (equation 2.27)."""
    return add(position_of(frame), rotate(rotation_of(frame), point))


def transform_vector(frame: Transform, vector: Vector) -> Vector:
    """Return a free vector, one with a direction and no place, as observed in the reference."""
    return rotate(rotation_of(frame), vector)


# Is a matrix a rotation? If not, which of the properties of chapter 2, section 2.3 fails, and by
# how much: columns of length 1, normal to each other, and a determinant of 1.

# How far lengths (of 1) and angles (rad) may be off: above rounding, below any arm's accuracy.
ROTATION_TOLERANCE = 1e-9


def check_rotation(matrix: Matrix3) -> Matrix3:
    """Return the matrix in floats, or raise `NotARotation` with everything that is wrong.

    Numbers of another kind, such as symbols, have no size: a matrix with such entries is returned
    as it is. Raises `BadNumber` for entries that are not finite numbers, and `KinematicsError` for
    another shape than three rows of three.
    """
    matrix = finite_matrix(matrix)
    flaws = tuple(_flaws(matrix)) if _are_floats(matrix) else ()
    if flaws:
        raise NotARotation(flaws)
    return matrix


def check_transform(frame: Transform) -> Transform:
    """Return the transform in floats, or raise an error that says what is wrong with it.

    Raises `NotARotation` for its rotation part, `BadNumber` for what is not finite, and
    `KinematicsError` for a wrong shape or another last row than 0, 0, 0, 1.
    """
    rows = cast(Transform, _rows(frame, 4))
    if rows[3] != LAST_ROW:
        raise KinematicsError(
            f"the last row of a homogeneous transform is 0, 0, 0, 1, not {rows[3]}"
        )
    rotation = check_rotation(rotation_of(rows))
    return homogeneous(rotation, _checked_position(position_of(rows)))


def _checked_position(position: Sequence[float]) -> Vector:
    x, y, z = numbers("a position", position, ("x_mm", "y_mm", "z_mm"))
    return x, y, z


def finite_matrix(matrix: Matrix3) -> Matrix3:
    """Return the matrix in floats; raises as `check_rotation` does."""
    rows = cast(Matrix3, _rows(matrix, 3))
    if _are_floats(rows):
        return rows
    first, second, third = (
        (number(f"row {row}, x", x), number(f"row {row}, y", y), number(f"row {row}, z", z))
        for row, (x, y, z) in enumerate(rows, start=1)
    )
    return first, second, third


def _rows(matrix: Sequence[Sequence[float]], size: int) -> tuple[tuple[float, ...], ...]:
    """Return the rows of a square matrix, or raise `KinematicsError` for another shape."""
    if type(matrix) is not tuple or not all(type(row) is tuple for row in matrix):
        rows = tuple(as_list(row) or () for row in as_list(matrix) or ())
    else:
        rows = matrix
    if len(rows) != size or any(len(row) != size for row in rows):
        raise KinematicsError(f"{size} rows of {size} numbers are needed, not {matrix!r}")
    return rows


def _are_floats(rows: Sequence[Sequence[float]]) -> bool:
    """Return whether all entries are floats, and finite."""
    for row in rows:
        for entry in row:
            if type(entry) is not float or entry - entry != 0.0:
                return False
    return True


def _flaws(matrix: Matrix3) -> Iterator[str]:
    """Yield every property of rotations that the matrix lacks, in words."""
    named = dict(zip("xyz", columns(matrix), strict=True))
    for name, column in named.items():
        length = norm(column)
        if abs(length - 1.0) > ROTATION_TOLERANCE:
            yield f"column {name} has length {length:.9g} instead of 1"
    for first, second in combinations(named, 2):
        slant = _slant(named[first], named[second])
        if abs(slant) > ROTATION_TOLERANCE:
            angle_deg = 90.0 + math.degrees(slant)
            yield f"columns {first} and {second} stand at {angle_deg:.9g}° instead of 90°"
    volume = determinant(matrix)
    if volume < 0.0:
        yield f"the determinant is {volume:.9g} instead of 1: the axes are left-handed"


def _slant(u: Vector, v: Vector) -> float:
    """Return the angle beyond a right one; a zero vector is normal to everything."""
    if norm(u) == 0.0 or norm(v) == 0.0:
        return 0.0
    return angle_between(u, v) - math.pi / 2.0
