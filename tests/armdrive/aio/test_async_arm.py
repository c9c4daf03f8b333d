"""Arms in coroutines: every call, side by side on one clock, and the same result each time."""

from __future__ import annotations

import asyncio
import threading

import pytest
from async_bench import PLACE, cancelled, homed, moving, still

from armdrive import AsyncArm, LinkLost, OutOfBounds, Pose, SimulatedClock, State, Stopped
from armdrive.errors import ArmFileError, OperatorNeeded, WrongState
from armdrive.moves import JointMove


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


async def test_it_can_be_awaited_or_entered_and_a_with_statement_leaves_a_still_arm():
    arm = await AsyncArm.connect("sim:mks")
    assert arm.status.state is State.DISABLED
    async with arm:
        assert arm.status.state is State.STANDBY
        await arm.declare_posture(arm.twin.world.joints)
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
        assert a.sync.pace.clock is b.sync.pace.clock
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

    first, second = (AsyncArm.connect(f"sim:{each}", pace=clock) for each in ("teachmover", "grbl"))
    async with first as a, second as b:
        await asyncio.gather(work(a, "a", (6, 4)), work(b, "b", (10, -5, 3)))
    return seen


def test_the_same_program_gives_the_same_result_each_time():
    first, again = (asyncio.run(program(SimulatedClock())) for _ in range(2))
    assert len(first) == 5
    assert again == first


async def test_what_follows_a_gather_begins_at_the_moment_in_which_it_ended():
    async with AsyncArm.connect("sim:teachmover") as a, AsyncArm.connect("sim:grbl") as b:
        await asyncio.gather(a.home(), b.home())
        mover = asyncio.create_task(b.move_j(base_deg=15, speed=0.2))

        async def pair():
            await asyncio.gather(a.sleep(1.0), a.sleep(0.5))

        before_s = a.sync.pace.now_s()
        await asyncio.gather(pair())
        assert a.sync.pace.now_s() == pytest.approx(before_s + 1.0, abs=1e-9)
        assert not mover.done()
        await mover


async def test_arms_on_clocks_of_their_own_and_in_real_time_go_together():
    async with (
        AsyncArm.connect("sim:teachmover", pace="simulated") as a,
        AsyncArm.connect("sim:teachmover", pace="simulated") as b,
        AsyncArm.connect("sim:teachmover", pace=100.0) as c,
    ):
        await asyncio.gather(*(arm.home() for arm in (a, b, c)))
        await asyncio.gather(*(arm.move_j(base_deg=20) for arm in (a, b, c)))
        assert a.sync.pace.clock is not b.sync.pace.clock
        for arm in (a, b, c):
            assert arm.twin.world.joints.deg["base"] == pytest.approx(20, abs=0.2)


async def test_simulated_time_stands_while_nobody_awaits_an_arm():
    async with AsyncArm.connect("sim:teachmover") as arm:
        before_s = arm.sync.pace.now_s()
        for _ in range(100):
            await asyncio.sleep(0)
        assert arm.sync.pace.now_s() == before_s


async def test_a_refusal_is_raised_where_the_call_is_awaited():
    with pytest.raises(ArmFileError):
        await AsyncArm.connect("no-such-arm")
    async with homed() as arm:
        with pytest.raises(OutOfBounds):
            await arm.move_j(shoulder_deg=400)
        task = await moving(arm)
        with pytest.raises(WrongState):
            await arm.move_j(base_deg=10)
        await task


async def test_a_stop_from_another_task_ends_a_motion_with_stopped():
    async with homed() as arm:
        task = await moving(arm)
        await arm.stop()
        with pytest.raises(Stopped):
            await task
        assert still(arm)
        assert abs(arm.joints.deg["base"]) < 60


async def test_an_operator_is_an_ordinary_function_and_may_jog():
    asked = []

    def operator(request):
        asked.append(request.pose)
        request.arm.jog_j(base_deg=3)
        return False

    async with AsyncArm.connect("sim:teachmover", operator=operator) as arm:
        with pytest.raises(OperatorNeeded):
            await arm.home()
    assert len(asked) == 1


async def test_what_an_operator_does_takes_time_for_every_arm_of_the_loop():
    seen = []

    def operator(request):
        began_s = request.arm.pace.now_s()
        request.arm.sleep(5.0)
        seen.append(request.arm.pace.now_s() - began_s)
        return True

    async with AsyncArm.connect("sim:teachmover") as a, AsyncArm.connect("sim:grbl") as b:
        await b.home()
        mover = asyncio.create_task(b.move_j(base_deg=10))
        await a.home(operator=operator)
        assert seen == [pytest.approx(5.0)]
        await mover
        assert b.joints.deg["base"] == pytest.approx(10, abs=0.2)


async def test_no_thread_is_started_in_simulated_time(monkeypatch):
    def refused(self):
        raise AssertionError(f"{self.name} was started")

    monkeypatch.setattr(threading.Thread, "start", refused)
    async with homed() as arm:
        task = await moving(arm)
        await cancelled(task)
        await arm.gripper.grasp()


async def test_a_lost_wire_is_the_loss_of_one_arm():
    async with AsyncArm.connect("sim:teachmover") as a, AsyncArm.connect("sim:grbl") as b:
        await asyncio.gather(a.home(), b.home())
        mover = await moving(a)
        other = asyncio.create_task(b.move_j(base_deg=10))
        a.twin.link.unplug()
        with pytest.raises(LinkLost):
            await mover
        await other


async def test_a_flaw_of_the_engine_is_raised_and_no_hang():
    arm = await AsyncArm.connect("sim:teachmover")
    inner = arm.sync.engine.advance
    arm.sync.engine.advance = lambda now_s: 1 / 0
    with pytest.raises(ZeroDivisionError):
        await arm.sleep(1.0)
    arm.sync.engine.advance = inner
    await arm.close()


def test_an_arm_may_be_used_from_one_loop_after_another():
    async def connected():
        return await AsyncArm.connect("sim:teachmover", pace=SimulatedClock())

    async def moved(arm):
        await arm.home()
        await arm.move_j(base_deg=20)

    arm = asyncio.run(connected())
    asyncio.run(moved(arm))
    assert arm.joints.deg["base"] == pytest.approx(20, abs=0.2)
    arm.sync.move_j(base_deg=0)  # and without any
    asyncio.run(arm.close())
