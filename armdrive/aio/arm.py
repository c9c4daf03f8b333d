"""`AsyncArm`: an arm whose calls are awaited, each the twin of the call of that name of `Arm`."""

from __future__ import annotations

from collections.abc import Generator
from functools import partial
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from armdrive.aio.gripper import AsyncGripper
from armdrive.aio.moves import AsyncMoves
from armdrive.aio.stage import goes_in_turn, stage
from armdrive.aio.twins import at_once, awaited, begun
from armdrive.arm import Arm
from armdrive.connecting import SIM, simulation_forced
from armdrive.legs import Speeds
from armdrive.pointbook import Points
from armdrive.standins import anybody
from armdrive.status import Status
from kinematics import ArmModel, Joints, Pose

if TYPE_CHECKING:
    from armdrive.abilities import Abilities
    from armdrive.armfile import ArmConfig
    from armdrive.sim.twin import Twin as SimulatedTwin


class AsyncArm(AsyncMoves):
    """One arm, connected, for a program of coroutines; `sync` is the `Arm` itself.

    Whoever cancels an awaited call, `asyncio.timeout` too, stops the arm: the cancelling goes on
    once it stands. What never waits (`status`, `pause`, `estop`, ...) is not awaited.
    """

    def __init__(self, sync: Arm) -> None:
        """Take a connected arm."""
        super().__init__(sync, sync)

    @classmethod
    def connect(cls, target: str | None = None, **options: Any) -> Connecting:
        """Connect as `Arm.connect` does: `await` it, or use it in `async with`.

        Simulated arms of one event loop live on one clock, unless `pace` says otherwise. What
        simulated time an arm needs passes while its calls are awaited, and not in `asyncio.sleep`.
        """
        return Connecting(target, options)

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
    def twin(self) -> SimulatedTwin | None:
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
    def speeds(self) -> Speeds:
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
    def speed_override(self, share: float) -> None:
        self.sync.speed_override = share

    # -- what is awaited ----------------------------------------------------------------------

    move_motors = awaited(Arm.move_motors)
    move_gripper = awaited(Arm.move_gripper)
    go = begun(Arm.go)
    go_over = awaited(Arm.go_over)
    park = awaited(Arm.park)
    home = awaited(Arm.home)
    verify = awaited(Arm.verify)
    confirm_reference = awaited(Arm.confirm_reference)
    confirm_restored = awaited(Arm.confirm_restored)
    declare_posture = awaited(Arm.declare_posture)
    enable = awaited(Arm.enable)
    disable = awaited(Arm.disable)
    stop = awaited(Arm.stop)
    stand_still = awaited(Arm.stand_still)
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
    above_mark = at_once(Arm.above_mark)
    reference_request = at_once(Arm.reference_request)
    log = at_once(Arm.log)
    on_close = at_once(Arm.on_close)


class Connecting:
    """A connection that is being made: awaited it is the arm, in `async with` it is closed too."""

    def __init__(self, target: str | None, options: dict[str, Any]) -> None:
        self._target = target
        self._options = options
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
        connect = partial(Arm.connect, self._target, **self._options)
        return AsyncArm(await stage().connect(connect, in_turn=self._in_simulated_time))

    @property
    def _in_simulated_time(self) -> bool:
        """Whether the loop may hold its breath for it: no port is opened, nothing really waits."""
        if isinstance(self._options.get("pace"), str | float | int):
            return bool(self._options["pace"] == "simulated")
        forced = simulation_forced() or anybody()
        return forced or self._target is None or self._target.startswith(SIM)
