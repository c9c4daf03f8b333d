"""Rotation matrices: ROTX, ROTY, ROTZ, products, inverses (chapter 2, sections 2.2, 2.3 and 2.6).

A `Matrix3` is three rows of three. A rotation M of a frame R1 in a frame R0 holds R1's unit
vectors, observed in R0, as its columns, and turns a vector observed in R1 into the same vector
observed in R0 (equation 2.21). Angles in rad, right-handed. Works on any kind of number; a plain
angle that is not finite raises `BadNumber`.
"""

from __future__ import annotations

from collections.abc import Sequence

from kinematics.frames.numbers import cos, number, sin
from kinematics.frames.vectors import Vector, dot, triple

Matrix3 = tuple[Vector, Vector, Vector]

IDENTITY: Matrix3 = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def rot_x(angle_rad: float) -> Matrix3:
    """Return ROTX, the rotation about the X axis (equation 2.14)."""
    c, s = _cos_sin(angle_rad)
    return (1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c)


def rot_y(angle_rad: float) -> Matrix3:
    """Return ROTY, the rotation about the Y axis (equation 2.15)."""
    c, s = _cos_sin(angle_rad)
    return (c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)


def rot_z(angle_rad: float) -> Matrix3:
    """Return ROTZ, the rotation about the Z axis (section 2.2)."""
    c, s = _cos_sin(angle_rad)
    return (c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)


def _cos_sin(angle_rad: float) -> tuple[float, float]:
    angle = number("angle_rad", angle_rad)
    return cos(angle), sin(angle)


def columns(matrix: Matrix3) -> Matrix3:
    """Return the three columns: the turned frame's X, Y and Z (equation 2.42)."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return (a, d, g), (b, e, h), (c, f, i)


def from_columns(x: Vector, y: Vector, z: Vector) -> Matrix3:
    """Return the matrix of three columns, whatever they are."""
    return columns((x, y, z))


def transpose(matrix: Matrix3) -> Matrix3:
    """Return the transpose, which is the inverse of a rotation (equation 2.17)."""
    return columns(matrix)


def multiply(*matrices: Matrix3) -> Matrix3:
    """Return the ordered product of any number of matrices; of none, the identity.

    Read from the left, each factor turns about the axes that the ones before it have turned
    (equation 2.44); read from the right, about the fixed axes. The order matters (2.25, 2.26).
    """
    if not matrices:
        return IDENTITY
    product = matrices[0]
    for factor in matrices[1:]:
        product = _product(product, factor)
    return product


def _product(left: Matrix3, right: Matrix3) -> Matrix3:
    """Return the product written out, which is several times as fast as loops."""
    (a, b, c), (d, e, f), (g, h, i) = left
    (m, n, o), (p, q, r), (s, t, u) = right
    return (
        (a * m + b * p + c * s, a * n + b * q + c * t, a * o + b * r + c * u),
        (d * m + e * p + f * s, d * n + e * q + f * t, d * o + e * r + f * u),
        (g * m + h * p + i * s, g * n + h * q + i * t, g * o + h * r + i * u),
    )


def rotate(matrix: Matrix3, vector: Vector) -> Vector:
    """Return the matrix times a vector: observed in R1, now observed in R0 (equation 2.21).

    With the transpose it is the way back; the notes' line for that prints R_R1 instead of U_R1.
    """
    first, second, third = matrix
    return dot(first, vector), dot(second, vector), dot(third, vector)


def determinant(matrix: Matrix3) -> float:
    """Return the determinant: 1 of every rotation (equation 2.45), -1 of every reflection."""
    return triple(*matrix)


def rotation_between(steps: Sequence[Matrix3], start: int, end: int) -> Matrix3:
    """Return M of frame `end` in frame `start` from the steps M of each frame i + 1 in frame i.

    A chain of n steps joins the frames 0 to n. Forwards it is the product (equation 2.44),
    backwards its transpose (2.46 and 2.47; the third line of 2.46 leaves an exponent -1 on its
    first factor), from a frame to itself the identity. Raises IndexError for a frame that the
    chain has not.
    """
    if not (0 <= start <= len(steps) and 0 <= end <= len(steps)):
        raise IndexError(f"the chain joins frames 0 to {len(steps)}, not {start} to {end}")
    if end < start:
        return transpose(multiply(*steps[end:start]))
    return multiply(*steps[start:end])
