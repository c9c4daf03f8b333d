"""A simulated GRBL board behaves as the firmware was observed to, and turns the arm's motors."""

import math
from dataclasses import replace
from functools import partial

import pytest
from amounts import every_row
from grbl_bench import (
    HOMING,
    MACHINE,
    SLOPE,
    Bench,
    config_of,
    homing_bench,
    stands_at,
    with_switches_ahead,
)

from armdrive.config.sections import HomingSettings
from armdrive.errors import ArmFileError, BadRequest
from armdrive.registry import simulate
from armdrive.registry.arm_files import parse_arm
from armdrive.sim.mechanics.motors import LimitSwitch, SwitchState
from firmware_protocol.grbl import State, keys
from kinematics import JOINT_NAMES, Joints

HOLD, RESUME, RESET, CANCEL = "!", "~", "\x18", "\x85"
LIMITED = {**MACHINE, 21: 1}
BRAKING = 25.0**2 / (2 * SLOPE)
"""The units in which 25 units/s are braked."""
RAMP = BRAKING * 10
"""The same in steps, by which the arm overruns a dead stop."""


# -- Lines and answers -----------------------------------------------------------------------------


@every_row(
    "firmware, told, ring",
    [
        ("grbl", ["[OPT:V,15,128]"], 128),
        ("mega5x", ["[OPT:VNMGH,35,255,0]", "[AXS:6:XYZABC]"], 255),
        ("grblhal", ["[OPT:VNML+,100,1024,6,0]", "[AXS:6:XYZABC]", "[FIRMWARE:grblHAL]"], 1023),
        ("fluidnc", ["[OPT:MPHS]"], 256),
    ],
)
def test_every_firmware_says_what_it_is_and_its_full_ring_drops_bytes_silently(
    firmware, told, ring
):
    bench = Bench(firmware=firmware)
    assert len(bench.banners) == 1
    said = bench.say("$I")
    assert set(told) < set(said)
    assert said[-1] == "ok"
    bench.heard.clear()
    bench.say(HOLD)  # nothing is read any more
    bench.put("G91G1X0F1\n" * 150)
    assert bench.wait(0.2) == []
    assert bench.ask().free_bytes == 0
    assert bench.device.board.details()["lost_bytes"] == 150 * 10 - ring
    bench.say(RESUME, 2.0)
    assert bench.heard.count("ok") == ring // 10


@every_row(
    "line, answer",
    [
        ("$0=2", "error:6"),
        ("$100=-1", "error:4"),
        ("$99=1", "error:3"),
        ("$H", "error:5"),
        ("G2X1Y1I1F100", "error:20"),
        ("G1X1", "error:22"),
        ("$J=X1", "error:22"),
        ("X1X2", "error:25"),
        ("$256=1", "error:3"),
        ("$N0=G91", "error:3"),
        ("G1F300X" + "0" * 250 + "1", "error:11"),
        ("G1F300X" + "0" * 200 + "1", "ok"),
        ("$/stepping/idle_ms", "error:3"),
    ],
)
def test_a_line_is_answered_with_its_error_number(line, answer):
    assert Bench(firmware="mega5x").say(line, 3.0)[-1:] == [answer]


def test_after_a_refused_line_grblhal_refuses_all_gcode_until_an_empty_line():
    """Observed; a `$` line that is carried out, a jog cancel and a reset end it as well."""
    bench = Bench(firmware="grblhal")
    assert [bench.say(line) for line in ("FOO", "G91", "M8", "", "G91")] == [
        *[["error:2"]] * 3,
        *[["ok"]] * 2,
    ]
    for end in ("$I\n", CANCEL, RESET):
        assert bench.say("FOO") == ["error:2"]
        bench.put(end)
        bench.wait(0.5)
        assert bench.say("G91") == ["ok"]
    other = Bench()
    assert [other.say("FOO"), other.say("G91")] == [["error:2"], ["ok"]]


def test_a_change_of_settings_blocks_and_loses_what_arrives_meanwhile():
    bench = Bench()
    bench.put("$110=5000\nG1X1F600\n")
    assert bench.wait(0.5) == ["ok"]
    assert bench.device.board.details()["lost_bytes"] == 9
    patient = Bench(firmware="grblhal")
    patient.put("$110=5000\nG1X1F600\n")
    assert patient.wait(0.5) == ["ok", "ok"]
    assert bench.board.settings[110] == patient.board.settings[110] == 5000.0


