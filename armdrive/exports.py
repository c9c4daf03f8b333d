"""The public names of armdrive, each from the module that defines it."""

from armdrive.aio import AsyncArm
from armdrive.aio.calls import AsyncHandle
from armdrive.arm import Arm
from armdrive.arm.connected import Handle
from armdrive.dialog.operator import MarkRequest, PostureRequest
from armdrive.errors import (
    ArmError,
    ArmFileError,
    ArmInUse,
    BadArgument,
    BadRequest,
    DeviceFault,
    InputTimeout,
    LinkError,
    LinkLost,
    NoAnswer,
    NotReferenced,
    OperatorNeeded,
    OutOfBounds,
    PendantFileError,
    PendantStop,
    PointsChanged,
    PointsFileError,
    PortUnavailable,
    PositionMismatch,
    ProgramHalfWritten,
    RecordingError,
    Refused,
    StateFileError,
    Stopped,
    UnknownPoint,
    WaitTimeout,
    WrongState,
)
from armdrive.motion.execute import Moved
from armdrive.motion.gripper import Grasped
from armdrive.motion.jog import Jogged
from armdrive.motion.preview import Preview
from armdrive.motion.reference import Drift, Verdict, Verified
from armdrive.moves import (
    ArcMove,
    GraspMove,
    GripperMove,
    Jog,
    JogMove,
    JointMove,
    LineMove,
    MoveSequence,
    ParkMove,
    PathMove,
    PoseMove,
    Space,
)
from armdrive.programs.teaching.sequence import Stepper
from armdrive.registry.pendant import PendantProgram
from armdrive.runtime.clock import SimulatedClock
from armdrive.status import Current, State, Status, Trust
from armdrive.storage.points import Point, Step, StepList
from armdrive.text.json_forms import move_from_json, move_to_json
from kinematics.errors import KinematicsError, NoArc
from kinematics.geometry import PathBroken, Unreachable
from kinematics.paths.routes import ArcPart, JointPart, LinePart, PosePart
from kinematics.spaces import Joints, Motors, Pose

__all__ = [
    "ArcMove",
    "ArcPart",
    "Arm",
    "ArmError",
    "ArmFileError",
    "ArmInUse",
    "AsyncArm",
    "AsyncHandle",
    "BadArgument",
    "BadRequest",
    "Current",
    "DeviceFault",
    "Drift",
    "GraspMove",
    "Grasped",
    "GripperMove",
    "Handle",
    "InputTimeout",
    "Jog",
    "JogMove",
    "Jogged",
    "JointMove",
    "JointPart",
    "Joints",
    "KinematicsError",
    "LineMove",
    "LinePart",
    "LinkError",
    "LinkLost",
    "MarkRequest",
    "Motors",
    "MoveSequence",
    "Moved",
    "NoAnswer",
    "NoArc",
    "NotReferenced",
    "OperatorNeeded",
    "OutOfBounds",
    "ParkMove",
    "PathBroken",
    "PathMove",
    "PendantFileError",
    "PendantProgram",
    "PendantStop",
    "Point",
    "PointsChanged",
    "PointsFileError",
    "PortUnavailable",
    "Pose",
    "PoseMove",
    "PosePart",
    "PositionMismatch",
    "PostureRequest",
    "Preview",
    "ProgramHalfWritten",
    "RecordingError",
    "Refused",
    "SimulatedClock",
    "Space",
    "State",
    "StateFileError",
    "Status",
    "Step",
    "StepList",
    "Stepper",
    "Stopped",
    "Trust",
    "UnknownPoint",
    "Unreachable",
    "Verdict",
    "Verified",
    "WaitTimeout",
    "WrongState",
    "move_from_json",
    "move_to_json",
]
