"""What type checkers read of this package, from tests/armdrive/aio/async_twin.py."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, Self, Unpack, overload

from armdrive.abilities import Abilities
from armdrive.aio.calls import AsyncCalls, AsyncConnection, AsyncHandle, Connecting
from armdrive.arm.connected import Recorder
from armdrive.arm.device import ControllerMemory, InputsOutputs, Lines
from armdrive.arm.jogging import Jogging
from armdrive.arm.moving import Gripper, Place
from armdrive.arm.reference import Accept, ArmReference, GroupReport
from armdrive.config.arm import ArmConfig
from armdrive.connect.connection import ProgramView
from armdrive.connect.parts import Parts
from armdrive.dialog import Operator, PostureRequest
from armdrive.motion.execute import Moved
from armdrive.motion.gripper import Grasped
from armdrive.motion.jog import Jogged
from armdrive.motion.preview import Preview
from armdrive.motion.reference import Verified
from armdrive.moves import (
    Angles,
    GraspMove,
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
from kinematics.paths.routes import PathPart
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose

class AsyncGripper(AsyncCalls[Gripper]):
    """The gripper of an arm: the calls of `Gripper`, as coroutines."""

    @property
    def opening_mm(self) -> float:
        """The distance between the fingers, from the motors or the width of a gripped object."""
    @property
    def force_n(self) -> float:
        """The gripping force, computed from the motor steps after contact; 0 without a grasp."""
    async def open(self, opening_mm: float | None = ..., *, speed: float = ...) -> Moved:
        """Open the fingers to a width in mm, or all the way."""
    async def close(self, opening_mm: float = ..., *, speed: float = ...) -> Moved:
        """Close the fingers to a width in mm. To detect an object, use `grasp`."""
    async def grasp(self, *, force_n: float = ...) -> float:
        """Close the fingers on an object; return its width in mm, or 0.0 if there is none."""

class AsyncInputsOutputs(AsyncCalls[InputsOutputs]):
    """The inputs and outputs of an arm: the calls of `InputsOutputs`, as coroutines."""

    async def read(self) -> int:
        """Read the input bits now. Raises `Refused` if the arm has no inputs."""
    async def wait(
        self, *, high: Lines = ..., low: Lines = ..., within_s: float | None = ...
    ) -> int:
        """Wait until the given inputs, counted from 1, are high or low; return the input bits."""
    async def set(self, number: int, on: bool = ...) -> None:
        """Switch one output, counted from 1; the others stay. Moves nothing."""
    async def write(self, bits: int) -> None:
        """Write all the output bits. Moves nothing."""

class AsyncReference(AsyncCalls[ArmReference]):
    """The reference of an arm: the calls of `ArmReference`, as coroutines."""

    @property
    def homes_by_switches(self) -> bool:
        """Whether `home` moves the arm, because its controller seeks switches."""
    @property
    def homing_groups(self) -> tuple[tuple[str, ...], ...]:
        """The motor names of each homing group, in order; empty if the device decides."""
    @property
    def homing_words(self) -> str:
        """What `home` makes the controller do, its bound, and which of its settings differ."""
    @property
    def unconfirmed(self) -> bool:
        """Whether planned motion has to wait until an operator confirms the restored position."""
    def request(self) -> PostureRequest:
        """Return the posture in which the arm is referenced."""
    async def confirm(self) -> None:
        """Declare that the arm now stands in its reference posture."""
    async def declare(self, posture: Joints | Pose, *, opening_mm: float = ...) -> None:
        """Declare that the arm now stands in this posture, given by its joints or its pose."""
    async def confirm_restored(self) -> None:
        """Confirm that the arm stands at the restored position; planned motion is allowed again."""
    async def verify(
        self, *, operator: Operator | None = ..., accept: Accept = ..., speed: float = ...
    ) -> Verified:
        """Measure how far the position has drifted, at the reference mark."""

class AsyncControllerMemory(AsyncCalls[ControllerMemory]):
    """What the controller stores: the calls of `ControllerMemory`, as coroutines."""

    async def read_program(self) -> PendantProgram:
        """Read the program in the arm's own memory; takes a few seconds and moves nothing."""
    async def write_program(self, program: PendantProgram, *, leave_others: bool = ...) -> int:
        """Write a program into the arm's memory and read it back; moves nothing."""
    async def fix_settings(self, lines: Sequence[str] | None = ...) -> DeviceSettings:
        """Write the lines that set the device as the arm file expects. Moves nothing."""

class AsyncRecorder(AsyncCalls[Recorder]):
    """The flight recorder of an arm: the calls of `Recorder`, as coroutines."""

    async def save(self, path: Path | str | None = ..., *, overwrite: bool = ...) -> Path:
        """Save the contents of the flight recorder, and return the path of the file."""
    def log(self, *, back: int | None = ...) -> LogReader:
        """Return a reader of the log: the traffic on the wire and the driver's events, in words."""