def test_fluidnc_names_its_settings():
    bench = Bench(firmware="fluidnc")
    for line, said in (
        ("$/stepping/idle_ms", "$/stepping/idle_ms=255"),
        ("$/Stepping/Idle_ms=25", "ok"),
        ("$/axes/y/max_rate_mm_per_min=70", "ok"),
        ("$/axes/y/homing/feed_scaler", "$/axes/y/homing/feed_scaler=5.000"),
        ("$/stepping/idle", "error:3"),
        ("$/axes/w/steps_per_mm", "error:3"),
        ("$100=2", "error:3"),
        ("$10=3", "ok"),
        ("$/axes/x/steps_per_mm=x", "[MSG:ERR: Bad numeric value]"),
    ):
        assert bench.say(line)[0] == said
    assert (bench.board.settings[1], bench.board.settings[111]) == (25, 70)
    listed = {line.partition("=")[0] for line in bench.say("$$", 0.5)}
    assert {"$10", "$22", "$111"} < listed
    assert not {"$1", "$11"} & listed
    factory = Bench({}, factory=True).say("$$", 0.5)
    assert {"$1=25", "$10=1", "$100=250.000", "$110=500.000", "$120=10.000"} < set(factory)


def test_fluidnc_echoes_lines_once_it_has_heard_a_control_character():
    bench = Bench(firmware="fluidnc")
    assert bench.say("\x0bG91")[0].startswith("G91")
    assert bench.say("\x0cG91") == ["ok"]


def test_noise_is_answered_by_errors_and_breaks_nothing():
    bench = Bench()
    noise = bytes(byte for byte in range(256) if byte not in b"!~\x18") * 8
    for start in range(0, len(noise), 37):
        bench.put(noise[start : start + 37])
        bench.wait(0.01)
    bench.wait(5.0)
    said = {line.partition(":")[0] for line in bench.heard if line[0] not in "<[G"}
    assert said <= {"ok", "error"}
    bench.say("")  # an end for what has been begun
    assert bench.say("G1X1F3000", 1.0)[-1] == "ok"
    assert bench.x == 1.0


# -- Reports ---------------------------------------------------------------------------------------


def test_reports_are_answered_at_a_hundred_hertz_and_run_together_at_five_hundred():
    for asked_hz, least, most in ((100, 99, 101), (500, 140, 210)):
        bench = Bench({**MACHINE, 10: 1})
        bench.say("$J=G91X100F600")
        before = len(bench.reports)
        for _ in range(asked_hz):
            bench.say("?", 1 / asked_hz)
        assert least <= len(bench.reports) - before <= most


def test_the_mask_says_what_reports_tell():
    bench = Bench()
    first = bench.ask()
    assert (first.machine_position[0], first.free_blocks, first.free_bytes) == (0.0, 35, 255)
    assert first.others[0].startswith("WCO:")
    assert bench.ask().others == ("Ov:100,100,100",)
    bench.say("$10=0")
    assert (bench.ask().machine_position, bench.ask().free_blocks) == (None, None)
    hal = with_switches_ahead(Bench({10: 3}, firmware="grblhal"), 0.0)
    for mask, parts in ((3, set()), (91, {"|FS:", "|Pn:", "|Ov:"})):
        hal.say(f"$10={mask}")
        told = [hal.ask().line for _ in range(12)]
        assert {part for part in ("|FS:", "|Pn:", "|Ov:") if part in "".join(told)} == parts


# -- Motion ----------------------------------------------------------------------------------------


def test_a_move_takes_the_time_of_its_trapezoid_and_its_state_is_run():
    bench = Bench()
    assert bench.say("G1X50F1500", 0.02) == ["ok"]  # planned, not arrived
    bench.wait(1.0)
    assert (bench.ask().state, bench.reports[-1].feed) == (State.RUN, 1500)
    assert bench.x == pytest.approx(25.0, abs=1.0)
    bench.finish()
    assert (bench.x, bench.ask().state) == (50.0, State.IDLE)
    assert bench.device.world.motors[0] == 500


