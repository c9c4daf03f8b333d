"""The simulated GRBL board in motion: holds, modes, overrides, places."""

from __future__ import annotations

import itertools
import math

import pytest
from grbl_bench import MACHINE, SLOPE, Bench, config_of, stream

from firmware_protocol.grbl import Line, State

HOLD, RESUME, RESET = "!", "~", "\x18"
BRAKING = 25.0**2 / (2 * SLOPE)


def test_a_move_takes_the_time_of_its_trapezoid_and_its_state_is_run():
    bench = Bench()
    assert bench.say("G1X50F1500", 0.02) == ["ok"]  # planned, not arrived
    assert bench.x < 1.0
    bench.wait(1.0)
    assert bench.ask().state is State.RUN
    assert bench.reports[-1].feed == 1500
    bench.finish()
    assert bench.x == 50.0
    assert bench.ask().state is State.IDLE
    assert bench.device.world.motors[0] == 500


def test_with_the_planner_full_a_line_waits_for_its_ok():
    bench = Bench(firmware="grbl")
    bench.put("".join(f"G1X{n}F60\n" for n in range(1, 18)))
    assert bench.wait(0.09).count("ok") == 15
    assert bench.ask().free_blocks == 0
    bench.finish()
    assert bench.heard.count("ok") == 17
    assert bench.x == 17.0


def test_a_hold_brakes_along_the_path_and_goes_on_without_a_lost_step():
    bench = Bench()
    bench.say("G1X50Y-20F1500", 1.0)
    bench.put(HOLD)
    bench.wait(0.002)
    first = bench.ask()
    assert (first.state, first.sub_state) == (State.HOLD, 1)
    bench.wait(0.2)
    second = bench.ask()
    assert (second.state, second.sub_state, second.feed) == (State.HOLD, 0, 0)
    way = second.machine_position[0] - first.machine_position[0]
    along = math.hypot(50, 20) / 50
    assert way * along == pytest.approx(25.0 * 0.09 + BRAKING, abs=0.2)
    bench.wait(1.0)
    bench.say(RESUME)
    bench.finish()
    assert (bench.x, bench.board.drive.counts[1]) == (50.0, -200)
    assert bench.device.world.motors - bench.device.registers == Bench().device.world.motors


def test_a_resume_before_the_hold_is_complete_is_not_heard():
    bench = Bench()
    bench.say("G1X50F1500", 1.0)
    bench.put(HOLD)
    bench.wait(0.005)
    bench.say(RESUME, 1.0)
    assert (bench.ask().state, bench.reports[-1].sub_state) == (State.HOLD, 0)


def test_a_hold_in_idle_is_complete_at_once_and_lines_get_no_ok_until_the_resume():
    bench = Bench()
    bench.say(HOLD)
    assert (bench.ask().state, bench.reports[-1].sub_state) == (State.HOLD, 0)
    assert bench.say("G1X1F3000", 1.0) == []
    assert bench.say(RESUME, 1.0) == ["ok"]
    assert bench.x == 1.0


def test_the_safe_stop_keeps_the_position_and_raises_no_alarm():
    bench = Bench()
    bench.say("G1X50F1500", 1.0)
    bench.say(HOLD, 0.3)
    at = bench.ask()
    assert (at.state, at.sub_state) == (State.HOLD, 0)
    bench.say(RESET, 0.5)
    after = bench.ask()
    assert after.state is State.IDLE
    assert after.machine_position == at.machine_position
    assert not [line for line in bench.heard if "ALARM" in line]
    bench.finish()
    assert bench.x == pytest.approx(27.0, abs=1.0)
    assert bench.device.world.motors[0] == bench.board.drive.counts[0]


def test_a_cut_of_the_cable_stops_nothing():
    """A jog ran 38 units in the second after."""
    bench = Bench()
    bench.say("$J=G91X100F2400", 0.5)
    at = bench.x
    bench.link.unplug()
    bench.device.transmit(bench.now_s + 1.0)
    assert bench.x - at == pytest.approx(38.0, abs=4.0)


