"""How a program of coroutines ends in mid-motion, and the same calls in real time."""

from __future__ import annotations

import asyncio
import signal
import threading

import pytest
from async_bench import LONG_S, cancelled, homed, moving, still

from armdrive import AsyncArm, State, Stopped


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


@pytest.mark.skipif(not hasattr(signal, "pthread_kill"), reason="signals of POSIX systems")
def test_a_second_ctrl_c_within_a_persons_own_function_is_no_hang():
    """The operator sees the first one cancel the task, and the second one leave the loop."""
    arms, tasks, left = [], [], threading.Event()

    def operator(request):
        main = threading.main_thread().ident
        for _ in range(40):  # a signal that comes as a thread falls asleep is heard at the next one
            if not tasks[0].cancelling():
                signal.pthread_kill(main, signal.SIGINT)
                left.wait(timeout=0.1)
        for _ in range(40):
            if not left.wait(timeout=0.2):
                signal.pthread_kill(main, signal.SIGINT)
        return left.is_set()

    async def homed():
        async with AsyncArm.connect("sim:teachmover", operator=operator) as arm:
            arms.append(arm)
            tasks.append(asyncio.current_task())
            await arm.home()

    with asyncio.Runner() as runner:
        with pytest.raises(KeyboardInterrupt):
            runner.run(homed())
        left.set()
    assert tasks[0].done()
    assert arms[0].status.state is State.DISCONNECTED
    assert not arms[0].twin.device.moving


class TestRealTime:
    """The same with an engine's thread that sleeps; here thirty times faster than the clock."""

    async def test_the_loop_goes_on_while_an_arm_moves(self):
        async with homed(pace=30.0) as arm:
            rounds = 0
            task = asyncio.create_task(arm.move_j(base_deg=60))
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

    async def test_a_stop_waits_for_nobody_however_many_calls_are_under_way(self):
        async with homed(pace=30.0) as arm:
            sleepers = [asyncio.create_task(arm.sleep(LONG_S)) for _ in range(40)]
            task = await moving(arm)
            await arm.stop()
            with pytest.raises(Stopped):
                await task
            ended = await asyncio.gather(*sleepers, return_exceptions=True)
            assert {type(each) for each in ended} == {Stopped}