def test_with_the_planner_full_a_line_waits_for_its_ok():
    bench = Bench(firmware="grbl")
    bench.put("".join(f"G1X{n}F60\n" for n in range(1, 18)))
    assert bench.wait(0.09).count("ok") == 15
    assert bench.ask().free_blocks == 0
    bench.finish()
    assert (bench.heard.count("ok"), bench.x) == (17, 17.0)


def test_a_hold_brakes_along_the_path_and_goes_on_without_a_lost_step():
    bench = Bench()
    bench.say("G1X50Y-20F1500", 1.0)
    bench.put(HOLD)
    bench.wait(0.002)
    first = bench.ask()
    assert (first.state, first.sub_state) == (State.HOLD, 1)
    assert bench.say("X49Y-20", 0.02) == ["ok"]  # observed: lines are read until it stands
    bench.say(RESUME, 0.2)  # not heard before it stands
    second = bench.ask()
    assert (second.state, second.sub_state, second.feed) == (State.HOLD, 0, 0)
    way = second.machine_position[0] - first.machine_position[0]
    along = math.hypot(50, 20) / 50
    assert way * along == pytest.approx(25.0 * 0.09 + BRAKING, abs=0.2)
    assert bench.say("G1X1F3000", 1.0) == []
    bench.say(RESUME)
    bench.finish()
    assert (bench.x, bench.board.drive.counts[1]) == (1.0, -200)
    assert bench.device.world.motors - bench.device.registers == Bench().device.world.motors


def test_the_safe_stop_keeps_the_position_and_drops_what_was_read():
    bench = Bench()
    bench.say("G1X50F1500", 1.0)
    bench.say(HOLD, 0.3)
    at = bench.ask()
    bench.put("G1X5F3000\n" * 5)
    bench.wait(0.1)
    assert bench.say(RESET, 0.5) == ["Grbl 1.1q ['$' for help]"]
    assert (bench.ask().state, bench.reports[-1].machine_position) == (
        State.IDLE,
        at.machine_position,
    )
    bench.finish()
    assert bench.x == pytest.approx(27.0, abs=1.0)
    assert bench.device.world.motors[0] == bench.board.drive.counts[0]


def test_places_are_reached_in_every_mode_and_axes_are_those_of_the_board():
    bench = Bench(config=config_of(axes="ZYXABC"))
    start = bench.device.world.motors
    for line, place in (
        ("G91G0X5", 5.0),
        ("G0X5", 10.0),
        ("G90G0X1", 1.0),
        ("G20G0X1", 25.4),
        ("G21G55G1X3Z1F600", 3.0),
    ):
        assert bench.say(line, 5.0) == ["ok"]
        assert bench.x == pytest.approx(place), line
    assert (bench.device.world.motors - start)[:3] == (10, 0, 30)
    assert bench.device.registers[:3] == (10, 0, 30)
    more = Bench({}, config=config_of("servo"), axes="XYZABC")
    more.say("G1C10X2F600", 3.0)
    assert more.ask().machine_position == (2, 0, 0, 0, 0, 10)
    assert len(more.device.registers) == 5


# -- Jogs ------------------------------------------------------------------------------------------

JOG_2 = "$J=G91X2F1500\n"
"""Two units at 25 units a second, from which it takes 0.63 units to stop."""


def test_a_cancel_or_a_hold_ends_a_jog_and_a_cut_of_the_cable_does_not():
    bench = Bench()
    bench.say("$J=G91X16F1500", 0.3)
    assert bench.say("G1X1F600") == ["error:9"]
    assert bench.ask().state is State.JOG
    before = bench.x
    bench.say(CANCEL, 0.3)
    assert bench.ask().state is State.IDLE
    assert bench.x - before == pytest.approx(25.0 * 0.09 + BRAKING, abs=0.25)
    bench.say("$J=G91X16F1500", 0.3)
    bench.say(HOLD, 0.3)
    assert bench.ask().state is State.IDLE
    bench.say("$J=G91X100F2400", 0.5)
    at = bench.x
    bench.link.unplug()
    bench.device.transmit(bench.now_s + 1.0)
    assert bench.x - at == pytest.approx(38.0, abs=4.0)  # as measured


