"""The async twin in use: calls, cancelled calls, ends."""

import asyncio
import signal
from contextlib import asynccontextmanager

import pytest
from amounts import amount

from armdrive import AsyncArm, LinkLost, Pose, SimulatedClock, State, Stopped
from armdrive.moves import JointMove

PLACE = Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90)
LONG_S = 1e6
"""A simulated time that takes minutes of real time."""


def still(arm):
    """Return whether the physical arm stands."""
    before = arm.sync.twin.world.motors
    arm.sync.sleep(5.0)
    return arm.sync.twin.world.motors == before


async def moving(arm, base_deg=60):
    """Begin a motion as a task, and wait until it is under way."""
    task = asyncio.create_task(arm.move_j(base_deg=base_deg))
    while arm.status.state is not State.MOVING or arm.status.acknowledged == arm.status.commanded:
        assert not task.done(), task
        await asyncio.sleep(0)
    return task


async def cancelled(task):
    """Cancel a task, and wait until it has ended by that."""
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task


@asynccontextmanager
async def homed(pace=None):
    """Connect to a simulated arm, and home it."""
    async with AsyncArm.connect("sim:teachmover", pace=pace) as arm:
        await arm.home()
        yield arm


async def test_the_calls_are_those_of_an_arm():
    async with AsyncArm.connect("sim:teachmover") as arm:
        reference = await arm.home()
        assert reference == arm.pose
        await arm.move_j(shoulder_deg=40, elbow_deg=-60, speed=0.5)
        moved = await arm.move_to(PLACE)
        assert moved.pose.z_mm == pytest.approx(120, abs=0.5)
        await arm.move_l(Pose.of(x_mm=250, y_mm=80, z_mm=120, pitch_deg=-90))
        assert await arm.gripper.grasp() == pytest.approx(0.0, abs=0.1)
        assert arm.gripper.force_n > 1.0
        await arm.gripper.open(40.0)
        assert arm.gripper.opening_mm == pytest.approx(40.0, abs=0.1)
        await arm.jog_l(x_mm=5)
        assert (await arm.preview(JointMove({"base_deg": 10}))).duration_s > 0.0
        assert arm.twin.world.pose.y_mm == pytest.approx(80, abs=1.0)
    assert arm.status.state is State.DISCONNECTED


async def test_a_connection_can_be_awaited_or_entered_and_leaves_the_arm_standing():
    arm = await AsyncArm.connect("sim:mks")
    assert arm.status.state is State.DISABLED
    async with arm:
        assert arm.status.state is State.STANDBY
        await arm.reference.declare(arm.twin.world.joints)
        handle = await arm.move_j(base_deg=60, wait=False)
        assert not handle.done
    assert handle.done
    device = arm.twin.device
    assert not device.moving
    async with await AsyncArm.connect("sim:teachmover") as other:
        assert other.status.state is State.STANDBY


async def test_two_arms_of_one_loop_move_side_by_side_on_one_clock():
    async with AsyncArm.connect("sim:teachmover") as a, AsyncArm.connect("sim:teachmover") as b:
        await asyncio.gather(a.home(), b.home())
        began_s = a.status.time_s
        await a.move_j(base_deg=20)
        alone_s = a.status.time_s - began_s
        await b.move_j(base_deg=20)
        began_s = a.status.time_s
        await asyncio.gather(a.move_j(base_deg=0), b.move_j(base_deg=0))
        assert a.sync.parts.pace.clock is b.sync.parts.pace.clock
        assert a.status.time_s - began_s == pytest.approx(alone_s, rel=0.05)


async def program(clock):
    """Move two unlike arms, each in its own coroutine; return what was seen and when."""
    seen = []

    async def work(arm, name, angles):
        await arm.home()
        for angle in angles:
            await arm.move_j(base_deg=angle)
            seen.append((name, clock.now_s, arm.twin.world.motors))
            await arm.sleep(0.3)

    first, second = (
        AsyncArm.connect(f"sim:{each}", pace=clock) for each in ("teachmover", "armdroid")
    )
    async with first as a, second as b:
        await asyncio.gather(work(a, "a", (6, 4)), work(b, "b", (3,)))
    return seen


def test_the_same_program_gives_the_same_result_each_time():
    first, again = (asyncio.run(program(SimulatedClock())) for _ in range(2))
    assert len(first) == 3
    assert again == first


async def test_arms_on_clocks_of_their_own_and_in_real_time_go_together():
    async with (
        AsyncArm.connect("sim:teachmover", pace="simulated") as a,
        AsyncArm.connect("sim:teachmover", pace="simulated") as b,
        AsyncArm.connect("sim:teachmover", pace=20.0) as c,
    ):
        await asyncio.gather(*(arm.home() for arm in (a, b, c)))
        await asyncio.gather(*(arm.move_j(base_deg=20) for arm in (a, b, c)))
        assert a.sync.parts.pace.clock is not b.sync.parts.pace.clock
        for arm in (a, b, c):
            assert arm.twin.world.joints.deg["base"] == pytest.approx(20, abs=0.2)


