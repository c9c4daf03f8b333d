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
if TYPE_CHECKING:  # what type checkers read; `_HOMES` says the same, and a test compares the two
    from collections.abc import Mapping
    from typing import Any

    from armdrive.aio.arm import AsyncArm as AsyncArm
    from armdrive.aio.arm import AsyncHandle as AsyncHandle
    from armdrive.arm import Arm as Arm
    from armdrive.arm.handle import Handle as Handle
    from armdrive.dialog import MarkRequest as MarkRequest
    from armdrive.dialog import PostureRequest as PostureRequest
    from armdrive.errors import ArmError as ArmError
    from armdrive.errors import ArmFileError as ArmFileError
    from armdrive.errors import ArmInUse as ArmInUse
    from armdrive.errors import BadRequest as BadRequest
    from armdrive.errors import DeviceFault as DeviceFault
    from armdrive.errors import InputTimeout as InputTimeout
    from armdrive.errors import LinkError as LinkError
    from armdrive.errors import LinkLost as LinkLost
    from armdrive.errors import NoAnswer as NoAnswer
    from armdrive.errors import NotReferenced as NotReferenced
    from armdrive.errors import OperatorNeeded as OperatorNeeded
    from armdrive.errors import OutOfBounds as OutOfBounds
    from armdrive.errors import PendantFileError as PendantFileError
    from armdrive.errors import PendantStop as PendantStop
    from armdrive.errors import PointsChanged as PointsChanged
    from armdrive.errors import PointsFileError as PointsFileError
    from armdrive.errors import PortUnavailable as PortUnavailable
    from armdrive.errors import PositionMismatch as PositionMismatch
    from armdrive.errors import ProgramHalfWritten as ProgramHalfWritten
    from armdrive.errors import RecordingError as RecordingError
    from armdrive.errors import Refused as Refused
    from armdrive.errors import StateFileError as StateFileError
    from armdrive.errors import Stopped as Stopped
    from armdrive.errors import UnknownPoint as UnknownPoint
    from armdrive.errors import WrongState as WrongState
    from armdrive.motion.execute import Moved as Moved
    from armdrive.motion.gripper import Grasped as Grasped
    from armdrive.motion.jog.session import Jogged as Jogged
    from armdrive.motion.preview import Preview as Preview
    from armdrive.motion.verify import Drift as Drift
    from armdrive.motion.verify import Verdict as Verdict
    from armdrive.motion.verify import Verified as Verified
    from armdrive.moves import Jog as Jog
    from armdrive.moves import Space as Space
    from armdrive.programs.teaching.sequence import Stepper as Stepper
    from armdrive.registry.pendant import PendantProgram as PendantProgram
    from armdrive.runtime.clock import SimulatedClock as SimulatedClock
    from armdrive.status import Current as Current
    from armdrive.status import State as State
    from armdrive.status import Status as Status
    from armdrive.status import Trust as Trust
    from armdrive.storage.points import Point as Point
    from armdrive.storage.points import Step as Step
    from armdrive.storage.points import StepList as StepList
    from kinematics import Joints as Joints
    from kinematics import KinematicsError as KinematicsError
    from kinematics import Motors as Motors
    from kinematics import NoArc as NoArc
    from kinematics import PathBroken as PathBroken
    from kinematics import Pose as Pose
    from kinematics import Unreachable as Unreachable
    from kinematics.paths.parts import ArcMove as ArcMove
    from kinematics.paths.parts import JointMove as JointMove
    from kinematics.paths.parts import LineMove as LineMove
    from kinematics.paths.parts import PoseMove as PoseMove

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

__all__ = list(_MODULES)


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for."""
    module = _MODULES.get(name)
    if module is None:
        raise AttributeError(f"module 'armdrive' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(module), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
