"""What the desk needs of an arm: `armdrive.Arm` has it, and so has a fake in the tests."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol, overload

from armdrive import Grasped, Handle, Moved, Preview
from armdrive.config.arm import ArmConfig
from armdrive.dialog.operator import PostureRequest
from armdrive.errors import ArmError
from armdrive.moves import GraspMove, Jog, Motion, Move
from armdrive.status import Status
from armdrive.storage.point_file import Points
from armdrive.trace.log import LogReader
from kinematics.errors import KinematicsError
from kinematics.presets import ArmModel
from kinematics.spaces import Pose


class DeskGripper(Protocol):
    """The fingers of the arm."""

    @property
    def force_n(self) -> float:
        """The force of the grasp; 0 when let go."""

    def feel(self) -> Grasped:
        """Close the fingers until they touch an object or each other; raises `ArmError`."""


class DeskReferencing(Protocol):
    """How the arm is referenced."""

    @property
    def homes_by_switches(self) -> bool:
        """Whether `home` has the controller seek its switches, which moves the arm."""


class DeskArm(Protocol):
    """One connected arm. `hold` to `estop` return at once; the other calls may take a moment."""

    program: Callable[[], dict[str, Any]] | None
    """Tells, also other programs, what the arm is at work on, as plain data."""

    @property
    def status(self) -> Status:
        """The latest frozen picture of the arm."""

    @property
    def model(self) -> ArmModel:
        """Geometry, limits and gripper range."""

    @property
    def gripper(self) -> DeskGripper:
        """The fingers."""

    @property
    def frames(self) -> tuple[str, ...]:
        """The frames in which the tip can be jogged, the base first."""

    @property
    def referencing(self) -> DeskReferencing:
        """How the arm is referenced."""

    @property
    def reconnects(self) -> bool:
        """Whether the arm reconnects by itself after a lost link."""

    def reconnect(self) -> None:
        """Look for a lost link once. Moves nothing; raises `ArmError` if there is none."""

    def reference_request(self) -> PostureRequest:
        """Return the reference posture, with the sentence that describes it; raises `Refused`."""

    def hold(self, jog: Jog, *, speed: float, for_s: float) -> None:
        """Jog for this time, or until the next call. Refusals appear as the status's notice."""

    def nudge(self, jog: Jog, *, speed: float) -> None:
        """Jog by one increment. Refusals appear as the status's notice."""

    def release(self) -> None:
        """End a held jog."""

    def request_stop(self) -> None:
        """Ask for a stop and return at once, from any thread."""

    def estop(self) -> None:
        """Stop and latch the error state; returns at once."""

    def reset(self) -> None:
        """Leave the error state. Moves nothing; raises `ArmError`."""

    def home(self) -> object:
        """Have the controller home, or the simulated operator bring a simulated arm there."""

    def enable(self) -> None:
        """Switch the motors on. Moves nothing; raises `ArmError`."""

    def disable(self) -> None:
        """Switch the motors off: the arm can sag; raises `ArmError`."""

    def confirm_reference(self) -> None:
        """Say that the arm stands in its reference posture; raises `ArmError`."""

    def confirm_restored(self) -> None:
        """Say that the arm stands where the last program left it; raises `ArmError`."""

    # -- setting up ----------------------------------------------------------------------

    @property
    def config(self) -> ArmConfig:
        """The arm as its file has it."""

    def move_motors(self, *steps: int, speed: float, stops: int | None = None) -> object:
        """Turn motors by whole steps; raises `ArmError`, also for a stop since `stops`."""

    # -- planned motion -------------------------------------------------------------------

    @property
    def stops(self) -> int:
        """The number of stops requested so far."""

    def pose_in(self, frame: str) -> Pose:
        """The present pose as a frame of the arm file sees it; raises `ArmError`."""

    def preview(self, move: Move) -> Preview:
        """Return what a move would be, or why it is refused. Moves nothing."""

    @overload
    def start(self, move: Motion, *, stops: int | None = None) -> Handle[Moved]: ...
    @overload
    def start(self, move: GraspMove, *, stops: int | None = None) -> Handle[Grasped]: ...

    # -- points and sequences -------------------------------------------------------------

    @property
    def points(self) -> Points:
        """The named points of this arm, and its sequences, as they stand in their file."""

    def sleep(self, time_s: float) -> None:
        """Let time pass on the arm's own clock."""

    def pause(self) -> None:
        """Pause the arm after its next burst; returns at once."""

    def resume(self) -> None:
        """Let a paused arm go on; returns at once."""

    # -- the log --------------------------------------------------------------------------

    def log(self) -> LogReader:
        """Return a reader of the traffic on the wire; raises `WrongState` if no log is kept."""

    def save_recording(self) -> Path:
        """Write what the flight recorder holds, and return the file; raises `ArmError`."""

    def close(self) -> None:
        """Stop, and give the port back. Closing twice is no error."""


Done = str | Callable[[Status], str] | None
"""The message after a successful call: a sentence, or one made from the status."""


def outcome(arm: DeskArm, call: Callable[[], object], done: Done) -> str | None:
    """Make a call; return the message about it, None if the status shows enough."""
    try:
        call()
        return done(arm.status) if callable(done) else done
    except (ArmError, KinematicsError) as error:
        return str(error)
    except Exception as flaw:  # reported, and not raised: the desk and its stop key must live on
        return f"a flaw of armdrive, please report it: {type(flaw).__name__}: {flaw}"
