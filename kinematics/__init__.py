"""The mathematics of the arm: poses, joint angles, motor steps, and the way between them.

Units: mm, rad, whole motor steps. Everything named here is plain Python and light to import.
"""

from kinematics.errors import (
    BadNumber,
    Constraint,
    JointLimit,
    KinematicsError,
    PathBroken,
    SingularTransmission,
    UnknownPreset,
    Unreachable,
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

__all__ = [
    "JOINT_NAMES",
    "PRESETS",
    "ArmPreset",
    "BadNumber",
    "Base",
    "Branch",
    "Constraint",
    "Elbow",
    "FiveAxisArm",
    "GuardViolation",
    "Guards",
    "JointLimit",
    "JointPath",
    "JointRange",
    "Joints",
    "KinematicsError",
    "LimitViolation",
    "MotorSpec",
    "Motors",
    "Nearest",
    "PathBroken",
    "Pose",
    "Reference",
    "RollFrame",
    "SingularTransmission",
    "Transmission",
    "UnknownPreset",
    "Unreachable",
    "cable_transmission",
    "deviation_mm",
    "first_violation",
    "joint_path",
    "line_path",
    "nearest",
    "nearest_allowed",
    "preset",
]
