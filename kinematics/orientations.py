"""Orientations in every representation, from one place: three angles, axis and angle, quaternion.

Each has a `rotation()`, and a `solve_...` that takes a rotation matrix back to it, gives both
answers, and names the orientation at which it is degenerate.
"""

from kinematics.axis_angle import AxisAngle, rotation_vector, solve_axis_angle, turn_between
from kinematics.orientation_angles import RPY, EulerZYZ, solve_euler, solve_rpy
from kinematics.orientation_solution import DEGENERATE_RAD, Degeneracy, OrientationSolution
from kinematics.quaternions import Quaternion, quaternion_of, solve_quaternion

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