def test_a_cancel_ends_only_what_the_planner_holds():
    """Eight lines at once, as a USB port takes them: measured with a cancel 4 and 6 ms later."""
    early = Bench(baud=None)
    early.put(JOG_2 * 8)
    early.wait(0.0005)
    early.put(CANCEL)
    early.finish()
    assert (early.x, early.heard.count("ok")) == (16.0, 8)
    late = Bench(baud=None, firmware="grbl")
    late.put(JOG_2 * 8)
    late.wait(0.0013)
    assert late.heard.count("ok") == 1
    late.put(CANCEL)
    late.finish()
    assert late.x == pytest.approx(12.2, abs=2.5)
    for firmware in ("grblhal", "mega5x"):  # these clear the ring
        cleared = Bench(baud=None, firmware=firmware)
        cleared.put(JOG_2 * 8)
        cleared.wait(0.0013)
        cleared.put(CANCEL)
        cleared.finish()
        assert cleared.x < 4.0
        assert cleared.heard.count("ok") < 5


# -- Alarms, resets, switches ----------------------------------------------------------------------


@every_row(
    "firmware, off_s",
    [
        ("grbl", (0.255, 0.755)),
        ("mega5x", (0.255, 0.755)),
        ("fluidnc", None),
        ("grblhal", None),
    ],
)
def test_a_reset_in_motion_is_an_alarm_and_takes_the_current_away_as_its_firmware_does(
    firmware, off_s
):
    bench = Bench({**MACHINE, 1: 255}, firmware=firmware)
    before, shoulder = bench.device.world.motors[0], bench.device.world.joints["shoulder"]
    bench.say("G1X100F1500", 1.0)
    here = bench.board.drive.counts[0]
    bench.put(RESET)
    began_s, off = bench.now_s, []
    for _ in range(200):
        bench.wait(0.005)
        if not bench.device.world.energised:
            off.append(bench.now_s - began_s)
    assert bench.heard.count("ALARM:3") == 1
    counted = bench.board.drive.counts[0]
    runs_on = 0.11 * 250 if firmware == "fluidnc" else 0.0
    assert counted - here == pytest.approx(runs_on, abs=4)
    assert bench.device.world.motors[0] - before == pytest.approx(counted + RAMP, abs=1.5)
    assert bench.device.world.energised
    if off_s is None:
        assert not off
    else:
        assert (off[0], off[-1]) == pytest.approx(off_s, abs=0.015)
        assert bench.device.world.joints["shoulder"] < shoulder
    assert bench.ask().state is State.ALARM
    assert (bench.say("G1X5F100"), bench.say("$J=X5F100")) == (["error:9"], ["error:8"])
    assert bench.say("$X") == ["[MSG:Caution: Unlocked]", "ok"]
    assert bench.ask().state is State.IDLE


@pytest.mark.parametrize(("firmware", "greetings"), [("grblhal", 2), ("mega5x", 1)])
def test_a_second_reset_during_one_in_motion_makes_grblhal_greet_twice(firmware, greetings):
    bench = Bench(firmware=firmware)
    bench.say("G91G1X50F600", 0.5)
    for _ in range(2):
        bench.put(RESET)
        bench.wait(0.02)
    bench.wait(2.0)
    assert len(bench.banners[1:]) == greetings


def test_fluidnc_carries_out_one_line_that_it_read_in_a_hold():
    bench = Bench(firmware="fluidnc")
    for sent, state, x in ((RESET, State.IDLE, 5.0), (RESET + HOLD, State.HOLD, 5.0)):
        bench.say(HOLD)
        bench.put("G91G1X5F3000\n" * 3)
        bench.wait(0.2)
        assert bench.say(sent, 2.0)[-1] == "ok"
        assert (bench.ask().state, bench.x) == (state, x)
    bench.say(RESET, 1.0)
    assert (bench.ask().state, bench.x) == (State.IDLE, 5.0)


