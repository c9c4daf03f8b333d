"""Orientations in every representation, from one place: three angles, axis and angle, quaternion.

Each has a `rotation()`, and a `solve_...` that takes a rotation matrix back to it, gives both
answers, and names the orientation at which it is degenerate. `RPY(phi, theta, psi)` is Rot(z, phi)
Rot(y, theta) Rot(x, psi), the orientation transform of McKerrow, chapter 4, section 9; solving it
for the angles is section 10. Angles in rad; solutions are from -pi (excluded) to pi.

Three angles are solved as the notes solve matrix equations: the first rotation is found from the
axis that the other two leave in place, both sides are multiplied from the left by its inverse, and
the remaining product of two rotations gives the other angles. So the answer makes the matrix again
to the last digits even next to a degenerate orientation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinematics.frames.quaternions import (
    DEGENERATE_RAD,
    AxisAngle,
    Degeneracy,
    OrientationSolution,
    Quaternion,
    quaternion_of,
    rotation_vector,
    solve_axis_angle,
    solve_quaternion,
    turn_between,
)
from kinematics.frames.rotations import Matrix3, columns, multiply, rot_x, rot_y, rot_z
from kinematics.frames.transforms import check_rotation
from kinematics.limits import wrap


@dataclass(frozen=True, slots=True)
class RPY:
    """Roll phi about z, pitch theta about the turned y, yaw psi about the twice turned x; rad."""

    phi_rad: float
    theta_rad: float
    psi_rad: float

    def rotation(self) -> Matrix3:
        """Return the rotation matrix Rot(z, phi) Rot(y, theta) Rot(x, psi)."""
        return multiply(rot_z(self.phi_rad), rot_y(self.theta_rad), rot_x(self.psi_rad))


@dataclass(frozen=True, slots=True)
class EulerZYZ:
    """Turn phi about z, tilt theta about the turned y, turn psi about the tilted z; rad."""

    phi_rad: float
    theta_rad: float
    psi_rad: float

    def rotation(self) -> Matrix3:
        """Return the rotation matrix Rot(z, phi) Rot(y, theta) Rot(z, psi)."""
        return multiply(rot_z(self.phi_rad), rot_y(self.theta_rad), rot_z(self.psi_rad))


def solve_rpy(matrix: Matrix3, held_phi_rad: float = 0.0) -> OrientationSolution[RPY]:
    """Return the roll, pitch and yaw of a rotation, the first ones with theta within a right angle.

    With theta at a right angle (`Degeneracy.X_AXIS_DOWN` or `X_AXIS_UP`), phi is given the held
    value and psi follows. Raises `NotARotation`.
    """
    matrix = check_rotation(matrix)
    across, aside, upwards = columns(matrix)[0]
    degenerate = math.hypot(across, aside) <= DEGENERATE_RAD
    phi = held_phi_rad if degenerate else _direction(aside, across)
    rest = multiply(rot_z(-phi), matrix)  # Rot(y, theta) Rot(x, psi)
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
    matrix = check_rotation(matrix)
    across, aside, upwards = columns(matrix)[2]
    degenerate = math.hypot(across, aside) <= DEGENERATE_RAD
    phi = held_phi_rad if degenerate else _direction(aside, across)
    rest = multiply(rot_z(-phi), matrix)  # Rot(y, theta) Rot(z, psi)
    psi = _direction(rest[1][0], rest[1][1])
    if degenerate:
        kind = Degeneracy.NO_TILT if upwards > 0.0 else Degeneracy.FULL_TILT
        tilt = 0.0 if upwards > 0.0 else math.pi
        return OrientationSolution(EulerZYZ(phi, tilt, psi), None, kind)
    theta = math.atan2(rest[0][2], rest[2][2])
    other = EulerZYZ(wrap(phi + math.pi), -theta, wrap(psi + math.pi))
    return OrientationSolution(EulerZYZ(phi, theta, psi), other, None)


def _direction(across: float, along: float) -> float:
    """Return the angle from -pi (excluded) to pi, the same for zeros of either sign."""
    return wrap(math.atan2(across, along)) + 0.0


__all__ = [
    "DEGENERATE_RAD",
    "RPY",
    "AxisAngle",
    "Degeneracy",
    "EulerZYZ",
    "OrientationSolution",
    "Quaternion",
    "quaternion_of",
    "rotation_vector",
    "solve_axis_angle",
    "solve_euler",
    "solve_quaternion",
    "solve_rpy",
    "turn_between",
]
