"""`AsyncArm`: an arm whose calls are awaited, each the twin of the call of that name of `Arm`."""

from __future__ import annotations

import functools
from collections.abc import Callable, Coroutine, Generator, Sequence
from functools import partial
from types import TracebackType
from typing import (
    TYPE_CHECKING,
    Any,
    Concatenate,
    Generic,
    Literal,
    ParamSpec,
    Protocol,
    Self,
    TypeVar,
    Unpack,
    overload,
)

from armdrive.abilities import Abilities
from armdrive.aio.loop import goes_in_turn, stage
from armdrive.arm import Arm, anybody
from armdrive.arm.arguments import RULES
from armdrive.arm.gripper import Gripper
from armdrive.arm.handle import Handle
from armdrive.arm.places import Place
from armdrive.config.arm import ArmConfig
from armdrive.connect.target import SIM, simulation_forced
from armdrive.errors.arguments import BASIC, checked_calls
from armdrive.motion.execute import Moved
from armdrive.motion.jog.session import Jogged
from armdrive.motion.preview import Preview
from armdrive.motion.resolve import BASE
from armdrive.motion.segments import SpeedLimits
from armdrive.moves import BASE_FRAME, Angles, JointAngles, JointJog, TipJog
from armdrive.operator import Operator
from armdrive.runtime.drive import PaceChoice
from armdrive.status import Status
from armdrive.storage.point_file import Points
from kinematics.paths.parts import Move
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose

if TYPE_CHECKING:  # a real arm loads no simulation
    from armdrive.sim.simulated_arm import SimulatedArm


# A motion under way, as a coroutine sees it.

T = TypeVar("T")
R = TypeVar("R")


class Carry(Protocol):
    """Carries a call of an arm out for the event loop."""

    def __call__(self, call: Callable[[], R], /) -> Coroutine[Any, Any, R]:
        """Return what is to be awaited."""
        ...


@checked_calls(BASIC)
class AsyncHandle(Generic[T]):
    """A motion under way, from an awaited call with `wait=False`."""

    def __init__(self, sync: Handle[T], carry: Carry) -> None:
        self.sync = sync
        self._carry = carry

    @property
    def done(self) -> bool:
        """Whether the motion has ended, well or not."""
        return self.sync.done

    async def wait(self, timeout_s: float | None = None) -> T:
        """Wait for the end and return what was done, or raise what went wrong.

        Raises `WaitTimeout` after `timeout_s` of the arm's own time; the motion goes on. Who
        cancels this wait stops the arm.
        """
        return await self._carry(lambda: self.sync.wait(timeout_s))

    async def cancel(self) -> None:
        """Stop the motion, and wait until the arm stands."""
        await self._carry(self.sync.cancel)


# How a call becomes its async twin, with the same name and the same typed signature.

S = TypeVar("S", covariant=True)
P = ParamSpec("P")


class AsyncCalls(Generic[S]):
    """The async twin of an arm or of a part of it. `sync` is what it is the twin of."""

    def __init__(self, sync: S, arm: Arm) -> None:
        self.sync = sync
        self._arm = arm

    async def carry(self, call: Callable[[], R]) -> R:
        """Carry out a call; cancelling it stops the arm."""
        return await stage().carry(call, self._arm)


def awaited(
    method: Callable[Concatenate[S, P], R],
) -> Callable[Concatenate[AsyncCalls[S], P], Coroutine[Any, Any, R]]:
    """Make the twin of a call that waits for the arm, or takes long to compute."""

    @functools.wraps(method)
    async def call(self: AsyncCalls[S], /, *words: P.args, **named: P.kwargs) -> R:
        return await self.carry(functools.partial(method, self.sync, *words, **named))

    return call


def begun(
    method: Callable[Concatenate[S, P], Handle[R]],
) -> Callable[Concatenate[AsyncCalls[S], P], Coroutine[Any, Any, AsyncHandle[R]]]:
    """Make the twin of a call that begins a motion and returns its handle."""

    @functools.wraps(method)
    async def call(self: AsyncCalls[S], /, *words: P.args, **named: P.kwargs) -> AsyncHandle[R]:
        handle = await self.carry(functools.partial(method, self.sync, *words, **named))
        return AsyncHandle(handle, self.carry)

    return call


def at_once(
    method: Callable[Concatenate[S, P], R],
) -> Callable[Concatenate[AsyncCalls[S], P], R]:
    """Make the twin of a call that never waits: it is the same call, and is not awaited."""

    @functools.wraps(method)
    def call(self: AsyncCalls[S], /, *words: P.args, **named: P.kwargs) -> R:
        return method(self.sync, *words, **named)

    return call


# The async twin of an arm's gripper.


class AsyncGripper(AsyncCalls[Gripper]):
    """The fingers of an arm: the calls of `Gripper`, awaited."""

    @property
    def opening_mm(self) -> float:
        """How far apart the fingers are; see `Gripper.opening_mm`."""
        return self.sync.opening_mm

    @property
    def force_n(self) -> float:
        """The force of the grasp; 0 when let go."""
        return self.sync.force_n

    open = awaited(Gripper.open)
    close = awaited(Gripper.close)
    move = awaited(Gripper.move)
    grasp = awaited(Gripper.grasp)
    feel = awaited(Gripper.feel)


