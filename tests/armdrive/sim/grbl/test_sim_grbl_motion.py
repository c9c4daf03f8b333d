"""A simulated GRBL board that moves an arm: lines, jogs, homing, hardware."""

import itertools
import math
from dataclasses import replace
from functools import partial

import pytest
from amounts import every_row
from grbl_bench import HOMING, MACHINE, SLOPE, Bench, config_of, homing_bench, stands_at, stream

from armdrive.config.sections import HomingSettings
from armdrive.sim.grbl.firmware import FIRMWARES
from armdrive.sim.mechanics.motors import LimitSwitch, SwitchState
from firmware_protocol.grbl import State, keys
from kinematics import Joints

RESET = "\x18"

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


@pytest.mark.parametrize(
    ("firmware", "said"),
    [("mega5x", ["ok"]), ("grbl", ["ok"]), ("fluidnc", ["ok"]), ("grblhal", [])],
)
def test_lines_are_read_until_a_hold_is_complete_but_by_grblhal(firmware, said):
    """Observed on the Mega and FluidNC: what arrives while it brakes is answered and planned."""
    bench = Bench(firmware=firmware)
    bench.say("G91G1X50F3000", 0.3)
    bench.put("!")
    bench.wait(0.02)
    assert bench.say("X5", 0.03) == said
    assert bench.ask().sub_state == 1
    bench.wait(1.0)
    assert bench.ask().sub_state == 0
    assert bench.say("X5", 1.0) == []
    bench.say("~", 3.0)
    assert bench.x == 60.0


@pytest.mark.parametrize("firmware", ["mega5x", "fluidnc"])
def test_a_motion_too_slow_for_the_timer_is_reported_at_the_planned_speed(firmware):
    """Observed on the Mega: a jog at 25 steps/s turns at 30.5 and reports F1500."""
    bench = Bench(firmware=firmware)
    bench.say("$J=G91X5F60", 0.5)
    before = bench.x
    assert bench.ask().feed == 60.0
    bench.wait(1.0)
    assert bench.x - before > 3.0


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
        stream(bench, [f"G90G1X{end:.3g}F3000" for end in ends])
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
    assert (bench.ask().feed, bench.board.override) == (900, 150)
    bench.put("\x90")
    bench.wait(0.2)
    assert bench.ask().feed == 600
    bench.put("\x92\x92")
    bench.finish()
    assert bench.board.override == 80
    bench.say("$J=G91X-20F600", 0.5)
    assert bench.ask().feed == 600
    bench.say(RESET, 2.0)
    assert bench.board.override == 100


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
        ("G20G0X1", 25.4),
        ("G21G55G0X3", 3.0),
    ]
    for line, place in lines:
        bench.say(line, 3.0)
        assert bench.heard[-1] == "ok", line
        assert bench.x == pytest.approx(place), line


def test_a_program_ends_with_its_outputs_off_and_absolute_moves():
    bench = Bench()
    bench.say("G91M8")
    assert bench.say("M30")[-2:] == ["[MSG:Pgm End]", "ok"]
    assert not bench.board.outputs.flood
    assert "G1 G54 G17 G21 G90 G94 M5 M9" in bench.say("$G")[0]


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


# -- Jogs ------------------------------------------------------------------------------------------

CANCEL = "\x85"
JOG_2 = "$J=G91X2F1500\n"
"""Two units at 25 units a second, from which it takes 0.63 units to stop."""
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


def planning_slowly(**options):
    """Return a board that takes 4 ms to plan a motion."""
    bench = Bench(**options)
    bench.board.firmware = replace(bench.board.firmware, plan_s=4e-3)
    return bench


def test_a_cancel_before_the_first_jog_is_planned_is_ignored_and_all_sixteen_units_run():
    """Eight lines at once, as a USB port takes them, and the cancel 4 ms later."""
    bench = planning_slowly(baud=None)
    bench.put(JOG_2 * 8)
    bench.wait(0.004)
    bench.put(CANCEL)
    bench.finish()
    assert bench.x == 16.0
    assert bench.heard.count("ok") == 8


def test_a_cancel_does_not_clear_lines_that_are_unread():
    """Seven unanswered lines: 12.2 units further, against 0.63 units of braking."""
    assert not FIRMWARES["fluidnc"].cancel_clears_in
    bench = planning_slowly(baud=None, firmware="grbl")
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
    bench = planning_slowly(firmware=firmware)
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