def test_a_reset_board_reports_zero_whatever_the_truth_and_the_arm_has_sagged():
    bench = Bench()
    bench.say("G1X50F3000", 3.0)
    before = bench.device.world.motors
    bench.device.board.reset()
    assert bench.wait(0.5) == []  # its loader waits, the motors have no current
    assert not bench.device.world.energised
    bench.wait(2.0)
    assert len(bench.banners) == 2
    assert (bench.ask().state, bench.reports[-1].machine_position) == (State.IDLE, (0.0,) * 6)
    assert bench.device.world.energised
    assert bench.device.world.motors[1] != before[1]


def test_sleep_switches_the_motors_off_until_a_reset_which_leaves_the_board_locked():
    bench = Bench()
    assert bench.say("$SLP") == ["ok", "[MSG:Sleeping]"]
    bench.wait(0.5)
    assert not bench.device.world.energised
    assert bench.say("$X") == []
    bench.say(RESET, 0.25)
    assert bench.ask() is None  # seen: it takes 0.26 s
    bench.wait(0.25)
    assert (bench.ask().state, bench.device.world.energised) == (State.ALARM, True)
    assert Bench({62: 0.0}, firmware="grblhal").say("$SLP") == ["error:3"]


@pytest.mark.parametrize(
    ("firmware", "locks"), [("mega5x", True), ("grbl", True), ("grblhal", False)]
)
def test_a_board_starts_locked_with_homing_or_while_a_switch_is_pressed(firmware, locks):
    """Observed on the Mega, also on the build that otherwise ignores its switches."""
    assert (Bench(firmware=firmware, homing=True).ask().state is State.ALARM) == locks
    bench = with_switches_ahead(Bench(firmware=firmware), 0.0)
    bench.say(RESET, 0.2)
    assert bench.ask().state is State.IDLE
    bench.say("$21=1")
    said = bench.say(RESET, 0.2)
    assert ("[MSG:Check Limits]" in said, bench.ask().state is State.ALARM) == (locks, locks)


def test_control_pins_do_what_their_commands_do():
    bench = Bench()
    bench.say("G1X10F600", 0.5)
    bench.device.set_input(2, True)
    bench.wait(0.5)
    assert (bench.ask().state, bench.reports[-1].pins) == (State.HOLD, "H")
    bench.device.set_input(2, False)
    bench.device.set_input(3, True)
    bench.finish()
    assert bench.x == 10.0
    bench.device.set_input(4, True)
    bench.wait(0.5)
    assert len(bench.banners) == 2


def test_a_hard_limit_stops_dead_and_the_board_is_mute_until_its_reset():
    bench = with_switches_ahead(Bench(LIMITED, firmware="grbl"), 10.0)
    bench.say("G1X50F1500", 2.0)
    assert bench.heard[-2:] == ["ALARM:1", "[MSG:Reset to continue]"]
    assert bench.x == pytest.approx(10.0, abs=0.3)
    assert bench.ask() is None
    assert bench.say("$X", 1.0) == []
    assert not bench.device.world.energised
    bench.say(RESET, 0.5)
    assert (bench.ask().state, bench.reports[-1].pins) == (State.ALARM, "X")
    assert bench.device.world.energised
    bench.say("$X")
    bench.say("G1X1F1500", 1.0)  # backing off the switch is a change as well
    assert bench.heard.count("ALARM:1") == 2


@pytest.mark.parametrize(
    "act",
    [
        lambda device: device.board.set_switch(2, SwitchState.CLOSED),
        lambda device: device.push((60, 0, 0, 0, 0, 0)),
    ],
)
def test_a_switch_that_closes_at_rest_is_a_hard_limit(act):
    bench = with_switches_ahead(Bench(LIMITED, firmware="grblhal"), 5.0)
    act(bench.device)
    assert bench.wait(0.1) == ["ALARM:1", "[MSG:Reset to continue]"]
    assert bench.ask().state is State.ALARM  # the newer firmware goes on reporting
    with pytest.raises(BadRequest, match="0 to 5"):
        bench.device.board.set_switch(6, SwitchState.OPEN)
    usual = with_switches_ahead(Bench(LIMITED), 5.0)  # this build ignores $21=1
    act(usual.device)
    assert usual.wait(0.1) == []
    assert usual.ask().pins


