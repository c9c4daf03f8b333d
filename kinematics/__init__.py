"""The mathematics of the arm: poses, joint angles, motor steps, and the way between them.

Units: mm, rad, whole motor steps. Everything named here is plain Python. What every program
needs is imported at once; the rest (link tables, routes, the textbook) when a name of it is first
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
from kinematics.five_axis.arm import Base, Branch, Elbow, FiveAxisArm
from kinematics.five_axis.nearest import Nearest, nearest
from kinematics.geometry import ArmGeometry
from kinematics.guards.escape import nearest_allowed
from kinematics.guards.guards import Guards, GuardViolation
from kinematics.guards.path import first_violation
from kinematics.limits import JointRange, LimitViolation
from kinematics.paths.chords import JointPath, deviation_mm, joint_path, line_path
from kinematics.presets import PRESETS, ArmModel, ArmPreset, Reference, cable_transmission, preset
from kinematics.spaces import JOINT_NAMES, Joints, Motors, Pose, RollFrame
from kinematics.transmission import MotorSpec, Transmission

TYPE_CHECKING = False  # as typing's
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from kinematics.chains.arm import ChainArm
    from kinematics.chains.assignment import Assignment, JointAxis, assign_frames
    from kinematics.chains.chain import Chain, JointViolation
    from kinematics.chains.generated import Generated, generated
    from kinematics.chains.goals import Goal, Part, frame_goal, pose_goal
    from kinematics.chains.inverse import (
        PITCH_FIRST,
        POSITION_FIRST,
        Effort,
        Reason,
        Solution,
        solve_frame_ik,
        solve_goal,
        solve_pose_ik,
    )
    from kinematics.chains.jacobians import Rates, geometric_jacobian, joint_rates, manipulability
    from kinematics.chains.links import (
        LINK_TYPES,
        Convention,
        DHLink,
        JointKind,
        LinkType,
        a_matrix,
        link_type,
    )
    from kinematics.chains.singularities import (
        Condition,
        NearestSingularity,
        condition,
        nearest_singularity,
    )
    from kinematics.chains.tables import chain_of_rows, rows_of, table_text
    from kinematics.chains.urdf import urdf_of_chain
    from kinematics.five_axis.frame import FrameSolution
    from kinematics.five_axis.singularities import (
        FiveAxisSingularity,
        Nearness,
        five_axis_singularities,
        nearest_five_axis_singularity,
        task_jacobian,
    )
    from kinematics.five_axis.workspace import Reach, Section, sampled_reach, section
    from kinematics.frames.graph import FrameGraph, solve_loop
    from kinematics.frames.orientations import (
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
    from kinematics.frames.quaternions import nearest_rotation
    from kinematics.frames.rotations import (
        Matrix3,
        multiply,
        rot_x,
        rot_y,
        rot_z,
        rotate,
        transpose,
    )
    from kinematics.frames.transforms import (
        Handedness,
        Transform,
        basis_along,
        change_of_basis,
        check_rotation,
        check_transform,
        compose,
        handedness,
        invert,
        is_rotation,
        position_of,
        rotation_of,
        third_axis,
        transform,
        transform_point,
        transform_vector,
        translation,
    )
    from kinematics.frames.vectors import Vector, angle_between, cross, dot, norm, unit
    from kinematics.paths.arcs import arc_path, circle_path
    from kinematics.paths.motion_limits import MotionLimits
    from kinematics.paths.parts import ArcMove, JointMove, LineMove, Move, PoseMove
    from kinematics.paths.profiles import Phase, Profile, jerk_limited, trapezoid
    from kinematics.paths.routes import PathSection, Route, route_sections
    from kinematics.paths.timing import Piece, TimedPath, timed
    from kinematics.textbook.accuracy import (
        MapPoint,
        StepRange,
        TipError,
        accuracy_map,
        explain_resolution,
        gearing_errors,
        length_errors,
        rounding_bound_mm,
        rounding_rms_mm,
        step_errors,
        step_ranges,
        zero_errors,
    )
    from kinematics.textbook.efficiency import (
        Efficiency,
        Ledger,
        Tally,
        Way,
        forward_ways,
        on_any_numbers,
    )
    from kinematics.textbook.notation import matrix_latex, matrix_text
    from kinematics.textbook.symbolic_systems import symbolic_chain, symbolic_system
    from kinematics.textbook.symbols import Symbol, coordinate, named
    from kinematics.textbook.systems import SYSTEMS, NamedBranch, System, system
    from kinematics.textbook.systems.mini_movers import urdf_of_arm
    from kinematics.textbook.worked_example import WorkedExample, work_chain, work_system

_HOMES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "kinematics.chains.arm": ("ChainArm",),
        "kinematics.chains.assignment": ("Assignment", "JointAxis", "assign_frames"),
        "kinematics.chains.chain": ("Chain", "JointViolation"),
        "kinematics.chains.generated": ("Generated", "generated"),
        "kinematics.chains.goals": ("Goal", "Part", "frame_goal", "pose_goal"),
        "kinematics.chains.inverse": (
            "PITCH_FIRST",
            "POSITION_FIRST",
            "Effort",
            "Reason",
            "Solution",
            "solve_frame_ik",
            "solve_goal",
            "solve_pose_ik",
        ),
        "kinematics.chains.jacobians": (
            "Rates",
            "geometric_jacobian",
            "joint_rates",
            "manipulability",
        ),
        "kinematics.chains.links": (
            "LINK_TYPES",
            "Convention",
            "DHLink",
            "JointKind",
            "LinkType",
            "a_matrix",
            "link_type",
        ),
        "kinematics.chains.singularities": (
            "Condition",
            "NearestSingularity",
            "condition",
            "nearest_singularity",
        ),
        "kinematics.chains.tables": ("chain_of_rows", "rows_of", "table_text"),
        "kinematics.chains.urdf": ("urdf_of_chain",),
        "kinematics.five_axis.frame": ("FrameSolution",),
        "kinematics.five_axis.singularities": (
            "FiveAxisSingularity",
            "Nearness",
            "five_axis_singularities",
            "nearest_five_axis_singularity",
            "task_jacobian",
        ),
        "kinematics.five_axis.workspace": ("Reach", "Section", "sampled_reach", "section"),
        "kinematics.frames.graph": ("FrameGraph", "solve_loop"),
        "kinematics.frames.orientations": (
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
        "kinematics.frames.quaternions": ("nearest_rotation",),
        "kinematics.frames.rotations": (
            "Matrix3",
            "multiply",
            "rot_x",
            "rot_y",
            "rot_z",
            "rotate",
            "transpose",
        ),
        "kinematics.frames.transforms": (
            "Handedness",
            "Transform",
            "basis_along",
            "change_of_basis",
            "check_rotation",
            "check_transform",
            "compose",
            "handedness",
            "invert",
            "is_rotation",
            "position_of",
            "rotation_of",
            "third_axis",
            "transform",
            "transform_point",
            "transform_vector",
            "translation",
        ),
        "kinematics.frames.vectors": ("Vector", "angle_between", "cross", "dot", "norm", "unit"),
        "kinematics.paths.arcs": ("arc_path", "circle_path"),
        "kinematics.paths.motion_limits": ("MotionLimits",),
        "kinematics.paths.parts": ("ArcMove", "JointMove", "LineMove", "Move", "PoseMove"),
        "kinematics.paths.profiles": ("Phase", "Profile", "jerk_limited", "trapezoid"),
        "kinematics.paths.routes": ("PathSection", "Route", "route_sections"),
        "kinematics.paths.timing": ("Piece", "TimedPath", "timed"),
        "kinematics.textbook.accuracy": (
            "MapPoint",
            "StepRange",
            "TipError",
            "accuracy_map",
            "explain_resolution",
            "gearing_errors",
            "length_errors",
            "rounding_bound_mm",
            "rounding_rms_mm",
            "step_errors",
            "step_ranges",
            "zero_errors",
        ),
        "kinematics.textbook.efficiency": (
            "Efficiency",
            "Ledger",
            "Tally",
            "Way",
            "forward_ways",
            "on_any_numbers",
        ),
        "kinematics.textbook.notation": ("matrix_latex", "matrix_text"),
        "kinematics.textbook.symbolic_systems": ("symbolic_chain", "symbolic_system"),
        "kinematics.textbook.symbols": ("Symbol", "coordinate", "named"),
        "kinematics.textbook.systems": ("SYSTEMS", "NamedBranch", "System", "system"),
        "kinematics.textbook.systems.mini_movers": ("urdf_of_arm",),
        "kinematics.textbook.worked_example": ("WorkedExample", "work_chain", "work_system"),
    }
)
"""Where the names live that are imported when they are first used.

Tools read the imports above, Python reads this table; a test compares them.
"""

_MODULES: Mapping[str, str] = MappingProxyType(
    {name: module for module, names in _HOMES.items() for name in names}
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
    """Import a name when it is first asked for."""
    module = _MODULES.get(name)
    if module is None:
        raise AttributeError(f"module 'kinematics' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(module), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
