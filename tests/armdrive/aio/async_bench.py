"""For tests of coroutines: a goal, a motion under way, and a check that the arm stands."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager

import pytest

from armdrive import AsyncArm, Pose, State

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