class AsyncArm(AsyncConnection):
    """A connected arm for asyncio programs; `sync` is the underlying `Arm`.

    `Arm` documents each call. Cancelling an awaited call, also with `asyncio.timeout`, stops the
    arm; `CancelledError` follows once the arm stands. Calls that never wait (`status`, `pause`,
    `estop`, `jogging.hold`, ...) are not awaited.
    """

    @property
    def config(self) -> ArmConfig:
        """The contents of the arm file."""
    @property
    def simulated(self) -> bool:
        """Whether the arm is simulated."""
    @property
    def twin(self) -> SimulatedArm | None:
        """The simulated device, with its physical world."""
    @property
    def gripper(self) -> AsyncGripper:
        """The fingers."""
    @property
    def io(self) -> AsyncInputsOutputs:
        """The inputs and outputs."""
    @property
    def reference(self) -> AsyncReference:
        """What the position rests on."""
    @property
    def controller(self) -> AsyncControllerMemory:
        """What the controller stores."""
    @property
    def recorder(self) -> AsyncRecorder:
        """The flight recorder."""
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
        """Connect like `Arm.connect`: `await` the call, or use it in `async with`.

        Simulated arms of one event loop share a clock, unless `pace` says otherwise. Simulated
        time passes while an arm's calls are awaited, but not in `asyncio.sleep`.
        """
    async def reconnect(self) -> None:
        """Try once to restore a lost connection; a USB port is found by its serial number."""
    @property
    def closed(self) -> bool:
        """Whether the connection is closed."""
    @property
    def reconnects(self) -> bool:
        """Whether a lost connection is restored automatically."""
    @property
    def program(self) -> ProgramView | None:
        """Describes the running program to other processes; None if none is running."""
    @program.setter
    def program(self, program: ProgramView | None) -> None: ...
    async def enable(self) -> None:
        """Switch the motors on, if the device has a switch for them, and allow motion."""
    async def disable(self) -> None:
        """Switch the motor current off: **the arm can sag**, so `park` first."""
    async def reset(self) -> None:
        """Leave error-stop: wait until the line is quiet and read the registers. Moves nothing."""
    async def home(
        self, *, operator: Operator | None = ..., report: GroupReport = ..., stops: int | None = ...
    ) -> Pose:
        """Reference the arm, by its homing switches or by an operator; return its pose."""
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
        """Start a move, and return a `Handle` to wait for its end or to cancel it."""
    @overload
    async def start(self, move: GraspMove, *, stops: int | None = ...) -> AsyncHandle[Grasped]: ...
    @overload
    async def start(self, move: JogMove, *, stops: int | None = ...) -> AsyncHandle[Jogged]: ...
    @overload
    async def start(
        self, move: MoveSequence, *, stops: int | None = ...
    ) -> AsyncHandle[Moved | Grasped]: ...
    async def preview(self, move: Move) -> Preview:
        """Return what a move would do, or why it is refused. Sends nothing, moves nothing."""
    @overload
    async def move_j(
        self,
        goal: Joints | Angles | None = ...,
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
        goal: Joints | Angles | None = ...,
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
        """Move the tip to a pose by a joint motion, to the posture nearest to the current one."""
    @overload
    async def move_to(
        self, goal: Place, *, speed: float = ..., frame: str = ..., wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    @overload
    async def move_l(
        self, goal: Place, *, speed: float = ..., frame: str = ..., wait: Literal[True] = ...
    ) -> Moved:
        """Move the tip along a straight line to the pose of a goal like that of `move_to`."""
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
        """Move the tip along a circular arc through `via` to a pose."""
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
        """Move along a path of several parts: `LinePart`, `ArcPart`, `PosePart`, `JointPart`."""
    @overload
    async def move_path(
        self,
        parts: Sequence[PathPart],
        *,
        speed: float = ...,
        frame: str = ...,
        wait: Literal[False],
    ) -> AsyncHandle[Moved]: ...
    async def park(self, *, speed: float = ...) -> Moved:
        """Move to the arm file's park posture, by default 30 mm above the reference mark."""
    async def move_motors(self, *steps: int, speed: float = ..., stops: int | None = ...) -> Moved:
        """Move all motors together, each by whole steps: for tests at the bench."""
    @property
    def points(self) -> Points:
        """The arm's named points, a mapping that is stored in a file: `arm.points["pick"]`."""
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
    @property
    def jogging(self) -> Jogging:
        """Jogs for keys and sticks, which no call waits for: `jogging.hold(...)`."""
    async def stop(self) -> None:
        """Stop, and wait until the arm stands. Allowed in every state and from any thread."""
    def estop(self) -> None:
        """Stop, latch error-stop, and return at once. Only `reset` leaves error-stop."""
    def request_stop(self, *, hard: bool = ...) -> None:
        """Request a stop and return at once. A signal handler may call nothing but this."""
    @property
    def stops(self) -> int:
        """The number of stops requested so far; see `start`."""
    async def sleep(self, time_s: float) -> None:
        """Wait on the arm's own clock, for at most 1,000,000 s."""
    def pause(self) -> None:
        """Pause the arm after its current burst or segment, until `resume` or a stop."""
    def resume(self) -> None:
        """Resume a paused arm. A motion ended by an error, a stop or a lost link stays ended."""
    @property
    def speed_override(self) -> float:
        """The factor, from 0.01 to 1, by which the arm slows every requested speed."""
    @speed_override.setter
    def speed_override(self, speed_override: float) -> None: ...
    @property
    def status(self) -> Status:
        """A frozen snapshot of the arm."""
    @property
    def joints(self) -> Joints:
        """The acknowledged joint angles. Raises `NotReferenced` while the position is unknown."""
    @property
    def pose(self) -> Pose:
        """The acknowledged pose. Raises `NotReferenced` while the position is unknown."""
    def pose_in(self, frame: str) -> Pose:
        """Return the acknowledged pose in the base frame or in a frame of the arm file."""
    @property
    def frames(self) -> tuple[str, ...]:
        """The frames available to goals and jogs: base, tool, and those of the arm file."""
    @property
    def model(self) -> ArmModel:
        """The arm's model: geometry, limits, transmission, reference posture."""
    @property
    def abilities(self) -> Abilities:
        """The capabilities of the arm's controller."""
    @property
    def parts(self) -> Parts:
        """The machinery of the connection, for armdrive's own commands; no program needs it."""
