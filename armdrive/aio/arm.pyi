"""What type checkers read of arm.py, written by tests/armdrive/aio/async_twin.py."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, Self, Unpack, overload

from armdrive.abilities import Abilities
from armdrive.aio.calls import AsyncCalls, AsyncConnection, AsyncHandle, Connecting
from armdrive.arm.device import Lines
from armdrive.arm.gripper import Gripper
from armdrive.arm.moving import Place
from armdrive.arm.reference import Accept, Told
from armdrive.config.arm import ArmConfig
from armdrive.dialog.operator import Operator, PostureRequest
from armdrive.motion.device import RowReport
from armdrive.motion.execute import Moved
from armdrive.motion.gripper import Grasped
from armdrive.motion.jog.session import Jogged
from armdrive.motion.plan import SpeedLimits
from armdrive.motion.preview import Preview
from armdrive.motion.reference import Verified
from armdrive.moves import (
    Angles,
    GraspMove,
    Jog,
    JogMove,
    JointAngles,
    JointJog,
    Motion,
    Move,
    MoveSequence,
    TipJog,
)
from armdrive.registry.pendant import PendantProgram
from armdrive.runtime.clock import PaceChoice
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.status import Status
from armdrive.storage.point_file import Points
from armdrive.tasks import DeviceSettings
from armdrive.trace.log import LogReader
from kinematics.paths.parts import PathPart
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose

class AsyncGripper(AsyncCalls[Gripper]):
    """The fingers of an arm: the calls of `Gripper`, awaited."""

    @property
    def opening_mm(self) -> float:
        """How far apart the fingers are: where the motors have them, or what keeps them apart."""
    @property
    def force_n(self) -> float:
        """The force of the grasp, from the steps behind the touch; 0 when let go."""
    async def open(self, opening_mm: float | None = ..., *, speed: float = ...) -> Moved:
        """Open to a width in mm, or all the way."""
    async def close(self, opening_mm: float = ..., *, speed: float = ...) -> Moved:
        """Close to a width in mm without feeling for an object; see `grasp`."""
    async def move(self, opening_mm: float, *, speed: float = ...) -> Moved:
        """Bring the fingers to an opening in mm."""
    async def grasp(self, *, force_n: float = ...) -> float:
        """Close on whatever is between the fingers; return its width in mm, 0.0 for nothing."""
    async def feel(self, *, force_n: float = ...) -> Grasped:
        """Like `grasp`, and also tell the force."""

class AsyncArm(AsyncConnection):
    """One arm, connected, for a program of coroutines; `sync` is the `Arm` itself.

    Each call is described at the call of that name of `Arm`. Whoever cancels an awaited call,
    `asyncio.timeout` too, stops the arm: the cancelling goes on once it stands. What never waits
    (`status`, `pause`, `estop`, ...) is not awaited.
    """

    @property
    def config(self) -> ArmConfig:
        """The arm's file."""
    @property
    def simulated(self) -> bool:
        """Whether it is a simulated arm."""
    @property
    def twin(self) -> SimulatedArm | None:
        """The simulated arm behind, with its physical world."""
    @property
    def gripper(self) -> AsyncGripper:
        """The fingers."""
    @classmethod
    def connect(
        cls,
        target: str | None = ...,
        *,
        dialect: str | None = ...,
        baud: int | None = ...,
        pace: PaceChoice = ...,
        allow_restored: bool = ...,
        operator: Operator | None = ...,
        twin: SimulatedArm | None = ...,
        reconnect: bool | None = ...,
    ) -> Connecting[Self]:
        """Connect as `Arm.connect` does: `await` it, or use it in `async with`.

        Simulated arms of one event loop live on one clock, unless `pace` says otherwise. What
        simulated time an arm needs passes while its calls are awaited, and not in `asyncio.sleep`.
        """
    async def reconnect(self) -> None:
        """Look for the lost wire once, by its USB serial number where it had one. Moves nothing."""
    @property
    def closed(self) -> bool:
        """Whether the connection was given back."""
    @property
    def reconnects(self) -> bool:
        """Whether a lost wire is looked for without anybody asking, until it is back."""
    async def enable(self) -> None:
        """Switch the motors on where that can be done, and allow motion. Moves nothing."""
    async def disable(self) -> None:
        """Switch the motor current off: **the arm can sag**, so `park` first."""
    async def reset(self) -> None:
        """Leave error-stop: wait until the line is quiet and read the registers. Moves nothing."""
    async def home(self, *, operator: Operator | None = ..., told: Told = ...) -> Pose:
        """Take the reference posture, which an operator has to confirm; return its pose."""
    async def confirm_reference(self) -> None:
        """Say that the arm stands in its reference posture now."""
    async def declare_posture(self, posture: Joints | Pose, *, opening_mm: float = ...) -> None:
        """Say that the arm stands in this posture now, by joints or by pose."""
    async def confirm_restored(self) -> None:
        """Say that the arm stands as its record shows it: planned motion is allowed again."""
    def reference_request(self) -> PostureRequest:
        """Return the posture that a reference is taken in."""
    async def verify(
        self, *, operator: Operator | None = ..., accept: Accept = ..., speed: float = ...
    ) -> Verified:
        """Measure how far the registers are from what the reference posture should read."""
    @overload
    async def run(self, move: Motion) -> Moved:
        """Carry out a move and wait for its end: `run(LineMove(pose, speed=0.5))`."""
    @overload
    async def run(self, move: GraspMove) -> Grasped: ...
    @overload
    async def run(self, move: JogMove) -> Jogged: ...
    @overload
    async def run(self, move: MoveSequence) -> Moved | Grasped: ...
    @overload
    async def start(self, move: Motion, *, stops: int | None = ...) -> AsyncHandle[Moved]:
        """Begin a move, and return a `Handle` that waits for its end or cancels it."""
    @overload
    async def start(self, move: GraspMove, *, stops: int | None = ...) -> AsyncHandle[Grasped]: ...
    @overload
    async def start(self, move: JogMove, *, stops: int | None = ...) -> AsyncHandle[Jogged]: ...
    @overload
    async def start(
        self, move: MoveSequence, *, stops: int | None = ...
    ) -> AsyncHandle[Moved | Grasped]: ...
    async def preview(self, move: Move) -> Preview:
        """Return what a move would be, or why it is refused. Sends nothing, moves nothing."""
    @overload
    async def move_j(
        self,
        angles_deg: Angles | None = ...,
        /,
        *,
        speed: float = ...,
        wait: Literal[True] = ...,
        **joints_deg: Unpack[JointAngles],
    ) -> Moved:
        """Move the named joints, `shoulder_deg=40, elbow_deg=-60`; the others stay."""
    @overload
    async def move_j(
        self,
        angles_deg: Angles | None = ...,
        /,
        *,
        speed: float = ...,
        wait: Literal[False],
        **joints_deg: Unpack[JointAngles],
    ) -> AsyncHandle[Moved]: ...
    @overload
    async def move_to(
        self, goal: Place, *, speed: float = ..., frame: str = ..., wait: Literal[True] = ...
    ) -> Moved:
        """Move the tip to a pose by a joint motion, to the posture nearest to the present one."""
    @overload
    async def move_to(
        self, goal: Place, *, speed: float = ..., frame: str = ..., wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    @overload
    async def move_l(
        self, goal: Place, *, speed: float = ..., frame: str = ..., wait: Literal[True] = ...
    ) -> Moved:
        """Move the tip to a pose, or to a named point's, along a straight line."""
    @overload
    async def move_l(
        self, goal: Place, *, speed: float = ..., frame: str = ..., wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    @overload
    async def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = ...,
        frame: str = ...,
        wait: Literal[True] = ...,
    ) -> Moved:
        """Move the tip along the arc of a circle, through `via`, to a pose."""
    @overload
    async def move_c(
        self, via: Pose, goal: Pose, *, speed: float = ..., frame: str = ..., wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    @overload
    async def move_path(
        self,
        parts: Sequence[PathPart],
        *,
        speed: float = ...,
        frame: str = ...,
        wait: Literal[True] = ...,
    ) -> Moved:
        """Move through several parts as one: `LinePart`, `ArcPart`, `PosePart`, `JointPart`."""
    @overload
    async def move_path(
        self,
        parts: Sequence[PathPart],
        *,
        speed: float = ...,
        frame: str = ...,
        wait: Literal[False],
    ) -> AsyncHandle[Moved]: ...
    async def move_gripper(self, opening_mm: float, speed: float = ...) -> Moved:
        """Bring the fingers to an opening in mm; `arm.gripper` knows more of them."""
    async def park(self, *, speed: float = ...) -> Moved:
        """Go to the park posture of the arm file; by default, 30 mm above the reference mark."""
    async def move_motors(self, *steps: int, speed: float = ..., stops: int | None = ...) -> Moved:
        """Move each motor by whole steps from where it is, all together: for the bench."""
    @property
    def points(self) -> Points:
        """The named points of this arm, a mapping over its file: `arm.points["pick"]`."""
    async def jog_j(
        self,
        amounts: Angles | None = ...,
        /,
        *,
        speed: float = ...,
        duration_s: float | None = ...,
        **axes: Unpack[JointJog],
    ) -> Jogged:
        """Jog joints: by increments, `shoulder_deg=2, gripper_mm=5`, or for a time."""
    async def jog_l(
        self,
        amounts: Angles | None = ...,
        /,
        *,
        speed: float = ...,
        duration_s: float | None = ...,
        frame: str = ...,
        **axes: Unpack[TipJog],
    ) -> Jogged:
        """Jog the tip: by increments, `x_mm=5, pitch_deg=-2`, or for a time, `x=1`."""
    def hold(self, jog: Jog, *, speed: float, for_s: float) -> None:
        """Jog for `for_s` seconds and no longer unless called again; never waits."""
    def nudge(self, jog: Jog, *, speed: float) -> None:
        """Jog by one increment; at most one more waits behind the one under way. Never waits."""
    def release(self) -> None:
        """End a held jog: what is queued is given up; a burst under way is the last."""
    async def stop(self) -> None:
        """Stop, and wait until the arm stands. Legal in every state, from any thread."""
    def estop(self) -> None:
        """Stop and latch error-stop; does not wait. Only `reset` leaves it, and moves nothing."""
    def request_stop(self, *, hard: bool = ...) -> None:
        """Ask for a stop and return at once: the one call that a signal handler may make."""
    @property
    def stops(self) -> int:
        """How often a stop was asked for: what was decided on before the latest is not begun."""
    async def sleep(self, time_s: float) -> None:
        """Let time pass on the arm's own clock."""
    def pause(self) -> None:
        """Have the arm stand behind its next burst or segment, until `resume` or a stop."""
    def resume(self) -> None:
        """Let a paused arm go on. Nothing goes on that an error, a stop or a lost wire ended."""
    @property
    def paused(self) -> bool:
        """Whether somebody wants the arm to wait: `status.paused`, cheap to ask for."""
    @property
    def speed_override(self) -> float:
        """The share of the speed asked for that the arm goes with, from 0.01 to 1."""
    @speed_override.setter
    def speed_override(self, speed_override: float) -> None: ...
    @property
    def status(self) -> Status:
        """A frozen picture of this moment."""
    @property
    def joints(self) -> Joints:
        """The acknowledged joint angles. Raises `NotReferenced` while the position is unknown."""
    @property
    def pose(self) -> Pose:
        """The acknowledged pose. Raises `NotReferenced` while the position is unknown."""
    def pose_in(self, frame: str) -> Pose:
        """The acknowledged pose as the base or a frame of the arm file sees it."""
    @property
    def frames(self) -> tuple[str, ...]:
        """The frames that goals and jogs can be meant in: base, tool, and the arm file's."""
    @property
    def model(self) -> ArmModel:
        """The arm's model: geometry, limits, transmission, reference posture."""
    @property
    def speeds(self) -> SpeedLimits:
        """The limits that time is computed from; a device may tell its own once it is connected."""
    @property
    def abilities(self) -> Abilities:
        """What the arm's controller can do."""
    async def read_inputs(self) -> int:
        """Read the input bits now."""
    async def wait_inputs(
        self, *, high: Lines = ..., low: Lines = ..., within_s: float | None = ...
    ) -> int:
        """Wait until inputs, counted from 1, are high and low; return the input bits."""
    async def set_output(self, number: int, on: bool = ...) -> None:
        """Switch one output, counted from 1; the others stay. Moves nothing."""
    async def set_outputs(self, bits: int) -> None:
        """Write the output bits. Moves nothing."""
    async def read_pendant_program(self) -> PendantProgram:
        """Read the program in the arm's own memory; takes some seconds, and moves nothing."""
    async def write_pendant_program(
        self, program: PendantProgram, *, leave_others: bool = ..., told: RowReport = ...
    ) -> int:
        """Write a program into the arm's memory, and read it back; moves nothing."""
    async def mend_settings(self, lines: Sequence[str] | None = ...) -> DeviceSettings:
        """Write the lines that bring the device's settings to what the arm file says."""
    async def save_recording(self, path: Path | str | None = ...) -> Path:
        """Write what the flight recorder holds, and return the file."""
    def log(self, *, back: int | None = ...) -> LogReader:
        """Return a reader of what passes on the wire and in the driver, in words."""
