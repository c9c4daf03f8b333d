"""Drive Mini-mover-style robot arms, real or simulated, from Python or a terminal.

```python
from armdrive import Arm, Pose
with Arm.connect("sim:teachmover") as arm:
    arm.home()
    arm.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90))
```
"""

from __future__ import annotations

from types import MappingProxyType

TYPE_CHECKING = False  # as typing's, which takes longer to import than all of this file
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from armdrive.aio.arm import AsyncArm, AsyncHandle
    from armdrive.arm import Arm
    from armdrive.arm.handle import Handle
    from armdrive.dialog import MarkRequest, PostureRequest
    from armdrive.errors import (
        ArmError,
        ArmFileError,
        ArmInUse,
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
        WrongState,
    )
    from armdrive.motion.execute import Moved
    from armdrive.motion.gripper import Grasped
    from armdrive.motion.jog.session import Jogged
    from armdrive.motion.preview import Preview
    from armdrive.motion.verify import Drift, Verdict, Verified
    from armdrive.moves import Jog, Space
    from armdrive.programs.teaching.sequence import Stepper
    from armdrive.registry import PendantProgram
    from armdrive.runtime.clock import SimulatedClock
    from armdrive.status import Current, State, Status, Trust
    from armdrive.storage.points import Point, Step, StepList
    from kinematics import Joints, KinematicsError, Motors, NoArc, PathBroken, Pose, Unreachable
    from kinematics.paths.parts import ArcMove, JointMove, LineMove, PoseMove

_HOMES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "armdrive.aio.arm": (
            "AsyncArm",
            "AsyncHandle",
        ),
        "armdrive.arm": ("Arm",),
        "armdrive.arm.handle": ("Handle",),
        "armdrive.dialog": (
            "MarkRequest",
            "PostureRequest",
        ),
        "armdrive.errors": (
            "ArmError",
            "ArmFileError",
            "ArmInUse",
            "BadRequest",
            "DeviceFault",
            "InputTimeout",
            "LinkError",
            "LinkLost",
            "NoAnswer",
            "NotReferenced",
            "OperatorNeeded",
            "OutOfBounds",
            "PendantFileError",
            "PendantStop",
            "PointsChanged",
            "PointsFileError",
            "PortUnavailable",
            "PositionMismatch",
            "ProgramHalfWritten",
            "RecordingError",
            "Refused",
            "StateFileError",
            "Stopped",
            "UnknownPoint",
            "WrongState",
        ),
        "armdrive.motion.execute": ("Moved",),
        "armdrive.motion.gripper": ("Grasped",),
        "armdrive.motion.jog.session": ("Jogged",),
        "armdrive.motion.preview": ("Preview",),
        "armdrive.motion.verify": (
            "Drift",
            "Verdict",
            "Verified",
        ),
        "armdrive.moves": (
            "Jog",
            "Space",
        ),
        "armdrive.programs.teaching.sequence": ("Stepper",),
        "armdrive.registry": ("PendantProgram",),
        "armdrive.runtime.clock": ("SimulatedClock",),
        "armdrive.status": (
            "Current",
            "State",
            "Status",
            "Trust",
        ),
        "armdrive.storage.points": (
            "Point",
            "Step",
            "StepList",
        ),
        "kinematics": (
            "Joints",
            "KinematicsError",
            "Motors",
            "NoArc",
            "PathBroken",
            "Pose",
            "Unreachable",
        ),
        "kinematics.paths.parts": (
            "ArcMove",
            "JointMove",
            "LineMove",
            "PoseMove",
        ),
    }
)
"""Where each public name lives. Names are imported when they are first used, so that the command
line starts quickly."""

_MODULES: Mapping[str, str] = MappingProxyType(
    {name: module for module, names in _HOMES.items() for name in names}
)

__all__ = [
    "ArcMove",
    "Arm",
    "ArmError",
    "ArmFileError",
    "ArmInUse",
    "AsyncArm",
    "AsyncHandle",
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
    "WrongState",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for."""
    module = _MODULES.get(name)
    if module is None:
        raise AttributeError(f"module 'armdrive' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(module), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
