"""A simulated CiA 402 drive moves as the profile says, and its arm with it."""

from __future__ import annotations

import pytest
from cia402_sim import CSP, ENABLE, PP, TURN, Bench

from firmware_protocol.canopen import DriveState


@pytest.fixture
def bench():
    return Bench()


def test_a_drive_is_enabled_and_follows_targets_from_sync_to_sync(bench):
    bench.set_up(1)
    bench.enable(1)
    before = bench.world.motors
    for step in range(1, 21):
        bench.order(1, ENABLE, CSP, step * 50)
        bench.sync()
    bench.sync()
    told = bench.sync()[1]
    assert told[0].state is DriveState.ENABLED
    assert told[1:] == (CSP, 1000)
    assert (bench.world.motors - before) == (1000, 0, 0, 0, 0, 0)
