"""The public names of armdrive, each from the module that defines it."""

from armdrive.aio.arm import AsyncArm, AsyncHandle
from armdrive.arm import Arm
from armdrive.arm.handle import Handle
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
from armdrive.motion.jog.session import Jogged
from armdrive.motion.preview import Preview
from armdrive.motion.verify import Drift, Verdict, Verified
from armdrive.moves import Jog, Space
from armdrive.operator import MarkRequest, PostureRequest
from armdrive.programs.teaching.sequence import Stepper
from armdrive.registry.pendant import PendantProgram
from armdrive.runtime.clock import SimulatedClock
from armdrive.status import Current, State, Status, Trust
from armdrive.storage.points import Point, Step, StepList
from kinematics.errors import KinematicsError, NoArc, PathBroken, Unreachable
from kinematics.paths.parts import ArcMove, JointMove, LineMove, PoseMove
from kinematics.spaces import Joints, Motors, Pose

__all__ = [
    "ArcMove",
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
    "Grasped",
    "Handle",
    "InputTimeout",
    "Jog",
    "Jogged",
    "JointMove",
    "Joints",
    "KinematicsError",
    "LineMove",
    "LinkError",
    "LinkLost",
    "MarkRequest",
    "Motors",
    "Moved",
    "NoAnswer",
    "NoArc",
    "NotReferenced",
    "OperatorNeeded",
    "OutOfBounds",
    "PathBroken",
    "PendantFileError",
    "PendantProgram",
    "PendantStop",
    "Point",
    "PointsChanged",
    "PointsFileError",
    "PortUnavailable",
    "Pose",
    "PoseMove",
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
]
