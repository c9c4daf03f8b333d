"""The mathematics of the arm: poses, joint angles, motor steps, and the way between them.

Units: mm, rad, whole motor steps. Everything named here is plain Python. What every program
needs is imported at once; the textbook (frames, chains, named systems) when a name of it is first
used, so that the command line starts quickly.
"""

from __future__ import annotations

from types import MappingProxyType

from kinematics.arm_geometry import ArmGeometry
from kinematics.errors import (
    BadNumber,
    Constraint,
    FlatBasis,
    FramesDisagree,
    FramesNotConnected,
    JointLimit,
    KinematicsError,
    NoArc,
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
from kinematics.guards_path import first_violation
from kinematics.limits import JointRange, LimitViolation
from kinematics.nearest import Nearest, nearest
from kinematics.paths import JointPath, deviation_mm, joint_path, line_path
from kinematics.presets import PRESETS, ArmModel, ArmPreset, Reference, cable_transmission, preset
from kinematics.spaces import JOINT_NAMES, Joints, Motors, Pose
from kinematics.transmission import MotorSpec, Transmission

TYPE_CHECKING = False  # as typing's
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from kinematics.accuracy import (
        MapPoint,
        TipError,
        accuracy_map,
        gearing_errors,
        length_errors,
        rounding_bound_mm,
        rounding_rms_mm,
        step_errors,
        zero_errors,
    )
    from kinematics.arcs import arc_path, circle_path
    from kinematics.assignment import Assignment, JointAxis, assign_frames
    from kinematics.bases import Handedness, basis_along, change_of_basis, handedness, third_axis
    from kinematics.chain_arm import ChainArm
    from kinematics.chains import Chain, JointViolation
    from kinematics.counting import Ledger, Tally, on_any_numbers
    from kinematics.efficiency import Efficiency, Way, forward_ways
    from kinematics.five_axis_singularities import (
        FiveAxisSingularity,
        Nearness,
        five_axis_singularities,
        nearest_five_axis_singularity,
    )
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
    from kinematics.generated import Generated
    from kinematics.goals import Goal, Part, frame_goal, pose_goal
    from kinematics.hand_frame import FrameSolution
    from kinematics.ik_account import Reason, Solution
    from kinematics.jacobians import geometric_jacobian, manipulability, task_jacobian
    from kinematics.link_types import LINK_TYPES, LinkType, link_type
    from kinematics.links import Convention, DHLink, JointKind, a_matrix
    from kinematics.moves import ArcMove, JointMove, LineMove, Move, PoseMove
    from kinematics.numeric_ik import (
        PITCH_FIRST,
        POSITION_FIRST,
        Effort,
        solve_frame_ik,
        solve_goal,
        solve_pose_ik,
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
    from kinematics.profiles import Phase, Profile, jerk_limited, trapezoid
    from kinematics.rates import Rates, joint_rates
    from kinematics.resolution import StepRange, explain_resolution, step_ranges
    from kinematics.rotation_check import check_rotation, check_transform, is_rotation
    from kinematics.rotation_fit import nearest_rotation
    from kinematics.rotations import Matrix3, multiply, rot_x, rot_y, rot_z, rotate, transpose
    from kinematics.routes import PathSection, Route, route_sections
    from kinematics.singular_nearby import NearestSingularity, nearest_singularity
    from kinematics.singularities import Condition, condition
    from kinematics.symbol_text import matrix_latex, matrix_text
    from kinematics.symbolic_systems import symbolic_chain, symbolic_system
    from kinematics.symbols import Symbol, coordinate, named
    from kinematics.systems import SYSTEMS, NamedBranch, System, system
    from kinematics.tables import chain_of_rows, rows_of, table_text
    from kinematics.timing import Piece, TimedPath, timed
    from kinematics.timing_limits import MotionLimits
    from kinematics.urdf import urdf_of_arm, urdf_of_chain
    from kinematics.vectors import Vector, angle_between, cross, dot, norm, unit
    from kinematics.worked_example import WorkedExample, work_chain, work_system
    from kinematics.workspace import Reach, Section, sampled_reach, section

_TEXTBOOK: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "kinematics.accuracy": (
            "MapPoint",
            "TipError",
            "accuracy_map",
            "gearing_errors",
            "length_errors",
            "rounding_bound_mm",
            "rounding_rms_mm",
            "step_errors",
            "zero_errors",
        ),
        "kinematics.counting": (
            "Ledger",
            "Tally",
            "on_any_numbers",
        ),
        "kinematics.efficiency": (
            "Efficiency",
            "Way",
            "forward_ways",
        ),
        "kinematics.arcs": (
            "arc_path",
            "circle_path",
        ),
        "kinematics.moves": (
            "ArcMove",
            "JointMove",
            "LineMove",
            "Move",
            "PoseMove",
        ),
        "kinematics.routes": (
            "PathSection",
            "Route",
            "route_sections",
        ),
        "kinematics.hand_frame": ("FrameSolution",),
        "kinematics.resolution": (
            "StepRange",
            "explain_resolution",
            "step_ranges",
        ),
        "kinematics.urdf": (
            "urdf_of_arm",
            "urdf_of_chain",
        ),
        "kinematics.workspace": (
            "Reach",
            "Section",
            "sampled_reach",
            "section",
        ),
        "kinematics.assignment": (
            "Assignment",
            "JointAxis",
            "assign_frames",
        ),
        "kinematics.bases": (
            "Handedness",
            "basis_along",
            "change_of_basis",
            "handedness",
            "third_axis",
        ),
        "kinematics.chain_arm": ("ChainArm",),
        "kinematics.chains": (
            "Chain",
            "JointViolation",
        ),
        "kinematics.five_axis_singularities": (
            "FiveAxisSingularity",
            "Nearness",
            "five_axis_singularities",
            "nearest_five_axis_singularity",
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
        "kinematics.generated": ("Generated",),
        "kinematics.goals": (
            "Goal",
            "Part",
            "frame_goal",
            "pose_goal",
        ),
        "kinematics.ik_account": (
            "Reason",
            "Solution",
        ),
        "kinematics.jacobians": (
            "geometric_jacobian",
            "manipulability",
            "task_jacobian",
        ),
        "kinematics.link_types": (
            "LINK_TYPES",
            "LinkType",
            "link_type",
        ),
        "kinematics.links": (
            "Convention",
            "DHLink",
            "JointKind",
            "a_matrix",
        ),
        "kinematics.numeric_ik": (
            "PITCH_FIRST",
            "POSITION_FIRST",
            "Effort",
            "solve_frame_ik",
            "solve_goal",
            "solve_pose_ik",
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
        "kinematics.profiles": (
            "Phase",
            "Profile",
            "jerk_limited",
            "trapezoid",
        ),
        "kinematics.timing": (
            "Piece",
            "TimedPath",
            "timed",
        ),
        "kinematics.timing_limits": ("MotionLimits",),
        "kinematics.rates": (
            "Rates",
            "joint_rates",
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
        "kinematics.singular_nearby": (
            "NearestSingularity",
            "nearest_singularity",
        ),
        "kinematics.singularities": (
            "Condition",
            "condition",
        ),
        "kinematics.symbol_text": (
            "matrix_latex",
            "matrix_text",
        ),
        "kinematics.symbolic_systems": (
            "symbolic_chain",
            "symbolic_system",
        ),
        "kinematics.symbols": (
            "Symbol",
            "coordinate",
            "named",
        ),
        "kinematics.worked_example": (
            "WorkedExample",
            "work_chain",
            "work_system",
        ),
        "kinematics.systems": (
            "SYSTEMS",
            "NamedBranch",
            "System",
            "system",
        ),
        "kinematics.tables": (
            "chain_of_rows",
            "rows_of",
            "table_text",
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
    "LINK_TYPES",
    "PITCH_FIRST",
    "POSITION_FIRST",
    "PRESETS",
    "RPY",
    "SYSTEMS",
    "ArcMove",
    "ArmGeometry",
    "ArmModel",
    "ArmPreset",
    "Assignment",
    "AxisAngle",
    "BadNumber",
    "Base",
    "Branch",
    "Chain",
    "ChainArm",
    "Condition",
    "Constraint",
    "Convention",
    "DHLink",
    "Degeneracy",
    "Efficiency",
    "Effort",
    "Elbow",
    "EulerZYZ",
    "FiveAxisArm",
    "FiveAxisSingularity",
    "FlatBasis",
    "FrameGraph",
    "FrameSolution",
    "FramesDisagree",
    "FramesNotConnected",
    "Generated",
    "Goal",
    "GuardViolation",
    "Guards",
    "Handedness",
    "JointAxis",
    "JointKind",
    "JointLimit",
    "JointMove",
    "JointPath",
    "JointRange",
    "JointViolation",
    "Joints",
    "KinematicsError",
    "Ledger",
    "LimitViolation",
    "LineMove",
    "LinkType",
    "MapPoint",
    "Matrix3",
    "MotionLimits",
    "MotorSpec",
    "Motors",
    "Move",
    "NamedBranch",
    "Nearest",
    "NearestSingularity",
    "Nearness",
    "NoArc",
    "NoNearestRotation",
    "NotARotation",
    "NotAUnitQuaternion",
    "OrientationSolution",
    "OutOfReach",
    "Part",
    "PathBroken",
    "PathSection",
    "Phase",
    "Piece",
    "Pose",
    "PoseMove",
    "Profile",
    "Quaternion",
    "Rates",
    "Reach",
    "Reason",
    "Reference",
    "RollFrame",
    "RotationFlaw",
    "RotationProperty",
    "Route",
    "Section",
    "SingularTransmission",
    "Solution",
    "StepRange",
    "Symbol",
    "System",
    "Tally",
    "TimedPath",
    "TipError",
    "Transform",
    "Transmission",
    "UnknownFrame",
    "UnknownPreset",
    "UnknownSystem",
    "Unreachable",
    "Vector",
    "Way",
    "WorkedExample",
    "ZeroVector",
    "a_matrix",
    "accuracy_map",
    "angle_between",
    "arc_path",
    "assign_frames",
    "basis_along",
    "cable_transmission",
    "chain_of_rows",
    "change_of_basis",
    "check_rotation",
    "check_transform",
    "circle_path",
    "compose",
    "condition",
    "coordinate",
    "cross",
    "deviation_mm",
    "dot",
    "explain_resolution",
    "first_violation",
    "five_axis_singularities",
    "forward_ways",
    "frame_goal",
    "gearing_errors",
    "generated",
    "geometric_jacobian",
    "handedness",
    "invert",
    "is_rotation",
    "jerk_limited",
    "joint_path",
    "joint_rates",
    "length_errors",
    "line_path",
    "link_type",
    "manipulability",
    "matrix_latex",
    "matrix_text",
    "multiply",
    "named",
    "nearest",
    "nearest_allowed",
    "nearest_five_axis_singularity",
    "nearest_rotation",
    "nearest_singularity",
    "norm",
    "on_any_numbers",
    "pose_goal",
    "position_of",
    "preset",
    "rot_x",
    "rot_y",
    "rot_z",
    "rotate",
    "rotation_of",
    "rotation_vector",
    "rounding_bound_mm",
    "rounding_rms_mm",
    "route_sections",
    "rows_of",
    "sampled_reach",
    "section",
    "solve_axis_angle",
    "solve_euler",
    "solve_frame_ik",
    "solve_goal",
    "solve_loop",
    "solve_pose_ik",
    "solve_quaternion",
    "solve_rpy",
    "step_errors",
    "step_ranges",
    "symbolic_chain",
    "symbolic_system",
    "system",
    "table_text",
    "task_jacobian",
    "third_axis",
    "timed",
    "transform",
    "transform_point",
    "transform_vector",
    "translation",
    "transpose",
    "trapezoid",
    "turn_between",
    "unit",
    "urdf_of_arm",
    "urdf_of_chain",
    "work_chain",
    "work_system",
    "zero_errors",
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
