"""Vectors of three dimensions as plain tuples: products, lengths, angles.

A `Vector` is (x, y, z) in any one unit. Sums and products work on any kind of number; whatever
needs a direction raises `ZeroVector` where there is none. Equations are those of chapter 2,
"Vectors and frames", section 2.1.
"""

from __future__ import annotations

import math

from kinematics.errors import ZeroVector
from kinematics.frames.numbers import atan2, sqrt

Vector = tuple[float, float, float]

ZERO: Vector = (0.0, 0.0, 0.0)
X_AXIS: Vector = (1.0, 0.0, 0.0)
Y_AXIS: Vector = (0.0, 1.0, 0.0)
Z_AXIS: Vector = (0.0, 0.0, 1.0)


def add(u: Vector, v: Vector) -> Vector:
    """Return u + v."""
    return u[0] + v[0], u[1] + v[1], u[2] + v[2]


def subtract(u: Vector, v: Vector) -> Vector:
    """Return u - v, the vector that leads from v to u."""
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def scale(factor: float, u: Vector) -> Vector:
    """Return `factor` times u."""
    return factor * u[0], factor * u[1], factor * u[2]


def dot(u: Vector, v: Vector) -> float:
    """Return the scalar product, |u| |v| cos of the angle between them (equation 2.7)."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def cross(u: Vector, v: Vector) -> Vector:
    """Return u x v, normal to both in the right-handed sense (equation 2.9)."""
    return (
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    )


def triple(u: Vector, v: Vector, w: Vector) -> float:
    """Return u . (v x w), the signed volume that three vectors span: positive if right-handed."""
    return dot(u, cross(v, w))


def norm(u: Vector) -> float:
    """Return the length of u (equation 2.6)."""
    if all(isinstance(component, float | int) for component in u):
        return math.hypot(*u)  # neither overflows nor underflows on the way
    length: float = sqrt(dot(u, u))
    return length


def distance(u: Vector, v: Vector) -> float:
    """Return the length of u - v."""
    return norm(subtract(u, v))


def unit(u: Vector) -> Vector:
    """Return u at length 1. Raises `ZeroVector` for the zero vector."""
    length = norm(u)
    if length == 0.0:
        raise ZeroVector
    return u[0] / length, u[1] / length, u[2] / length


def angle_between(u: Vector, v: Vector) -> float:
    """Return the angle from 0 to pi between two directions, in rad.

    From sine and cosine together (equations 2.7 and 2.10), since the arc cosine alone loses half
    the digits near 0 and near pi. Raises `ZeroVector` where either has no direction.
    """
    u, v = unit(u), unit(v)
    angle: float = atan2(norm(cross(u, v)), dot(u, v))
    return angle


def project(u: Vector, onto: Vector) -> Vector:
    """Return the part of u along a direction. Raises `ZeroVector` for no direction."""
    axis = unit(onto)
    return scale(dot(u, axis), axis)


def reject(u: Vector, direction: Vector) -> Vector:
    """Return the part of u normal to a direction. Raises `ZeroVector` for no direction."""
    return subtract(u, project(u, direction))


def any_normal(u: Vector) -> Vector:
    """Return one of the unit vectors normal to u, always the same one for the same u.

    It is the cross product with the axis that u leans to least. Raises `ZeroVector`.
    """
    sizes = [abs(component) for component in u]
    least = sizes.index(min(sizes))
    return unit(cross(unit(u), (X_AXIS, Y_AXIS, Z_AXIS)[least]))
