"""Jogs of the simulated GRBL board, and what becomes of them when they are cancelled."""

from __future__ import annotations

import pytest
from grbl_bench import SLOPE, Bench

from armdrive.sim.grbl.firmware import FIRMWARES
from firmware_protocol.grbl import State

HOLD, CANCEL = "!", "\x85"
JOG_2 = "$J=G91X2F1500\n"
"""Two units at 25 units a second, from which it takes 0.63 units to stop."""
BRAKING = 25.0**2 / (2 * SLOPE)
AHEAD = 25.0 * 0.09
"""What is worked out already when a cancel comes."""


def test_a_cancelled_jog_brakes_and_ends_in_idle():
    bench = Bench()
    bench.say("$J=G91X16F1500", 0.3)
    assert bench.ask().state is State.JOG
    before = bench.x
    bench.say(CANCEL, 0.3)
    assert bench.ask().state is State.IDLE
    assert bench.x - before == pytest.approx(AHEAD + BRAKING, abs=0.25)


def test_a_hold_ends_a_jog_as_well():
    bench = Bench()
    bench.say("$J=G91X16F1500", 0.3)
    bench.say(HOLD, 0.3)
    assert bench.ask().state is State.IDLE
    assert bench.x < 16.0


def test_a_cancel_before_the_first_jog_is_planned_is_ignored_and_all_sixteen_units_run():
    """Eight lines at once, as a USB port takes them, and the cancel 4 ms later."""
    bench = Bench(baud=None, plan_ms=4.0)
    bench.put(JOG_2 * 8)
    bench.wait(0.004)
    bench.put(CANCEL)
    bench.finish()
    assert bench.x == 16.0
    assert bench.heard.count("ok") == 8


def test_a_cancel_does_not_clear_lines_that_are_unread():
    """Seven unanswered lines: 12.2 units further, against 0.63 units of braking."""
    assert not FIRMWARES["fluidnc"].cancel_clears_ring
    bench = Bench(baud=None, firmware="grbl", plan_ms=4.0)
    bench.put(JOG_2 * 8)
    bench.wait(0.006)
    assert bench.heard.count("ok") == 1
    bench.put(CANCEL)
    bench.finish()
    assert bench.x == pytest.approx(12.2, abs=1.5)
    assert bench.heard.count("ok") == 8


def test_with_one_line_outstanding_the_overrun_is_the_ramp_and_that_line():
    """25 ms a line at 50 units a second, seen on a 328p: 5.5 to 5.7 units behind 20.7."""
    bench = Bench(firmware="grbl")
    for _ in range(20):
        bench.put("$J=G91X1.25F3000\n")
        bench.wait(0.025)
    at = bench.x
    bench.put("$J=G91X1.25F3000\n")
    bench.put(CANCEL)
    bench.finish()
    assert at == pytest.approx(20.7, abs=0.3)
    assert bench.x - at == pytest.approx(5.6, abs=0.3)


@pytest.mark.parametrize("firmware", ["grblhal", "mega5x"])
def test_a_cancel_clears_the_ring(firmware):
    bench = Bench(firmware=firmware, plan_ms=4.0)
    bench.put(JOG_2 * 8)
    while bench.heard.count("ok") < 1:
        bench.wait(0.001)
    bench.put(CANCEL)
    bench.finish()
    assert bench.x < 2.5
    assert bench.heard.count("ok") < 5


def test_a_line_that_waits_for_room_makes_up_for_what_was_cancelled():
    """Its target was reckoned before the cancel, which sets the board's position back."""
    bench = Bench(firmware="grbl")
    for count in (8, 9):
        bench.put("$J=G91X1F60\n" * count)
        bench.wait(0.05)
    assert bench.heard.count("ok") == 16  # the first one is computed to its end
    assert bench.x < 1.0
    bench.put(CANCEL)
    bench.finish()
    assert bench.x == 17.0


def test_a_jog_leaves_the_modes_alone_and_locks_other_lines():
    bench = Bench()
    bench.say("G90G1F600")
    bench.say("$J=G91G20X1F100", 0.1)
    assert bench.say("G1X1") == ["error:9"]
    bench.finish()
    assert bench.x == 25.4
    assert "G1 G54 G17 G21 G90 G94 M5 M9 T0 F600" in bench.say("$G")[0]
    bench.say("G1X1F600", 0.1)
    assert bench.say("$J=X1F100") == ["error:8"]
    assert bench.say("$$") == ["error:8"]
