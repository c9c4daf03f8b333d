"""A simulated drive whose shaft never arrives waits, and lets simulated time pass meanwhile."""

from __future__ import annotations

import math

import pytest
from mks_sim import TURN, Bench

from firmware_protocol.mks import MoveAbsoluteAxis, SilenceWatchdog


@pytest.mark.parametrize("timeout_ms", [200, 5000])
def test_the_watchdog_of_a_motion_that_is_never_done_is_due_no_more(timeout_ms):
    """The set-point stands, and only the shaft is behind: there is nothing to stop."""
    bench = Bench(stall_protection=False)
    bench.ask(1, SilenceWatchdog(timeout_ms))
    bench.twin.faults.add("stall", "1")
    bench.send(1, MoveAbsoluteAxis(TURN // 4, 600, 0))
    bench.run(0.1)
    assert bench.board.nodes[0].motion.under_way is not None
    assert bench.board.nodes[0].due_s() == math.inf


def test_a_drive_that_moves_is_stopped_by_its_watchdog_all_the_same():
    bench = Bench()
    bench.ask(1, SilenceWatchdog(200))
    bench.send(1, MoveAbsoluteAxis(20 * TURN, 60, 250))
    bench.run(2.0)
    assert bench.board.nodes[0].motion.watchdog_stops == 1
    assert not bench.device.moving
