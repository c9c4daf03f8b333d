"""Whoever cancels an awaited call stops the arm, and goes on once it stands."""

from __future__ import annotations

import asyncio

import pytest
from amounts import amount
from async_bench import LONG_S, PLACE, cancelled, homed, moving, still

from armdrive import AsyncArm, State, Stopped
from armdrive.connect.parts import TaskRunner
from armdrive.moves import PoseMove


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
async def test_a_cancelled_motion_has_stopped_when_the_cancelling_goes_on(dialect):
    async with AsyncArm.connect(f"sim:{dialect}") as arm:
        await arm.home()
        task = await moving(arm)
        await cancelled(task)
        assert arm.status.state is State.STANDBY
        assert still(arm)
        assert arm.joints.deg["base"] < 59
        await arm.move_j(base_deg=0)


async def test_a_timeout_stops_the_arm_and_is_a_timeout():
    async with homed() as arm:

        async def to_and_fro():
            while True:
                await arm.move_j(base_deg=60)
                await arm.move_j(base_deg=-60)

        with pytest.raises(TimeoutError):
            await asyncio.wait_for(to_and_fro(), 0.02)
        assert arm.status.state is State.STANDBY
        assert still(arm)


@pytest.mark.parametrize("rounds", range(1, 60, amount(20, 2)))
async def test_at_whatever_moment_a_program_is_cancelled_its_arm_stands(rounds):
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


async def test_whoever_cancels_again_meanwhile_does_not_hurry_it():
    async with homed() as arm:
        task = await moving(arm)
        for _ in range(5):
            task.cancel()
            await asyncio.sleep(0)
        with pytest.raises(asyncio.CancelledError):
            await task
        assert still(arm)


async def test_an_outer_timeout_that_comes_while_an_inner_one_stops_the_arm_is_kept():
    async with homed() as arm:

        async def inner():
            async with asyncio.timeout(None) as deadline:
                asyncio.get_running_loop().call_soon(deadline.reschedule, 0.0)
                await arm.move_j(base_deg=60)

        with pytest.raises(TimeoutError):
            await inner()
        assert still(arm)


@pytest.mark.parametrize(
    "call",
    [
        lambda arm: arm.sleep(LONG_S),
        lambda arm: arm.wait_inputs(high=3, within_s=LONG_S),
        lambda arm: arm.jog_j(base=1, duration_s=LONG_S),
    ],
    ids=["sleep", "wait_inputs", "jog"],
)
async def test_any_wait_can_be_cancelled(call):
    async with homed() as arm:
        task = asyncio.create_task(call(arm))
        while arm.sync.pace.now_s() < 20.0:
            await asyncio.sleep(0)
        await cancelled(task)
        assert still(arm)
        assert arm.sync.core.readings.awaiting == 0


async def test_a_cancelled_wait_of_a_handle_stops_the_motion():
    async with homed() as arm:
        handle = await arm.move_j(base_deg=60, wait=False)
        task = asyncio.create_task(handle.wait())
        await asyncio.sleep(0)
        await cancelled(task)
        with pytest.raises(Stopped):
            await handle.wait()
        handle = await arm.start(PoseMove(PLACE))
        with pytest.raises(TimeoutError):
            await handle.wait(0.5)
        await handle.cancel()
        assert handle.done


async def test_a_cancelled_homing_leaves_nothing_referenced_and_nothing_at_work():
    async with AsyncArm.connect("sim:teachmover") as arm:
        task = asyncio.create_task(arm.home())
        while arm.status.state is not State.HOMING:
            await asyncio.sleep(0)
        await cancelled(task)
        assert arm.status.state is State.STANDBY
        assert still(arm)
        await arm.home()


async def test_a_cancelled_connection_leaves_nothing_connected(monkeypatch):
    made = []
    inner = TaskRunner.__init__

    def noted(self, *words, **named):
        made.append(self)
        inner(self, *words, **named)

    monkeypatch.setattr(TaskRunner, "__init__", noted)
    task = asyncio.create_task(AsyncArm.connect("sim:teachmover")._connected())
    await asyncio.sleep(0)
    await cancelled(task)
    (runner,) = made
    assert runner.pace.clock.engines == ()


async def test_a_close_is_carried_out_whoever_cancels_it():
    arm = await AsyncArm.connect("sim:teachmover")
    await arm.home()
    mover = await moving(arm)
    task = asyncio.create_task(arm.close())
    await asyncio.sleep(0)
    await cancelled(task)
    assert arm.status.state is State.DISCONNECTED
    assert not arm.twin.device.moving
    with pytest.raises(Stopped):
        await mover