def test_segments_that_are_shorter_than_the_planning_starve_the_motion():
    def lasts(units):
        bench = Bench(firmware="grbl")
        began_s = bench.now_s
        ends = (units * (n + 1) for n in range(round(20 / units)))
        stream(bench, [Line(f"G90G1X{end:.3g}F3000") for end in ends])
        bench.finish()
        assert bench.x == pytest.approx(20.0)
        return bench.now_s - began_s

    assert lasts(0.1) == pytest.approx(0.737, rel=0.05)  # seen on a 328p
    assert lasts(1.0) == pytest.approx(0.537, rel=0.05)


def test_overrides_change_the_speed_at_once_but_not_that_of_a_jog():
    bench = Bench()
    bench.say("G1X100F600", 0.5)
    bench.put("\x91" * 5)
    bench.wait(0.2)
    assert (bench.ask().feed, bench.board.overrides) == (900, [150, 100, 100])
    bench.put("\x90")
    bench.wait(0.2)
    assert bench.ask().feed == 600
    bench.put("\x92\x92\x96")
    bench.finish()
    assert bench.board.overrides == [80, 50, 100]
    bench.say("$J=G91X-20F600", 0.5)
    assert bench.ask().feed == 600
    bench.say(RESET, 2.0)
    assert bench.board.overrides == [100, 100, 100]


def test_a_wait_is_answered_when_it_is_over_and_follows_the_motion():
    bench = Bench()
    bench.say("G1X10F600", 0.02)
    bench.put("G4P0.5\n")
    times = []
    for _ in range(40):
        times += [bench.now_s for line in bench.wait(0.05) if line == "ok"]
    assert times[-1] == pytest.approx(1.6, abs=0.1)


def test_places_are_reached_in_every_mode():
    bench = Bench()
    lines = [
        ("G91G0X5", 5.0),
        ("G0X5", 10.0),
        ("G90G0X1", 1.0),
        ("G10L20P0X0", 1.0),
        ("G0X2", 3.0),
        ("G53G0X2", 2.0),
        ("G92X7", 2.0),
        ("G0X8", 3.0),
        ("G92.1", 3.0),
        ("G0X0", 1.0),
        ("G28.1", 1.0),
        ("G0X9", 10.0),
        ("G28", 1.0),
        ("G20G0X1", 26.4),
        ("G21G55G0X3", 3.0),
    ]
    for line, place in lines:
        bench.say(line, 3.0)
        assert bench.heard[-1] == "ok", line
        assert bench.x == pytest.approx(place), line


def test_a_program_pauses_and_ends():
    bench = Bench()
    bench.say("M0")
    assert bench.ask().state is State.HOLD
    assert bench.say(RESUME) == ["ok"]
    assert bench.say("M30")[-2:] == ["[MSG:Pgm End]", "ok"]


def test_nothing_moves_in_check_mode_and_its_end_is_a_reset():
    bench = Bench()
    bench.say("$C")
    assert bench.ask().state is State.CHECK
    for line in ("G1X50F600", "M8", "G4P10"):
        assert bench.say(line) == ["ok"]
    bench.say("$C", 0.2)
    assert bench.heard[-3:-1] == ["[MSG:Disabled]", "ok"]
    assert len(bench.banners) == 2
    assert (bench.x, bench.ask().state) == (0.0, State.IDLE)


def test_the_motors_are_in_the_order_of_the_arm_and_the_axes_in_that_of_the_board():
    bench = Bench(config=config_of(axes="ZYXABC"))
    start = bench.device.world.motors
    bench.say("G1X3Z1F600", 2.0)
    assert (bench.device.world.motors - start)[:3] == (10, 0, 30)
    assert bench.device.registers[:3] == (10, 0, 30)


def test_a_board_with_more_axes_than_motors_reports_them_all():
    bench = Bench({}, config=config_of("servo"), axes="XYZABC")
    assert len(bench.device.world.motors) == 5
    assert bench.say("G1C10X2F600", 3.0) == ["ok"]
    assert bench.ask().machine_position == (2, 0, 0, 0, 0, 10)
    assert len(bench.device.registers) == 5


def test_nothing_drifts_over_many_small_lines():
    bench = Bench({**MACHINE, **{100 + axis: 3.7 for axis in range(6)}})
    for n in itertools.chain(range(30), reversed(range(30))):
        bench.say(f"G1X{n * 0.37:.3f}F6000", 0.01)
    bench.finish()
    assert bench.board.drive.counts[0] == 0