# The async twins of the calls whose keyword arguments or `wait=` need a signature in full.


class AsyncMoves(AsyncCalls[Arm]):
    """The motions with `wait=`; what each does stands at its namesake of `Arm`."""

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
        """Move the named joints; see `Arm.move_j`."""
        return await self._go(
            lambda: self.sync.move_j(angles_deg, speed=speed, wait=False, **joints_deg), wait
        )

    @overload
    async def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[True] = True
    ) -> Moved: ...
    @overload
    async def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    async def move_to(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | AsyncHandle[Moved]:
        """Move the tip to a pose by a joint motion; see `Arm.move_to`."""
        return await self._go(
            lambda: self.sync.move_to(goal, speed=speed, frame=frame, wait=False), wait
        )

    @overload
    async def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[True] = True
    ) -> Moved: ...
    @overload
    async def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    async def move_l(
        self, goal: Place, *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | AsyncHandle[Moved]:
        """Move the tip to a pose along a straight line; see `Arm.move_l`."""
        return await self._go(
            lambda: self.sync.move_l(goal, speed=speed, frame=frame, wait=False), wait
        )

    @overload
    async def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = 1.0,
        frame: str = BASE,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    async def move_c(
        self, via: Pose, goal: Pose, *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    async def move_c(
        self, via: Pose, goal: Pose, *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | AsyncHandle[Moved]:
        """Move the tip along an arc, through `via`; see `Arm.move_c`."""
        return await self._go(
            lambda: self.sync.move_c(via, goal, speed=speed, frame=frame, wait=False), wait
        )

    @overload
    async def move_path(
        self,
        moves: Sequence[Move],
        *,
        speed: float = 1.0,
        frame: str = BASE,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    async def move_path(
        self, moves: Sequence[Move], *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> AsyncHandle[Moved]: ...
    async def move_path(
        self, moves: Sequence[Move], *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | AsyncHandle[Moved]:
        """Move through several moves as one; see `Arm.move_path`."""
        return await self._go(
            lambda: self.sync.move_path(moves, speed=speed, frame=frame, wait=False), wait
        )

    async def jog_j(
        self,
        amounts: Angles | None = None,
        /,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        **axes: Unpack[JointJog],
    ) -> Jogged:
        """Jog joints, by increments or for a time; see `Arm.jog_j`."""
        return await self.carry(
            lambda: self.sync.jog_j(amounts, speed=speed, duration_s=duration_s, **axes)
        )

    async def jog_l(
        self,
        amounts: Angles | None = None,
        /,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        frame: str = BASE_FRAME,
        **axes: Unpack[TipJog],
    ) -> Jogged:
        """Jog the tip, by increments or for a time; see `Arm.jog_l`."""
        return await self.carry(
            lambda: self.sync.jog_l(
                amounts, speed=speed, duration_s=duration_s, frame=frame, **axes
            )
        )

    async def preview(
        self,
        goal: Place | Angles | None = None,
        *,
        line: bool = False,
        frame: str = BASE,
        speed: float = 1.0,
        **joints_deg: Unpack[JointAngles],
    ) -> Preview:
        """Return what a motion would be, or why it is refused; see `Arm.preview`."""
        return await self.carry(
            lambda: self.sync.preview(goal, line=line, frame=frame, speed=speed, **joints_deg)
        )

    async def _go(
        self, begin: Callable[[], Handle[Moved]], wait: bool
    ) -> Moved | AsyncHandle[Moved]:
        """Begin a motion, and wait for its end where that is wanted."""
        if wait:
            return await self.carry(lambda: begin().wait())
        return AsyncHandle(await self.carry(begin), self.carry)


@checked_calls(RULES)
class AsyncArm(AsyncMoves):
    """One arm, connected, for a program of coroutines; `sync` is the `Arm` itself.

    Whoever cancels an awaited call, `asyncio.timeout` too, stops the arm: the cancelling goes on
    once it stands. What never waits (`status`, `pause`, `estop`, ...) is not awaited.
    """

    def __init__(self, sync: Arm) -> None:
        """Take a connected arm."""
        super().__init__(sync, sync)

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
    ) -> Connecting:
        """Connect as `Arm.connect` does: `await` it, or use it in `async with`.

        Simulated arms of one event loop live on one clock, unless `pace` says otherwise. What
        simulated time an arm needs passes while its calls are awaited, and not in `asyncio.sleep`.
        """
        connect = partial(
            Arm.connect,
            target,
            dialect=dialect,
            baud=baud,
            pace=pace,
            allow_restored=allow_restored,
            operator=operator,
            twin=twin,
            reconnect=reconnect,
        )
        return Connecting(connect, in_turn=_in_simulated_time(target, pace))

    async def __aenter__(self) -> Self:
        await self.carry(self.sync.__enter__)
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Stop, remember the position, and give the port back, whoever cancels that meanwhile."""
        await stage().carry_to_its_end(self.sync.close, in_turn=goes_in_turn(self.sync))

    @property
    def gripper(self) -> AsyncGripper:
        """The fingers."""
        return AsyncGripper(self.sync.gripper, self.sync)

    # -- what is known ------------------------------------------------------------------------

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
    def status(self) -> Status:
        """A frozen picture of this moment."""
        return self.sync.status

    @property
    def joints(self) -> Joints:
        """The acknowledged joint angles."""
        return self.sync.joints

    @property
    def pose(self) -> Pose:
        """The acknowledged pose."""
        return self.sync.pose

    @property
    def points(self) -> Points:
        """The named points of this arm."""
        return self.sync.points

    @property
    def speeds(self) -> SpeedLimits:
        """The limits that time is computed from."""
        return self.sync.speeds

    @property
    def model(self) -> ArmModel:
        """The arm's model."""
        return self.sync.model

    @property
    def abilities(self) -> Abilities:
        """What the arm's controller can do."""
        return self.sync.abilities

    @property
    def frames(self) -> tuple[str, ...]:
        """The frames that goals and jogs can be meant in."""
        return self.sync.frames

    @property
    def stops(self) -> int:
        """How often a stop was asked for."""
        return self.sync.stops

    @property
    def homes_by_switches(self) -> bool:
        """Whether `home` moves the arm."""
        return self.sync.homes_by_switches

    @property
    def homing_groups(self) -> tuple[tuple[str, ...], ...]:
        """The names of the motors that home by switches."""
        return self.sync.homing_groups

    @property
    def closed(self) -> bool:
        """Whether the connection was given back."""
        return self.sync.closed

    @property
    def reconnects(self) -> bool:
        """Whether a lost wire is looked for without anybody asking."""
        return self.sync.reconnects

    @property
    def paused(self) -> bool:
        """Whether somebody wants the arm to wait."""
        return self.sync.paused

    @property
    def speed_override(self) -> float:
        """The share of the speed asked for that the arm goes with, from 0.01 to 1."""
        return self.sync.speed_override

    @speed_override.setter
    def speed_override(self, speed_override: float) -> None:
        self.sync.speed_override = speed_override

    # -- what is awaited ----------------------------------------------------------------------

    move_motors = awaited(Arm.move_motors)
    move_gripper = awaited(Arm.move_gripper)
    go = begun(Arm.go)
    park = awaited(Arm.park)
    home = awaited(Arm.home)
    verify = awaited(Arm.verify)
    confirm_reference = awaited(Arm.confirm_reference)
    confirm_restored = awaited(Arm.confirm_restored)
    declare_posture = awaited(Arm.declare_posture)
    enable = awaited(Arm.enable)
    disable = awaited(Arm.disable)
    stop = awaited(Arm.stop)
    reset = awaited(Arm.reset)
    reconnect = awaited(Arm.reconnect)
    mend_settings = awaited(Arm.mend_settings)
    sleep = awaited(Arm.sleep)
    set_outputs = awaited(Arm.set_outputs)
    set_output = awaited(Arm.set_output)
    read_inputs = awaited(Arm.read_inputs)
    wait_inputs = awaited(Arm.wait_inputs)
    read_pendant_program = awaited(Arm.read_pendant_program)
    write_pendant_program = awaited(Arm.write_pendant_program)
    save_recording = awaited(Arm.save_recording)

    # -- what never waits ---------------------------------------------------------------------

    estop = at_once(Arm.estop)
    request_stop = at_once(Arm.request_stop)
    hold = at_once(Arm.hold)
    nudge = at_once(Arm.nudge)
    release = at_once(Arm.release)
    pause = at_once(Arm.pause)
    resume = at_once(Arm.resume)
    pose_in = at_once(Arm.pose_in)
    reference_request = at_once(Arm.reference_request)
    log = at_once(Arm.log)


class Connecting:
    """A connection that is being made: awaited it is the arm, in `async with` it is closed too."""

    def __init__(self, connect: Callable[[], Arm], *, in_turn: bool) -> None:
        self._connect = connect
        self._in_turn = in_turn
        self._arm: AsyncArm | None = None

    def __await__(self) -> Generator[Any, None, AsyncArm]:
        return self._connected().__await__()

    async def __aenter__(self) -> AsyncArm:
        arm = self._arm = await self._connected()
        try:
            return await arm.__aenter__()
        except BaseException:
            await arm.close()
            raise

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._arm is not None:
            await self._arm.close()

    async def _connected(self) -> AsyncArm:
        return AsyncArm(await stage().connect(self._connect, in_turn=self._in_turn))


def _in_simulated_time(target: str | None, pace: PaceChoice) -> bool:
    """Tell whether the loop may hold its breath for a connection.

    No port is opened then, and nothing really waits.
    """
    if isinstance(pace, str | float | int):
        return pace == "simulated"
    return simulation_forced() or anybody() or target is None or target.startswith(SIM)
