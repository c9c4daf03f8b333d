"""The mathematics of the arm: poses, joint angles, motor steps, and the way between them.

Units: mm, rad, whole motor steps. Everything named here is plain Python. What every program
needs is imported at once; the textbook (frames, chains, named systems) when a name of it is first
used, so that the command line starts quickly.
"""

from __future__ import annotations

from types import MappingProxyType

from kinematics.errors import (
    BadNumber,
    Constraint,
    FlatBasis,
    FramesDisagree,
    FramesNotConnected,
    JointLimit,
    KinematicsError,
    NoNearestRotation,
    NotARotation,
    NotAUnitQuaternion,
    OutOfReach,
    PathBroken,
    RotationFlaw,
    RotationProperty,
    SingularTransmission,
    UnknownFrame,
    UnknownPreset,
    UnknownSystem,
    Unreachable,
    ZeroVector,
)
from kinematics.escape import nearest_allowed
from kinematics.five_axis import Base, Branch, Elbow, FiveAxisArm, RollFrame
from kinematics.guards import Guards, GuardViolation
from kinematics.limits import JointRange, LimitViolation
from kinematics.nearest import Nearest, nearest
from kinematics.paths import JointPath, deviation_mm, first_violation, joint_path, line_path
from kinematics.presets import PRESETS, ArmPreset, Reference, cable_transmission, preset
from kinematics.spaces import JOINT_NAMES, Joints, Motors, Pose
from kinematics.transmission import MotorSpec, Transmission

TYPE_CHECKING = False  # as typing's
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from kinematics.bases import Handedness, basis_along, change_of_basis, handedness, third_axis
    from kinematics.frame_graph import FrameGraph, solve_loop
    from kinematics.frames import (
        Transform,
        compose,
        invert,
        position_of,
        rotation_of,
        transform,
        transform_point,
        transform_vector,
        translation,
    )
    from kinematics.orientations import (
        RPY,
        AxisAngle,
        Degeneracy,
        EulerZYZ,
        OrientationSolution,
        Quaternion,
        rotation_vector,
        solve_axis_angle,
        solve_euler,
        solve_quaternion,
        solve_rpy,
        turn_between,
    )
    from kinematics.rotation_check import check_rotation, check_transform, is_rotation
    from kinematics.rotation_fit import nearest_rotation
    from kinematics.rotations import Matrix3, multiply, rot_x, rot_y, rot_z, rotate, transpose
    from kinematics.systems import SYSTEMS, NamedBranch, System, system
    from kinematics.vectors import Vector, angle_between, cross, dot, norm, unit

_TEXTBOOK: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "kinematics.bases": (
            "Handedness",
            "basis_along",
            "change_of_basis",
            "handedness",
            "third_axis",
        ),
        "kinematics.frame_graph": (
            "FrameGraph",
            "solve_loop",
        ),
        "kinematics.frames": (
            "Transform",
            "compose",
            "invert",
            "position_of",
            "rotation_of",
            "transform",
            "transform_point",
            "transform_vector",
            "translation",
        ),
        "kinematics.orientations": (
            "RPY",
            "AxisAngle",
            "Degeneracy",
            "EulerZYZ",
            "OrientationSolution",
            "Quaternion",
            "rotation_vector",
            "solve_axis_angle",
            "solve_euler",
            "solve_quaternion",
            "solve_rpy",
            "turn_between",
        ),
        "kinematics.rotation_check": (
            "check_rotation",
            "check_transform",
            "is_rotation",
        ),
        "kinematics.rotation_fit": ("nearest_rotation",),
        "kinematics.rotations": (
            "Matrix3",
            "multiply",
            "rot_x",
            "rot_y",
            "rot_z",
            "rotate",
            "transpose",
        ),
        "kinematics.systems": (
            "SYSTEMS",
            "NamedBranch",
            "System",
            "system",
        ),
        "kinematics.vectors": (
            "Vector",
            "angle_between",
            "cross",
            "dot",
            "norm",
            "unit",
        ),
    }
)
"""Where the names live that are imported when they are first used."""

_MODULES: Mapping[str, str] = MappingProxyType(
    {name: module for module, names in _TEXTBOOK.items() for name in names}
)

__all__ = [
    "JOINT_NAMES",
    "PRESETS",
    "RPY",
    "SYSTEMS",
    "ArmPreset",
    "AxisAngle",
    "BadNumber",
    "Base",
    "Branch",
    "Constraint",
    "Degeneracy",
    "Elbow",
    "EulerZYZ",
    "FiveAxisArm",
    "FlatBasis",
    "FrameGraph",
    "FramesDisagree",
    "FramesNotConnected",
    "GuardViolation",
    "Guards",
    "Handedness",
    "JointLimit",
    "JointPath",
    "JointRange",
    "Joints",
    "KinematicsError",
    "LimitViolation",
    "Matrix3",
    "MotorSpec",
    "Motors",
    "NamedBranch",
    "Nearest",
    "NoNearestRotation",
    "NotARotation",
    "NotAUnitQuaternion",
    "OrientationSolution",
    "OutOfReach",
    "PathBroken",
    "Pose",
    "Quaternion",
    "Reference",
    "RollFrame",
    "RotationFlaw",
    "RotationProperty",
    "SingularTransmission",
    "System",
    "Transform",
    "Transmission",
    "UnknownFrame",
    "UnknownPreset",
    "UnknownSystem",
    "Unreachable",
    "Vector",
    "ZeroVector",
    "angle_between",
    "basis_along",
    "cable_transmission",
    "change_of_basis",
    "check_rotation",
    "check_transform",
    "compose",
    "cross",
    "deviation_mm",
    "dot",
    "first_violation",
    "handedness",
    "invert",
    "is_rotation",
    "joint_path",
    "line_path",
    "multiply",
    "nearest",
    "nearest_allowed",
    "nearest_rotation",
    "norm",
    "position_of",
    "preset",
    "rot_x",
    "rot_y",
    "rot_z",
    "rotate",
    "rotation_of",
    "rotation_vector",
    "solve_axis_angle",
    "solve_euler",
    "solve_loop",
    "solve_quaternion",
    "solve_rpy",
    "system",
    "third_axis",
    "transform",
    "transform_point",
    "transform_vector",
    "translation",
    "transpose",
    "turn_between",
    "unit",
]


def __getattr__(name: str) -> Any:
    """Import a name of the textbook when it is first asked for."""
    module = _MODULES.get(name)
    if module is None:
        raise AttributeError(f"module 'kinematics' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(module), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
