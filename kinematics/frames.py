"""Frames in frames: homogeneous transforms, rotation and position in one (chapter 2, section 2.4).

A `Transform` is a 4x4 matrix of plain numbers, four rows, the last one 0, 0, 0, 1; positions in
mm. The transform T of a frame R1 in a frame R0 takes a point observed in R1 to the same point
observed in R0, as O0A = O0O1 + M O1A (equation 2.27). Works on any kind of number.
"""

from __future__ import annotations

from kinematics.rotations import IDENTITY, Matrix3, multiply, rotate, transpose
from kinematics.vectors import Vector, add, scale

Row4 = tuple[float, float, float, float]
Transform = tuple[Row4, Row4, Row4, Row4]

LAST_ROW: Row4 = (0.0, 0.0, 0.0, 1.0)
IN_PLACE: Transform = (
    (1.0, 0.0, 0.0, 0.0),
    (0.0, 1.0, 0.0, 0.0),
    (0.0, 0.0, 1.0, 0.0),
    LAST_ROW,
)
"""The identity: a frame that coincides with its reference."""


def transform(rotation: Matrix3, position: Vector) -> Transform:
    """Return the transform of a frame turned by `rotation` with its origin at `position`."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    x, y, z = position
    return (a, b, c, x), (d, e, f, y), (g, h, i, z), LAST_ROW


def translation(x: float, y: float, z: float) -> Transform:
    """Return the transform of a frame that is moved and not turned."""
    return transform(IDENTITY, (x, y, z))


def rotation_of(frame: Transform) -> Matrix3:
    """Return the rotation part: the frame's unit vectors as columns."""
    (a, b, c, _), (d, e, f, _), (g, h, i, _), _ = frame
    return (a, b, c), (d, e, f), (g, h, i)


def position_of(frame: Transform) -> Vector:
    """Return the position part: the frame's origin."""
    return frame[0][3], frame[1][3], frame[2][3]


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
    rotation = rotation_of(left)
    turned = multiply(rotation, rotation_of(right))
    return transform(turned, add(position_of(left), rotate(rotation, position_of(right))))


def moved_in_itself(frame: Transform, motion: Transform) -> Transform:
    """Return a frame after a motion along and about its own axes, as they are now (section 2.3)."""
    return compose(frame, motion)


def moved_in_reference(frame: Transform, motion: Transform) -> Transform:
    """Return a frame after a motion along and about the axes of the frame it is observed in."""
    return compose(motion, frame)


def invert(frame: Transform) -> Transform:
    """Return the inverse: the reference observed from the frame (equations 2.17 and 2.27).

    The rotation is transposed, so what is no rotation is not inverted; see `check_transform`.
    """
    back = transpose(rotation_of(frame))
    return transform(back, scale(-1.0, rotate(back, position_of(frame))))


def transform_point(frame: Transform, point: Vector) -> Vector:
    """Return a point observed in a frame as observed in its reference (equation 2.27)."""
    return add(position_of(frame), rotate(rotation_of(frame), point))


def transform_vector(frame: Transform, vector: Vector) -> Vector:
    """Return a free vector, one with a direction and no place, as observed in the reference."""
    return rotate(rotation_of(frame), vector)