async def test_a_stop_from_another_task_ends_a_motion_with_stopped():
    async with homed() as arm:
        task = await moving(arm)
        await arm.stop()
        with pytest.raises(Stopped):
            await task
        assert still(arm)
        assert abs(arm.joints.deg["base"]) < 60


async def test_a_lost_wire_is_the_loss_of_one_arm():
    async with AsyncArm.connect("sim:teachmover") as a, AsyncArm.connect("sim:armdroid") as b:
        await asyncio.gather(a.home(), b.home())
        mover = await moving(a)
        other = asyncio.create_task(b.move_j(base_deg=10))
        a.twin.link.unplug()
        with pytest.raises(LinkLost):
            await mover
        await other


# -- Cancelled -------------------------------------------------------------------------------------


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
async def test_a_cancelled_motion_has_stopped_when_the_cancelling_goes_on(dialect):
    async with AsyncArm.connect(f"sim:{dialect}") as arm:
        await arm.reference.declare(arm.twin.world.joints)
        task = await moving(arm)
        await cancelled(task)
        assert arm.status.state is State.STANDBY
        assert still(arm)
        assert arm.joints.deg["base"] < 59
        await arm.move_j(base_deg=0)


@pytest.mark.parametrize("rounds", range(1, 60, amount(30, 2)))
async def test_an_arm_stands_whenever_its_program_is_cancelled(rounds):
    async with AsyncArm.connect("sim:teachmover") as arm:

        async def work():
            await arm.home()
            await arm.gripper.open(30)
            while True:
                await arm.move_j(base_deg=2)
                await arm.gripper.grasp()
                await arm.move_j(base_deg=0)

        task = asyncio.create_task(work())
        for _ in range(rounds * rounds):
            await asyncio.sleep(0)
        await cancelled(task)
        assert arm.status.state is State.STANDBY
        assert still(arm)


@pytest.mark.parametrize(
    "call",
    [
        lambda arm: arm.sleep(LONG_S),
        lambda arm: arm.io.wait(high=3, within_s=LONG_S),
        lambda arm: arm.jog_j(base=1, duration_s=LONG_S),
    ],
    ids=["sleep", "wait_inputs", "jog"],
)
async def test_any_wait_can_be_cancelled(call):
    async with homed() as arm:
        task = asyncio.create_task(call(arm))
        while arm.sync.parts.pace.now_s() < 20.0:
            await asyncio.sleep(0)
        await cancelled(task)
        assert still(arm)
        assert arm.sync.parts.core.readings.awaiting == 0


# -- Ends ------------------------------------------------------------------------------------------


def test_a_program_that_ends_in_mid_motion_leaves_the_arm_standing():
    found = []

    async def left_behind():
        arm = await AsyncArm.connect("sim:teachmover")
        found.append(arm)
        await arm.home()
        task = await moving(arm)
        assert not task.done()

    asyncio.run(left_behind())
    (arm,) = found
    assert arm.status.state is State.STANDBY
    assert still(arm)


def test_ctrl_c_stops_the_arm_before_the_program_ends():
    found = []

    async def interrupted():
        async with AsyncArm.connect("sim:teachmover") as arm:
            found.append(arm)
            await arm.home()
            asyncio.get_running_loop().call_later(0.05, signal.raise_signal, signal.SIGINT)
            while True:
                await arm.move_j(base_deg=60)
                await arm.move_j(base_deg=-60)

    with pytest.raises(KeyboardInterrupt):
        asyncio.run(interrupted())
    (arm,) = found
    assert arm.status.state is State.DISCONNECTED
    assert not arm.twin.device.moving


class TestRealTime:
    """The same with an engine's thread that sleeps; here thirty times faster than the clock."""

    async def test_the_loop_goes_on_while_an_arm_moves(self):
        async with homed(pace=30.0) as arm:
            rounds = 0
            task = asyncio.create_task(arm.move_j(base_deg=15))
            while not task.done():
                await asyncio.sleep(0)
                rounds += 1
            assert rounds > 10
            assert (await task).bursts

    async def test_a_cancelled_motion_has_stopped(self):
        async with homed(pace=30.0) as arm:
            task = await moving(arm)
            await cancelled(task)
            assert arm.status.state is State.STANDBY
            assert arm.joints.deg["base"] < 59

    async def test_a_cancelled_sleep_ends_at_once(self):
        async with AsyncArm.connect("sim:teachmover", pace=30.0) as arm:
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.05):
                    await arm.sleep(LONG_S)

    async def test_a_stop_does_not_wait_for_running_calls(self):
        async with homed(pace=30.0) as arm:
            sleepers = [asyncio.create_task(arm.sleep(LONG_S)) for _ in range(40)]
            task = await moving(arm)
            await arm.stop()
            with pytest.raises(Stopped):
                await task
            ended = await asyncio.gather(*sleepers, return_exceptions=True)
            assert {type(each) for each in ended} == {Stopped}