@pytest.mark.parametrize(("goes", "after"), [(True, State.RUN), (False, State.IDLE)])
def test_fluidnc_without_homing_comes_out_of_a_limit_alarm_unlocked_or_hung(goes, after):
    bench = with_switches_ahead(Bench(LIMITED, firmware="fluidnc"))
    if goes:
        bench.say("G91G1X50F3000", 0.3)
    bench.board.set_switch(0, SwitchState.CLOSED)
    assert "ALARM:1" in bench.wait(1.0)
    bench.board.set_switch(0, SwitchState.FREE)
    bench.say(RESET, 1.0)
    assert bench.ask().state is after
    if goes:
        assert bench.say("G91", 1.0) == []
        bench.say(HOLD)
        assert "ALARM:3" in bench.say(RESET, 1.0)
        bench.say("$X")
        assert bench.ask().state is State.IDLE


# -- Homing ----------------------------------------------------------------------------------------


def home(bench, line="$H", longest_s=30.0, look_s=0.01):
    """Home, and return how long that takes, in s."""
    began_s = bench.now_s
    bench.put(f"{line}\n")
    while "ok" not in bench.wait(look_s):
        assert bench.now_s < began_s + longest_s
    return bench.now_s - began_s


def test_homing_takes_the_measured_time_and_ends_a_pull_off_before_the_switches():
    assert home(homing_bench(), "$HX") == pytest.approx(3.6, abs=0.2)  # seen on a Mega
    bench = homing_bench()
    bench.put("$H\n")
    bench.wait(0.5)
    assert bench.ask() is None  # only FluidNC reports meanwhile
    bench.wait(30.0)
    assert (bench.ask().state, bench.reports[-1].machine_position) == (State.IDLE, (-1.0,) * 6)
    expected = [switch.at - 10 for switch in bench.board.switches.by_axis.values()]
    assert list(bench.device.world.motors) == expected


def test_an_axis_homes_downwards_where_its_bit_says_so():
    bench = homing_bench({**HOMING, 23: 1})
    low = LimitSwitch(partial(stands_at, bench, 0), -300, -1)
    bench.board.switches.by_axis = {**bench.board.switches.by_axis, 0: low}
    bench.say("$HX", 20.0)
    assert bench.ask().machine_position == (-199.0, 0, 0, 0, 0, 0)
    assert bench.device.world.motors[0] == -290


def test_each_motion_of_homing_counts_from_zero_so_the_place_is_lost_when_it_fails():
    """Observed on the Mega."""
    bench = homing_bench()
    bench.say("$X")
    bench.say("G91G1X20F3000", 2.0)
    bench.put("$HX\n")
    bench.wait(0.3)
    assert 0 < bench.x < 20.0
    assert "ALARM:6" in bench.say(RESET, 2.0)
    bench.say("$X")
    bench.put("$HX\n")
    while not bench.board.switches.mask():
        bench.wait(0.01)
    while not bench.board.drive.moving:
        bench.wait(0.002)
    bench.put(RESET)  # while it backs off, as if that had failed
    assert "ALARM:8" in bench.wait(1.5)


@every_row(
    "firmware, stuck, said",
    [
        ("mega5x", SwitchState.OPEN, ["ALARM:9", "ok", "Grbl 1.1q ['$' for help]"]),
        ("grblhal", SwitchState.OPEN, ["ALARM:9", "GrblHAL 1.1f ['$' or '$HELP' for help]"]),
        ("fluidnc", SwitchState.OPEN, ["ALARM:9", "ok"]),
        ("mega5x", SwitchState.CLOSED, ["ALARM:8", "ok", "Grbl 1.1q ['$' for help]"]),
    ],
)
def test_a_switch_that_sticks_is_not_found_or_not_left(firmware, stuck, said):
    bench = homing_bench({**HOMING, 22: 3}, firmware=firmware)
    bench.device.board.set_switch(3, stuck)
    start = bench.device.world.motors[3]
    bench.heard.clear()
    bench.say("$HA", 60.0)
    assert [line for line in bench.heard if not line.startswith("[MSG")] == said
    if stuck is SwitchState.OPEN:
        assert bench.device.world.motors[3] - start == 1.5 * 200 * 10
    assert bench.ask().state is State.ALARM
    assert bench.device.world.energised


