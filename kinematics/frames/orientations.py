"""Orientations in every representation, from one place: three angles, axis and angle, quaternion.

Each representation has a `rotation()`, and a `solve_...` function that converts a rotation matrix
back, returns both solutions, and names the orientation at which the representation is degenerate.
`RPY(phi, theta, psi)` is Rot(z, phi) Rot(y, theta) Rot(x, psi), the orientation transform of
McKerrow, chapter 4, section 9; section 10 solves it for the angles. Angles are in rad; solutions
are from -pi (excluded) to pi.

Three angles are solved as the notes solve matrix equations: the first rotation is found from the
axis that the other two leave in place, both sides are multiplied from the left by its inverse, and
the remaining product of two rotations gives the other angles. So the solution reproduces the matrix
to the last digits even next to a degenerate orientation.

Quaternions are Hamilton's, scalar first. Sources: J. J. Craig, "Introduction to Robotics", section
2.8 (Euler parameters, axis and angle); S. W. Shepperd, "Quaternion from rotation matrix", 1978, for
the conversion that divides by no small number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar

from kinematics.errors import (
    ZeroVector,
    check_fields,
)
from kinematics.frames.numbers import cos, number, numbers, sin
from kinematics.frames.rotations import Matrix3, columns, multiply, rot_x, rot_y, rot_z
from kinematics.frames.transforms import ROTATION_TOLERANCE, check_rotation
from kinematics.frames.vectors import Z_AXIS, ZERO, Vector, add, cross, dot, norm, scale, unit
from kinematics.limits import wrap

# Within this angle of a degenerate orientation the entries of a matrix tell only its noise.
DEGENERATE_RAD = ROTATION_TOLERANCE


class Degeneracy(Enum):
    """Orientations at which a representation is not unique, and what remains determined."""

    X_AXIS_DOWN = "theta is 90°, the turned x axis points at -z: only phi - psi is determined"
    X_AXIS_UP = "theta is -90°, the turned x axis points at +z: only phi + psi is determined"
    NO_TILT = "theta is 0°, the z axes agree: only phi + psi is determined"
    FULL_TILT = "theta is 180°, the z axes oppose: only phi - psi is determined"
    NO_TURN = "the angle is 0°: every axis does"
    HALF_TURN = "the angle is 180°: an axis and its opposite are the same turn"


Representation = TypeVar("Representation")


@dataclass(frozen=True, slots=True)
class OrientationSolution(Generic[Representation]):
    """The answers to one rotation.

    `first` is in the usual range that its maker states, `second` the other one that makes the
    same matrix, None where there are endlessly many. `degeneracy` is None where the answers are
    all there are; else `first` holds what was asked to be held, and the answer stands for a
    family.
    """

    first: Representation
    second: Representation | None
    degeneracy: Degeneracy | None


@dataclass(frozen=True, slots=True)
class Quaternion:
    """w + x i + y j + z k of length 1: cos of half the angle, and sin of it along the axis.

    Four numbers of any length are scaled to it. Raises `ZeroVector` where all are zero, `BadNumber`
    for what is not finite. `a * b` turns by b and then by a, both about fixed axes, like the
    product of their matrices.
    """

    w: float
    x: float
    y: float
    z: float

    def __post_init__(self) -> None:
        parts = numbers("a quaternion", (self.w, self.x, self.y, self.z), "wxyz")
        length = math.hypot(*parts)
        if length == 0.0:
            raise ZeroVector
        for name, part in zip("wxyz", parts, strict=True):
            object.__setattr__(self, name, part / length)

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
        return Quaternion(w, x, y, z)  # scaled, so that long products do not drift

    def __neg__(self) -> Quaternion:
        return Quaternion(-self.w, -self.x, -self.y, -self.z)

    def inverse(self) -> Quaternion:
        """Return the conjugate, which turns back."""
        return Quaternion(self.w, -self.x, -self.y, -self.z)

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
            return Quaternion(squares[0], h - f, c - g, d - b)
        case 1:
            return Quaternion(h - f, squares[1], b + d, c + g)
        case 2:
            return Quaternion(c - g, b + d, squares[2], f + h)
        case _:
            return Quaternion(d - b, c + g, f + h, squares[3])


# Orientation by an axis and an angle: every rotation is one turn about one axis (Euler's theorem).


@dataclass(frozen=True, slots=True)
class AxisAngle:
    """A turn by an angle in rad, right-handed about an axis, which is scaled to length 1.

    Raises `ZeroVector` for an axis without a direction, and as `numbers` does.
    """

    axis: Vector
    angle_rad: float

    def __post_init__(self) -> None:
        x, y, z = numbers("an axis", self.axis, "xyz")
        object.__setattr__(self, "axis", unit((x, y, z)))
        object.__setattr__(self, "angle_rad", number("angle_rad", self.angle_rad))

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
    """Return the axis times the angle in rad, exact for the smallest turns.

    The matrix is taken to be a rotation; it is not checked, because descents call this at every
    step.
    """
    (a, b, c), (d, e, f), (g, h, i) = matrix
    x, y, z = 0.5 * (h - f), 0.5 * (c - g), 0.5 * (d - b)
    sine, cosine = math.hypot(x, y, z), 0.5 * (a + e + i - 1.0)
    if sine == 0.0 and cosine > 0.0:
        return ZERO
    if sine <= SPLIT_SINE and cosine <= 0.0:
        turn = quaternion_of(matrix)
        x, y, z = turn.vector if turn.w >= 0.0 else scale(-1.0, turn.vector)
        sine = math.hypot(x, y, z)
        return scale(2.0 * math.atan2(sine, abs(turn.w)) / sine, (x, y, z))
    return scale(math.atan2(sine, cosine) / sine, (x, y, z))


# Sine of an angle below which, near half a turn, the sine no longer gives the axis.
SPLIT_SINE = 1e-3


def turn_between(first: Matrix3, second: Matrix3) -> float:
    """Return the angle from 0 to pi, in rad, that turns one rotation into another.

    The two are taken to be rotations; they are not checked.
    """
    turn = quaternion_of(first).inverse() * quaternion_of(second)
    return 2.0 * math.atan2(norm(turn.vector), abs(turn.w))


# Three angles: roll, pitch and yaw, and Euler's z-y-z.


@dataclass(frozen=True, slots=True)
class _ThreeAngles:
    """Turns by phi about z, by theta about the turned y, and by psi; raises `BadNumber`."""

    phi_rad: float
    theta_rad: float
    psi_rad: float

    def __post_init__(self) -> None:
        check_fields(self, number, "phi_rad", "theta_rad", "psi_rad")


class RPY(_ThreeAngles):
    """Roll phi about z, pitch theta about the turned y, yaw psi about the twice turned x; rad."""

    __slots__ = ()

    def rotation(self) -> Matrix3:
        """Return the rotation matrix Rot(z, phi) Rot(y, theta) Rot(x, psi)."""
        return multiply(rot_z(self.phi_rad), rot_y(self.theta_rad), rot_x(self.psi_rad))


class EulerZYZ(_ThreeAngles):
    """Turn phi about z, tilt theta about the turned y, turn psi about the tilted z; rad."""

    __slots__ = ()

    def rotation(self) -> Matrix3:
        """Return the rotation matrix Rot(z, phi) Rot(y, theta) Rot(z, psi)."""
        return multiply(rot_z(self.phi_rad), rot_y(self.theta_rad), rot_z(self.psi_rad))


def solve_rpy(matrix: Matrix3, held_phi_rad: float = 0.0) -> OrientationSolution[RPY]:
    """Return the roll, pitch and yaw of a rotation, the first ones with theta within a right angle.

    With theta at a right angle (`Degeneracy.X_AXIS_DOWN` or `X_AXIS_UP`), phi is given the held
    value and psi follows. Raises `NotARotation`.
    """
    phi, rest, upwards, degenerate = _without_phi(matrix, 0, held_phi_rad)
    psi = _direction(-rest[1][2], rest[1][1])
    if degenerate:
        kind = Degeneracy.X_AXIS_UP if upwards > 0.0 else Degeneracy.X_AXIS_DOWN
        return OrientationSolution(RPY(phi, math.copysign(math.pi / 2, -upwards), psi), None, kind)
    theta = math.atan2(-rest[2][0], rest[0][0])
    other = RPY(wrap(phi + math.pi), wrap(math.pi - theta), wrap(psi + math.pi))
    return OrientationSolution(RPY(phi, theta, psi), other, None)


def solve_euler(matrix: Matrix3, held_phi_rad: float = 0.0) -> OrientationSolution[EulerZYZ]:
    """Return the Euler z-y-z angles of a rotation, the first ones with theta from 0 to pi.

    With theta at 0 or pi (`Degeneracy.NO_TILT` or `FULL_TILT`), phi is given the held value and
    psi follows. Raises `NotARotation`.
    """
    phi, rest, upwards, degenerate = _without_phi(matrix, 2, held_phi_rad)
    psi = _direction(rest[1][0], rest[1][1])
    if degenerate:
        kind = Degeneracy.NO_TILT if upwards > 0.0 else Degeneracy.FULL_TILT
        tilt = 0.0 if upwards > 0.0 else math.pi
        return OrientationSolution(EulerZYZ(phi, tilt, psi), None, kind)
    theta = math.atan2(rest[0][2], rest[2][2])
    other = EulerZYZ(wrap(phi + math.pi), -theta, wrap(psi + math.pi))
    return OrientationSolution(EulerZYZ(phi, theta, psi), other, None)


def _without_phi(
    matrix: Matrix3, axis: int, held_phi_rad: float
) -> tuple[float, Matrix3, float, bool]:
    """Return phi, the rest Rot(y, theta) Rot(axis, psi), that axis's z, and whether it is upright.

    Upright, it leaves phi at the held value.
    """
    held = number("held_phi_rad", held_phi_rad)
    matrix = check_rotation(matrix)
    across, aside, upwards = columns(matrix)[axis]
    degenerate = math.hypot(across, aside) <= DEGENERATE_RAD
    phi = held if degenerate else _direction(aside, across)
    return phi, multiply(rot_z(-phi), matrix), upwards, degenerate


def _direction(across: float, along: float) -> float:
    """Return the angle from -pi (excluded) to pi, the same for zeros of either sign."""
    return wrap(math.atan2(across, along)) + 0.0