# -- Homing ----------------------------------------------------------------------------------------


def home(bench, line="$H", longest_s=30.0, look_s=0.01):
    """Home, and return how long that takes, in s."""
    began_s = bench.now_s
    bench.put(f"{line}\n")
    while "ok" not in bench.wait(look_s):
        assert bench.now_s < began_s + longest_s
    return bench.now_s - began_s


def test_homing_over_a_hundred_units_takes_three_and_a_half_seconds():
    """Seen on a Mega for one axis."""
    assert home(homing_bench(), "$HX") == pytest.approx(3.6, abs=0.2)
    bench = homing_bench()
    home(bench)
    assert bench.ask().machine_position == (-1.0,) * 6
    assert bench.reports[-1].state is State.IDLE
    expected = [switch.at - 10 for switch in bench.board.switches.by_axis.values()]
    assert list(bench.device.world.motors) == expected


def test_an_axis_homes_alone_and_downwards_where_its_bit_says_so():
    bench = homing_bench({**HOMING, 23: 1})
    low = LimitSwitch(partial(stands_at, bench, 0), -300, -1)
    bench.board.switches.by_axis = {**bench.board.switches.by_axis, 0: low}
    bench.say("$HX", 20.0)
    assert bench.ask().machine_position == (-199.0, 0, 0, 0, 0, 0)
    assert bench.device.world.motors[0] == -290


@pytest.mark.parametrize(("firmware", "alarm"), [("mega5x", 8), ("grblhal", 8), ("fluidnc", 6)])
def test_a_reset_while_homing_backs_off_a_pressed_switch_looks_like_a_failure(firmware, alarm):
    bench = homing_bench({**HOMING, 22: 3, 27: 10}, firmware=firmware)
    bench.put("$HX\n")
    while not bench.board.switches.mask():
        bench.wait(0.01)
    while not bench.board.drive.moving:
        bench.wait(0.002)
    bench.put("\x18")
    assert f"ALARM:{alarm}" in bench.wait(1.5)


def test_each_motion_of_homing_counts_from_zero_so_the_place_is_lost_when_it_fails():
    """Observed on the Mega."""
    bench = homing_bench()
    bench.say("$X")
    bench.say("G91G1X20F3000", 2.0)
    bench.put("$HX\n")
    bench.wait(0.3)
    assert 0 < bench.x < 20.0


def test_fluidnc_backs_off_as_slowly_as_it_approaches_and_calls_that_place_zero():
    """Observed; its configuration says where it stands then (`mpos_mm`)."""
    values = {**HOMING, keys.HOMING_FEED: 300}
    fast, slow = (homing_bench(values, firmware=name) for name in ("mega5x", "fluidnc"))
    at_feed_s, at_seek_s = 1 / (300 / 60), 2 * math.sqrt(1 / SLOPE)  # for a pull-off of 1
    longer_s = home(slow, "$HX") - home(fast, "$HX")
    assert longer_s == pytest.approx(2 * (at_feed_s - at_seek_s), abs=0.05)
    assert (fast.ask().machine_position[0], slow.ask().machine_position[0]) == (-1.0, 0.0)


def test_the_board_is_silent_while_it_homes():
    bench = homing_bench()
    bench.say("$HX", 0.5)
    assert bench.ask() is None
    bench.wait(10.0)
    assert bench.heard[-2] == "ok"
    silent = Bench({**HOMING, 22: 3.0}, firmware="grblhal")
    silent.say("$H", 0.5)
    assert silent.ask() is None
    reporting = Bench({**HOMING}, firmware="fluidnc")
    reporting.say("$H", 0.5)
    assert reporting.ask().state is State.HOME


def test_a_switch_that_is_stuck_open_is_not_found():
    bench = homing_bench()
    bench.device.board.set_switch(3, SwitchState.OPEN)
    start = bench.device.world.motors[3]
    bench.say("$H", 60.0)
    assert bench.heard[-4:] == [
        "ALARM:9",
        "ok",
        "Grbl 1.1q ['$' for help]",
        "[MSG:'$H'|'$X' to unlock]",
    ]
    assert bench.device.world.motors[3] - start == 1.5 * 200 * 10
    assert bench.ask().state is State.ALARM
    assert bench.device.world.energised