def test_homing_an_axis_that_the_build_refuses_leaves_the_board_in_home_until_a_reset():
    bench = Bench({**MACHINE, 22: 1}, firmware="grbl")
    assert bench.say("$HX") == ["error:3"]
    assert bench.ask().state is State.HOME
    assert bench.say("$I") == ["error:8"]
    assert bench.say(RESET, 1.0)[0] == "ALARM:6"
    bench.say("$X")
    bench.say("$22=0")
    assert bench.say("$HX") == ["error:5"]


def homing_fluidnc(values=HOMING):
    """Return a FluidNC board that can home, locked as after its start."""
    bench = homing_bench(values, firmware="fluidnc")
    bench.board.boot()
    bench.wait(2.0)
    bench.heard.clear()
    return bench


def test_fluidnc_reports_while_it_homes_and_stays_locked_until_each_axis_has():
    bench = homing_fluidnc({**HOMING, keys.HOMING_FEED: 300})
    bench.put("$HX\n")
    bench.wait(0.5)
    assert bench.ask().state is State.HOME
    bench.wait(10.0)
    assert bench.ask().machine_position[0] == 0.0  # `mpos_mm` of its configuration
    assert bench.ask().state is State.ALARM
    fast = homing_bench({**HOMING, keys.HOMING_FEED: 300})
    longer_s = home(bench, "$HY") - home(fast, "$HY")  # it backs off as slowly as it approaches
    assert longer_s == pytest.approx(2 * (1 / 5.0 - 2 * math.sqrt(1 / SLOPE)), abs=0.05)
    for letter in "ZABC":
        home(bench, f"$H{letter}")
    assert bench.ask().state is State.IDLE


@pytest.mark.parametrize("resets", [1, 2])
def test_fluidnc_reads_two_resets_together_while_it_homes_and_answers_both(resets):
    bench = homing_fluidnc()
    bench.say("$HX", 0.3)
    for _ in range(resets):
        bench.say(RESET, 0.02)
    bench.wait(2.0)
    assert (bench.heard.count("ALARM:6"), len(bench.banners)) == (resets, resets)


def test_fluidnc_obeys_a_reset_only_after_its_wait_at_a_switch_and_starts_to_pull_off():
    bench = homing_fluidnc({**HOMING, 27: 10.0})
    bench.say("$HX", 0.3)
    while bench.board.drive.moving:
        bench.wait(0.001)
    bench.wait(0.05)
    at_switch = bench.x
    assert bench.say(RESET, 0.19) == []
    assert "ALARM:6" in bench.wait(0.03) or "ALARM:8" in bench.heard
    bench.wait(2.0)
    assert 1.0 < at_switch - bench.x < 5.0  # what its segment buffer holds of the pull-off


@pytest.mark.parametrize("angles_deg", [None, (88, 142, -2, 0, 0), (80, 80, 0, 0, 0)])
def test_homing_ends_in_the_posture_of_the_arm_file(angles_deg):
    """Motors that count down there seek downwards, as `$23` of a board set up for it says."""
    config = config_of(homing=True)
    there = config.model.arm.ik(config.model.reference.pose)
    if angles_deg:
        there = Joints(tuple(map(math.radians, angles_deg)))
    bench = Bench({}, config=replace(config, homing=HomingSettings(there, 10.0)))
    for letter in "XYZABC":
        home(bench, f"$H{letter}", longest_s=400.0, look_s=0.1)
    assert bench.ask().state is State.IDLE
    for found, wanted in zip(bench.device.world.joints, there, strict=True):
        assert found == pytest.approx(wanted, abs=0.01)


# -- The arm, its outputs and its files ------------------------------------------------------------


def test_the_factory_delay_switches_the_motors_off_after_every_move():
    bench = Bench({**MACHINE, 1: 25})
    assert not bench.device.world.energised
    bench.say("G1X5F3000", 0.1)
    assert bench.device.world.energised
    bench.wait(5 / 50 + 50 / SLOPE - 0.1)
    before = bench.device.world.joints["shoulder"]
    bench.wait(0.05)
    assert not bench.device.world.energised
    assert bench.device.world.joints["shoulder"] < before
    assert bench.device.registers[0] == 50
    assert bench.say("$1=255", 0.1) == ["ok"]
    bench.say("G1X10F3000", 5.0)
    assert bench.device.world.energised


