"""`AsyncArm`: an arm whose calls are awaited, each the twin of a call of `Arm`.

Written by `python tests/armdrive/aio/async_twin.py` from the calls of `Arm`: change those instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, Self, Unpack, overload

from armdrive.abilities import Abilities
from armdrive.aio.calls import (
    AsyncCalls,
    AsyncConnection,
    AsyncHandle,
    Connecting,
    at_once,
    awaited,
    begun,
)
from armdrive.arm import Arm
from armdrive.arm.arguments import RULES
from armdrive.arm.gripper import Gripper
from armdrive.arm.places import Place
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import ConnectOptions
from armdrive.dialog.operator import Operator
from armdrive.errors.arguments import checked_calls
from armdrive.motion.execute import Moved
from armdrive.motion.gripper import Grasped
from armdrive.motion.jog.session import Jogged
from armdrive.motion.segments import SpeedLimits
from armdrive.moves import (
    BASE_FRAME,
    Angles,
    GraspMove,
    JogMove,
    JointAngles,
    Motion,
    Move,
    MoveSequence,
)
from armdrive.runtime.drive import PaceChoice
from armdrive.status import Status
from armdrive.storage.point_file import Points
from kinematics.paths.parts import PathPart
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose

if TYPE_CHECKING:  # a real arm loads no simulation
    from armdrive.sim.simulated_arm import SimulatedArm


class AsyncGripper(AsyncCalls[Gripper]):
    """The fingers of an arm: the calls of `Gripper`, awaited."""

    @property
    def opening_mm(self) -> float:
        """How far apart the fingers are: where the motors have them, or what keeps them apart."""
        return self.sync.opening_mm

    @property
    def force_n(self) -> float:
        """The force of the grasp, from the steps behind the touch; 0 when let go."""
        return self.sync.force_n

    open = awaited(Gripper.open)
    close = awaited(Gripper.close)
    move = awaited(Gripper.move)
    grasp = awaited(Gripper.grasp)
    feel = awaited(Gripper.feel)


@checked_calls(RULES)
class AsyncArm(AsyncConnection):
    """One arm, connected, for a program of coroutines; `sync` is the `Arm` itself.

    Each call is described at the call of that name of `Arm`. Whoever cancels an awaited call,
    `asyncio.timeout` too, stops the arm: the cancelling goes on once it stands. What never waits
    (`status`, `pause`, `estop`, ...) is not awaited.
    """

    @property
    def config(self) -> ArmConfig:
        """The arm's file."""
        return self.sync.config

    @property
    def simulated(self) -> bool:
        """Whether it is a simulated arm."""
        return self.sync.simulated

    @property
    def twin(self) -> SimulatedArm | None:
        """The simulated arm behind, with its physical world."""
        return self.sync.twin

    @property
    def closed(self) -> bool:
        """Whether the connection was given back."""
        return self.sync.closed

    @property
    def reconnects(self) -> bool:
        """Whether a lost wire is looked for without anybody asking, until it is back."""
        return self.sync.reconnects

    @property
    def gripper(self) -> AsyncGripper:
        """The fingers."""
        return AsyncGripper(self.sync.gripper, self._arm)

    @property
    def points(self) -> Points:
        """The named points of this arm, a mapping over its file: `arm.points["pick"]`."""
        return self.sync.points

    @property
    def stops(self) -> int:
        """How often a stop was asked for: what was decided on before the latest is not begun."""
        return self.sync.stops

    @property
    def paused(self) -> bool:
        """Whether somebody wants the arm to wait: `status.paused`, cheap to ask for."""
        return self.sync.paused

    @property
    def speed_override(self) -> float:
        """The share of the speed asked for that the arm goes with, from 0.01 to 1."""
        return self.sync.speed_override

    @speed_override.setter
    def speed_override(self, speed_override: float) -> None:
        self.sync.speed_override = speed_override

    @property
    def status(self) -> Status:
        """A frozen picture of this moment."""
        return self.sync.status

    @property
    def joints(self) -> Joints:
        """The acknowledged joint angles. Raises `NotReferenced` while the position is unknown."""
        return self.sync.joints

    @property
    def pose(self) -> Pose:
        """The acknowledged pose. Raises `NotReferenced` while the position is unknown."""
        return self.sync.pose

    @property
    def frames(self) -> tuple[str, ...]:
        """The frames that goals and jogs can be meant in: base, tool, and the arm file's."""
        return self.sync.frames

    @property
    def model(self) -> ArmModel:
        """The arm's model: geometry, limits, transmission, reference posture."""
        return self.sync.model

    @property
    def speeds(self) -> SpeedLimits:
        """The limits that time is computed from; a device may tell its own once it is connected."""
        return self.sync.speeds

    @property
    def abilities(self) -> Abilities:
        """What the arm's controller can do."""
        return self.sync.abilities

    @classmethod
    def connect(
        cls,
        target: str | None = None,
        *,
        dialect: str | None = None,
        baud: int | None = None,
        pace: PaceChoice = None,
        allow_restored: bool = False,
        operator: Operator | None = None,
        twin: SimulatedArm | None = None,
        reconnect: bool | None = None,
    ) -> Connecting[Self]:
        """Connect as `Arm.connect` does: `await` it, or use it in `async with`.

        Simulated arms of one event loop live on one clock, unless `pace` says otherwise. What
        simulated time an arm needs passes while its calls are awaited, and not in `asyncio.sleep`.
        """
        options = ConnectOptions(
            dialect=dialect,
            baud=baud,
            pace=pace,
            allow_restored=allow_restored,
            operator=operator,
            twin=twin,
            reconnect=reconnect,
        )
        return Connecting(cls, target, options)

    _run = awaited(Arm.run)

    @overload
    async def run(self, move: Motion) -> Moved: ...
    @overload
    async def run(self, move: GraspMove) -> Grasped: ...
    @overload
    async def run(self, move: JogMove) -> Jogged: ...
    @overload
    async def run(self, move: MoveSequence) -> Moved | Grasped: ...
    async def run(self, move: Move) -> Moved | Grasped | Jogged:
        """Carry out a move and wait for its end: `run(LineMove(pose, speed=0.5))`."""
        return await self._run(move)

    _start = begun(Arm.start)

    @overload
    async def start(self, move: Motion, *, stops: int | None = None) -> AsyncHandle[Moved]: ...
    @overload
    async def start(self, move: GraspMove, *, stops: int | None = None) -> AsyncHandle[Grasped]: ...
    @overload
    async def start(self, move: JogMove, *, stops: int | None = None) -> AsyncHandle[Jogged]: ...
    @overload
    async def start(
        self, move: MoveSequence, *, stops: int | None = None
    ) -> AsyncHandle[Moved | Grasped]: ...
    async def start(
        self, move: Move, *, stops: int | None = None
    ) -> AsyncHandle[Moved | Grasped | Jogged]:
        """Begin a move, and return a `Handle` that waits for its end or cancels it."""
        return await self._start(move, stops=stops)

    @overload
    async def move_j(
        self,
        angles_deg: Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: Literal[True] = True,
        **joints_deg: Unpack[JointAngles],
    ) -> Moved: ...
    @overload
    async def move_j(
        self,
        angles_deg: Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: Literal[False],
        **joints_deg: Unpack[JointAngles],
    ) -> AsyncHandle[Moved]: ...
    async def move_j(
        self,
        angles_deg: Angles | None = None,
        /,
        *,
        speed: float = 1.0,
        wait: bool = True,
        **joints_deg: Unpack[JointAngles],
    ) -> Moved | AsyncHandle[Moved]:
        """Move the named joints, `shoulder_deg=40, elbow_deg=-60`; the others stay."""
        return await self._begin(
            lambda: self.sync.move_j(angles_deg, speed=speed, wait=False, **joints_deg), wait
        )

    @overload
    async def move_to(
        self,
        goal: Place,
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    async def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE_FRAME, wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    async def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE_FRAME, wait: bool = True
    ) -> Moved | AsyncHandle[Moved]:
        """Move the tip to a pose by a joint motion, to the posture nearest to the present one."""
        return await self._begin(
            lambda: self.sync.move_to(goal, speed=speed, frame=frame, wait=False), wait
        )

    @overload
    async def move_l(
        self,
        goal: Place,
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    async def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE_FRAME, wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    async def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE_FRAME, wait: bool = True
    ) -> Moved | AsyncHandle[Moved]:
        """Move the tip to a pose, or to a named point's, along a straight line."""
        return await self._begin(
            lambda: self.sync.move_l(goal, speed=speed, frame=frame, wait=False), wait
        )

    @overload
    async def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    async def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[False],
    ) -> AsyncHandle[Moved]: ...
    async def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: bool = True,
    ) -> Moved | AsyncHandle[Moved]:
        """Move the tip along the arc of a circle, through `via`, to a pose."""
        return await self._begin(
            lambda: self.sync.move_c(via, goal, speed=speed, frame=frame, wait=False), wait
        )

    @overload
    async def move_path(
        self,
        parts: Sequence[PathPart],
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    async def move_path(
        self,
        parts: Sequence[PathPart],
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: Literal[False],
    ) -> AsyncHandle[Moved]: ...
    async def move_path(
        self,
        parts: Sequence[PathPart],
        *,
        speed: float = 1.0,
        frame: str = BASE_FRAME,
        wait: bool = True,
    ) -> Moved | AsyncHandle[Moved]:
        """Move through several parts as one: `LinePart`, `ArcPart`, `PosePart`, `JointPart`."""
        return await self._begin(
            lambda: self.sync.move_path(parts, speed=speed, frame=frame, wait=False), wait
        )

    reconnect = awaited(Arm.reconnect)
    enable = awaited(Arm.enable)
    disable = awaited(Arm.disable)
    reset = awaited(Arm.reset)
    home = awaited(Arm.home)
    confirm_reference = awaited(Arm.confirm_reference)
    declare_posture = awaited(Arm.declare_posture)
    confirm_restored = awaited(Arm.confirm_restored)
    reference_request = at_once(Arm.reference_request)
    verify = awaited(Arm.verify)
    preview = awaited(Arm.preview)
    move_gripper = awaited(Arm.move_gripper)
    park = awaited(Arm.park)
    move_motors = awaited(Arm.move_motors)
    jog_j = awaited(Arm.jog_j)
    jog_l = awaited(Arm.jog_l)
    hold = at_once(Arm.hold)
    nudge = at_once(Arm.nudge)
    release = at_once(Arm.release)
    stop = awaited(Arm.stop)
    estop = at_once(Arm.estop)
    request_stop = at_once(Arm.request_stop)
    sleep = awaited(Arm.sleep)
    pause = at_once(Arm.pause)
    resume = at_once(Arm.resume)
    pose_in = at_once(Arm.pose_in)
    read_inputs = awaited(Arm.read_inputs)
    wait_inputs = awaited(Arm.wait_inputs)
    set_output = awaited(Arm.set_output)
    set_outputs = awaited(Arm.set_outputs)
    read_pendant_program = awaited(Arm.read_pendant_program)
    write_pendant_program = awaited(Arm.write_pendant_program)
    mend_settings = awaited(Arm.mend_settings)
    save_recording = awaited(Arm.save_recording)
    log = at_once(Arm.log)