def test_a_switch_that_is_stuck_closed_is_not_left_by_pulling_off():
    bench = homing_bench()
    bench.device.board.set_switch(3, SwitchState.CLOSED)
    bench.say("$H", 60.0)
    assert "ALARM:8" in bench.heard
    assert bench.ask().state is State.ALARM
    bench.device.board.set_switch(3, SwitchState.FREE)
    bench.say("$H", 60.0)
    assert bench.ask().state is State.IDLE


def test_a_reset_ends_homing_with_an_alarm():
    bench = homing_bench()
    bench.say("$H", 1.0)
    bench.say(RESET, 2.0)
    assert "ALARM:6" in bench.heard
    assert bench.ask().state is State.ALARM


def homing_fluidnc():
    """Return a FluidNC board that can home, unlocked."""
    bench = homing_bench(firmware="fluidnc")
    bench.board.boot()
    bench.wait(2.0)
    assert "Unlocked" in bench.say("$X")[0]
    bench.heard.clear()
    return bench


def answers(bench):
    """Return what the board has said so far, without messages for people."""
    return [line for line in bench.heard if not line.startswith("[MSG")]


FLUIDNC = "Grbl 4.0 [FluidNC v4.0.5-pre2 (esp32-wifi) '$' for help]"


@pytest.mark.parametrize(
    ("resets", "wanted"), [(1, ["ALARM:6", FLUIDNC]), (2, ["ALARM:6", FLUIDNC] * 2)]
)
def test_fluidnc_reads_two_resets_together_while_it_homes_and_answers_both(resets, wanted):
    bench = homing_fluidnc()
    bench.say("$HX", 0.3)
    for _ in range(resets):
        bench.say(RESET, 0.02)
    bench.wait(2.0)
    assert answers(bench) == wanted
    assert bench.ask().state is State.ALARM


def test_fluidnc_obeys_a_reset_only_after_its_wait_at_a_switch_and_starts_to_pull_off():
    bench = homing_fluidnc()
    bench.board.settings.values[27] = 10.0
    bench.say("$HX", 0.3)
    while bench.board.drive.moving:
        bench.wait(0.001)
    bench.wait(0.05)
    at_switch = bench.x
    assert bench.say(RESET, 0.19) == []
    assert "ALARM:6" in bench.wait(0.03)
    bench.wait(2.0)
    assert 1.0 < at_switch - bench.x < 5.0  # what its segment buffer holds of the pull-off
    bench.say("$X")
    bench.say("G91G1X-50F3000", 3.0)
    assert bench.ask().pins == "X"  # it does not look at the switch again
    assert "ALARM:12" in bench.say("$HX", 1.0)
    bench.board.reset()
    bench.wait(2.0)
    assert bench.ask().pins is None


def test_a_fluidnc_board_stays_locked_while_an_axis_that_homes_has_not():
    bench = homing_fluidnc()
    bench.board.boot()
    bench.wait(2.0)
    assert bench.ask().state is State.ALARM
    assert bench.say("$HX", 20.0)[-1] == "ok"
    assert bench.ask().state is State.ALARM
    for letter in "YZABC":
        bench.say(f"$H{letter}", 20.0)
    assert bench.ask().state is State.IDLE


def test_fluidnc_answers_homing_that_failed_and_does_not_restart():
    bench = homing_fluidnc()
    bench.board.set_switch(0, SwitchState.OPEN)
    bench.say("$HX", 20.0)
    assert answers(bench) == ["ALARM:9", "ok"]
    assert bench.ask().state is State.ALARM


@pytest.mark.parametrize("angles_deg", [None, (88, 142, -2, 0, 0), (80, 80, 0, 0, 0)])
def test_homing_ends_in_the_posture_of_the_arm_file(angles_deg):
    """Motors that count down there seek downwards, as `$23` of a board set up for it says."""
    config = config_of(homing=True)
    there = config.model.arm.ik(config.model.reference.pose)
    if angles_deg:
        there = Joints(tuple(map(math.radians, angles_deg)))
    config = replace(config, homing=HomingSettings(there, 10.0))
    bench = Bench({}, config=config)
    for letter in "XYZABC":
        home(bench, f"$H{letter}", longest_s=400.0, look_s=0.1)
    assert bench.ask().state is State.IDLE
    for found, wanted in zip(bench.device.world.joints, there, strict=True):
        assert found == pytest.approx(wanted, abs=0.01)