@every_row(
    "kind, device, shut, half, wide",
    [
        ("servo", {}, "M3S0", "M3S500", "M3S1000"),
        ("servo", {"servo_closed": 90.0, "servo_open": 10.0}, "M3S90", "M3S50", "M3S10"),
        ("servo", {"servo": "M67E2"}, "M67E2Q0", "M67E2Q500", "M67E2Q1000"),
        ("output", {}, "M8", None, "M9"),
        ("output", {"gripper_closes": False}, "M9", None, "M8"),
        ("output", {"outputs": ("flood", "P3"), "gripper_output": 1}, "M64P3", None, "M65P3"),
    ],
)
def test_a_gripper_on_an_output_takes_its_time(kind, device, shut, half, wide):
    bench = Bench({}, config=config_of(kind, **device), firmware="grblhal")
    world, speed = bench.device.world, bench.device.board.build.finger_mm_s
    for line, opening_mm in ((shut, 0.0), (wide, 76.0), (half, 38.0)):
        if line is None:
            continue
        before = world.opening_mm
        assert bench.say(line) == ["ok"]
        assert world.opening_mm == pytest.approx(before)
        bench.wait(abs(before - opening_mm) / speed)
        assert world.opening_mm == pytest.approx(opening_mm)
    if kind == "servo":
        before = world.opening_mm
        bench.say("M5", 9.0)  # without a signal, a servo stays
        assert world.opening_mm == before


def test_outputs_wait_for_the_motion_before_them_and_show():
    bench = Bench(firmware="grblhal")
    bench.say("G1X5F600", 0.02)
    bench.say("M8", 0.1)
    assert bench.device.board.details()["outputs"] == {}
    bench.wait(1.0)
    bench.say("M64P1")
    bench.say("M3S700")
    on = {"flood": 1.0, "P1": 1.0, "spindle": 700.0}
    assert bench.device.board.details()["outputs"] == on
    assert bench.ask().speed == 700
    assert "A:SF" in bench.reports[-1].others
    bench.say(RESET, 0.3)
    assert bench.device.board.details()["outputs"] == {"P1": 1.0}


def test_a_saved_board_knows_its_settings_its_place_and_its_lock():
    bench = Bench({**MACHINE, 22: 1})
    bench.say("$X")
    bench.say("G1X5Y-3F3000", 1.0)
    bench.say("$110=4000")
    bench.say("G1X100F1500", 0.5)
    bench.say(RESET, 2.0)
    bench.device.set_input(1, True)
    again = Bench({}, saved={"dialect": "grbl", **bench.device.to_json()})
    assert again.device.registers == bench.device.registers
    assert again.device.world.motors == bench.device.world.motors
    assert (again.ask().state, again.reports[-1].pins) == (State.ALARM, "D")
    assert again.board.settings[110] == 4000.0
    assert again.banners == []
    again.say("$X")
    again.say("G91G1X1F600", 2.0)
    assert again.board.drive.counts[0] - bench.board.drive.counts[0] == 10


HUGE = 1.7e308


def board(**table):
    """Build the board of an arm file."""
    table = {"model": "teachmover", "connection": {"dialect": "grbl"}, **table}
    return simulate(parse_arm(table, name="bench")).device


@every_row(
    "table, named",
    [
        ({"grbl": {"accelerations": [500.0]}}, "grbl.accelerations must have 6 entries"),
        (
            {"grbl": {"gripper_output": 6}, "gripper": {"kind": "output"}},
            "grbl.gripper_output is bit 6",
        ),
        ({"limits_deg": {"base": [-HUGE, 90.0]}}, "correct limits_deg"),
        ({"homing": {"joints_deg": dict.fromkeys(JOINT_NAMES, HUGE)}}, "correct .*homing"),
        ({"speeds_deg_s": {"base": 3600.0}, "steps_per_turn": {"base": 1e7}}, "speeds"),
        ({"grbl": {"unit": "degrees"}, "steps_per_turn": {"base": 0.1}}, "grbl.unit"),
    ],
)
def test_an_arm_for_which_no_board_can_be_set_up_is_refused_by_the_keys(table, named):
    with pytest.raises(ArmFileError, match=named):
        board(**table)