# -- The arm ---------------------------------------------------------------------------------------


def test_the_factory_delay_switches_the_motors_off_after_every_move():
    bench = Bench({**MACHINE, 1: 25})
    assert not bench.device.world.energised
    bench.say("G1X5F3000", 0.1)
    assert bench.device.world.energised
    lasts_s = 5 / 50 + 50 / SLOPE
    bench.wait(lasts_s - 0.1)
    assert bench.device.world.energised
    before = bench.device.world.joints["shoulder"]
    bench.wait(0.05)
    assert not bench.device.world.energised
    assert bench.device.world.joints["shoulder"] < before
    assert bench.device.registers[0] == 50
    assert bench.say("$1=255", 0.1) == ["ok"]
    bench.say("G1X10F3000", 5.0)
    assert bench.device.world.energised


def test_sleep_switches_them_off_until_a_reset_which_leaves_the_board_locked():
    bench = Bench()
    assert bench.say("$SLP") == ["ok", "[MSG:Sleeping]"]
    bench.wait(0.5)
    assert not bench.device.world.energised
    assert bench.say("$X") == []
    bench.say(RESET, 0.25)
    assert bench.ask() is None  # seen: it takes 0.26 s
    bench.wait(0.25)
    assert (bench.ask().state, bench.device.world.energised) == (State.ALARM, True)


@every_row(
    "kind, device, shut, half, wide",
    [
        ("servo", {}, "M3S0", "M3S500", "M3S1000"),
        ("servo", {"servo_closed": 90.0, "servo_open": 10.0}, "M3S90", "M3S50", "M3S10"),
        ("servo", {"servo": "M67E2"}, "M67E2Q0", "M67E2Q500", "M67E2Q1000"),
        ("output", {}, "M8", None, "M9"),
        ("output", {"gripper_closes": False}, "M9", None, "M8"),
        ("output", {"outputs": ("flood", "P3"), "gripper_output": 1}, "M62P3", None, "M63P3"),
    ],
)
def test_a_gripper_on_an_output_takes_its_time(kind, device, shut, half, wide):
    bench = Bench({}, config=config_of(kind, **device), firmware="grblhal")
    world, speed = bench.device.world, bench.device.board.build.finger_mm_s
    for line, opening_mm in ((shut, 0.0), (wide, 76.0), (half, 38.0)):
        if line is None:
            continue
        before = world.opening_mm
        bench.say(line)
        assert world.opening_mm == pytest.approx(before)
        bench.wait(abs(before - opening_mm) / speed)
        assert world.opening_mm == pytest.approx(opening_mm)


def test_outputs_wait_for_the_motion_before_them_and_show():
    bench = Bench(firmware="grblhal")
    bench.say("G1X5F600", 0.02)
    bench.say("M8", 0.1)
    assert not bench.device.board.details()["outputs"]["flood"]
    bench.put("M65P1\n")
    bench.wait(1.0)
    bench.say("M3S700")
    bench.say("M64P1")
    outputs = bench.device.board.details()["outputs"]
    assert (outputs["flood"], outputs["spindle"], outputs["speed"]) == (True, "M3", 700)
    assert outputs["digital"] == {"1": True}
    assert bench.ask().speed == 700
    assert bench.ask().accessories == "SF"
    bench.say(RESET, 0.3)
    assert bench.device.board.details()["outputs"]["spindle"] == "M5"


def test_a_saved_board_knows_its_settings_its_place_and_its_lock():
    bench = Bench({**MACHINE, 22: 1})
    bench.say("$X")
    bench.say("G1X5Y-3F3000", 1.0)
    bench.say("$110=4000")
    bench.say("G1X100F1500", 0.5)
    bench.say(RESET, 2.0)
    bench.device.set_input(1, True)
    saved = bench.device.to_json()
    again = Bench({}, saved={"dialect": "grbl", **saved})
    assert again.device.registers == bench.device.registers
    assert again.device.world.motors == bench.device.world.motors
    assert again.ask().state is State.ALARM
    assert again.ask().machine_position == bench.ask().machine_position
    assert again.board.settings[110] == 4000.0
    assert again.banners == []
    assert again.ask().pins == "D"
    again.say("$X")
    again.say("G91G1X1F600", 2.0)
    assert again.board.drive.counts[0] - bench.board.drive.counts[0] == 10
