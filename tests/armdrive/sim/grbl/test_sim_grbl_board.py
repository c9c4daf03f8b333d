"""A simulated GRBL board's wire, alarms and files."""

import contextlib

import pytest
from amounts import every_row
from grbl_bench import BYTE_S, MACHINE, SLOPE, Bench, stream, with_switches_ahead
from hypothesis import given
from hypothesis import strategies as st

from armdrive.errors import ArmError, ArmFileError, BadRequest
from armdrive.registry import simulate
from armdrive.registry.arm_files import parse_arm
from armdrive.sim.device import HasSwitches, Resettable
from armdrive.sim.mechanics.motors import SwitchState
from firmware_protocol.grbl import State, Variant
from kinematics import JOINT_NAMES, KinematicsError


@pytest.mark.parametrize(
    ("firmware", "variant", "opt", "ring"),
    [
        ("grbl", Variant.GRBL, "[OPT:V,15,128]", 128),
        ("mega5x", Variant.GRBL, "[OPT:VNMGH,35,255,0]", 255),
        ("grblhal", Variant.GRBLHAL, "[OPT:VNML+,100,1024,6,0]", 1023),
        ("fluidnc", Variant.FLUIDNC, "[OPT:MPHS]", 256),
    ],
)
def test_every_firmware_says_what_it_is_and_its_full_ring_drops_bytes_silently(
    firmware, variant, opt, ring
):
    bench = Bench(firmware=firmware)
    assert [one.variant for one in bench.banners] == [variant]
    said = bench.say("$I")
    assert opt in said
    assert said[-1] == "ok"
    assert ("[AXS:6:XYZABC]" in said) == (firmware in ("mega5x", "grblhal"))
    bench.heard.clear()
    bench.say("!")  # nothing is read any more
    lines = 150
    bench.put("G4P0.001\n" * lines)
    assert bench.wait(0.2) == []
    assert bench.ask().free_bytes == (0 if firmware != "fluidnc" else 128)
    assert bench.device.board.details()["lost_bytes"] == lines * 9 - ring
    bench.say("~", 2.0)
    assert bench.heard.count("ok") == ring // 9


def test_an_empty_line_is_answered_within_two_milliseconds():
    bench = Bench()
    bench.say("")
    assert bench.heard[-1] == "ok"
    assert stream(bench, []) == 0.0
    one = stream(bench, ["G90G0X0"])  # no way at all
    assert one < 10e-3


def test_a_lost_byte_is_silent_and_moves_twelve_where_twelve_and_a_half_was_meant():
    bench = Bench()
    assert bench.say("G1X12.F3000", 2.0) == ["ok"]  # G1X12.5F3000 less one character
    assert bench.x == 12.0


def test_a_mega_takes_lines_of_two_hundred_characters():
    assert Bench(firmware="mega5x").say("G1F300X" + "0" * 200 + "1", 3.0) == ["ok"]


@pytest.mark.parametrize(("firmware", "most"), [("grbl", 79), ("grblhal", 256)])
def test_a_line_that_is_too_long_is_refused_whole(firmware, most):
    bench = Bench(firmware=firmware)
    assert bench.say("G1F300" + "X" + "0" * (most - 8) + "1", 3.0) == ["ok"]
    assert bench.say("G1F300" + "X" + "0" * (most - 7) + "1", 3.0) == ["error:11"]


def test_after_a_refused_line_grblhal_refuses_all_gcode_until_an_empty_line():
    """Observed; a `$` line that is carried out, a jog cancel and a reset end it as well."""
    bench = Bench(firmware="grblhal")
    assert [bench.say(line) for line in ("FOO", "G91", "M8", "")] == [
        *[["error:2"]] * 3,
        ["ok"],
    ]
    assert bench.say("G91") == ["ok"]
    for end in ("$G\n", "\x85", "\x18"):
        assert bench.say("FOO") == ["error:2"]
        bench.put(end)
        bench.wait(0.5)
        assert bench.say("G91") == ["ok"]
    assert bench.say("$FOO") == ["error:3"]
    assert bench.say("G91") == ["error:3"]
    other = Bench()
    assert [other.say("FOO"), other.say("G91")] == [["error:2"], ["ok"]]


@pytest.mark.parametrize(("firmware", "greetings"), [("grblhal", 2), ("mega5x", 1)])
def test_a_second_reset_during_one_in_motion_makes_grblhal_greet_twice(firmware, greetings):
    bench = Bench(firmware=firmware)
    bench.say("G91G1X50F600", 0.5)
    for _ in range(2):
        bench.put("\x18")
        bench.wait(0.02)
    bench.wait(2.0)
    assert len(bench.banners[1:]) == greetings


def test_grblhal_sleeps_only_if_its_settings_allow_it():
    bench = Bench({62: 0.0}, firmware="grblhal")
    assert bench.say("$SLP") == ["error:3"]
    bench.say("$62=1")
    assert bench.say("$SLP", 0.1) == ["ok", "[MSG:Sleeping]"]


def test_grblhal_says_once_that_nothing_is_on():
    bench = Bench(firmware="grblhal")
    assert [bench.ask().accessories for _ in range(30)].count("") == 1
    bench.say("M8")
    assert {one.accessories for one in (bench.ask() for _ in range(30))} == {"F", None}
    bench.say("M9")
    assert [bench.ask().accessories for _ in range(30)].count("") == 1


def test_the_mask_of_grblhal_can_leave_out_speeds_pins_and_overrides():
    bench = with_switches_ahead(Bench({10: 3}, firmware="grblhal"), 0.0)
    for mask, parts in ((3, set()), (91, {"feed", "pins", "overrides"})):
        bench.say(f"$10={mask}")
        told = [bench.ask() for _ in range(12)]
        seen = {
            part
            for part in ("feed", "pins", "overrides", "work_offset")
            for one in told
            if getattr(one, part) is not None
        }
        assert seen == parts


def test_the_rate_of_short_segments_is_the_measured_one():
    """317 a second by counting characters on a 328p, at 500 units/s^2: it waits for the motion."""
    names = [f"G90G1X{0.1 * (n + 1):.3g}F6000" for n in range(150)]
    counting = len(names) / stream(Bench(firmware="grbl"), names)
    single = len(names) / stream(Bench(firmware="grbl"), names, one_by_one=True)
    assert counting == pytest.approx(317, rel=0.1)
    assert single < counting


def test_in_check_mode_the_wire_is_the_limit():
    """485 to 534 lines a second, against 235 to 250 one at a time (and a slower host)."""
    lines = ["G90G1X10.123Y-4.5F1500"] * 150
    bench = Bench()
    bench.say("$C")
    rate = len(lines) / stream(bench, lines)
    bytes_each = len(lines[0]) + 1
    assert rate * bytes_each * BYTE_S > 0.95
    assert len(lines) / stream(bench, lines, one_by_one=True) < 0.85 * rate


def test_reports_are_answered_at_a_hundred_hertz_and_run_together_at_five_hundred():
    for asked_hz, least, most in ((100, 99, 101), (500, 140, 210)):
        bench = Bench({**MACHINE, 10: 1})
        bench.say("$J=G91X100F600")
        before = len(bench.reports)
        for _ in range(asked_hz):
            bench.say("?", 1 / asked_hz)
        assert least <= len(bench.reports) - before <= most


def test_offset_and_overrides_come_now_and_then():
    bench = Bench()
    for _ in range(40):
        bench.ask()
    assert [n for n, one in enumerate(bench.reports) if one.work_offset] == [0, 10, 20, 30]
    assert [n for n, one in enumerate(bench.reports) if one.overrides] == [1, 11, 21, 31]
    assert not any(one.work_offset and one.overrides for one in bench.reports)


def test_the_mask_says_what_reports_tell():
    bench = Bench()
    first = bench.ask()
    assert (first.machine_position[0], first.free_blocks, first.free_bytes) == (0.0, 35, 255)
    bench.say("$10=0")
    second = bench.ask()
    assert (second.machine_position, second.work_position[0]) == (None, 0.0)
    assert second.free_blocks is None


def test_a_change_of_settings_blocks_and_loses_what_arrives_meanwhile():
    bench = Bench()
    bench.put("$110=5000\n")
    bench.put("G1X1F600\n")
    assert bench.wait(0.5) == ["ok"]
    assert bench.device.board.details()["lost_bytes"] == 9
    assert bench.board.settings[110] == 5000.0
    patient = Bench(firmware="grblhal")
    patient.put("$110=5000\nG1X1F600\n")
    assert patient.wait(0.5) == ["ok", "ok"]


@every_row(
    "line, answer",
    [
        ("$0=2", "error:6"),
        ("$100=-1", "error:4"),
        ("$99=1", "error:3"),
        ("$20=1", "error:10"),
        ("$H", "error:5"),
        ("G2X1Y1I1F100", "error:20"),
        ("G1X1", "error:22"),
        ("$J=X1", "error:22"),
        ("X1X2", "error:25"),
        ("G93X1F60", "error:20"),
        ("$256=1", "error:3"),
        ("$N", "error:3"),
        ("$N0=G91", "error:3"),
        ("$I=mine", "error:3"),
        ("$RST=$", "error:3"),
    ],
)
def test_wrong_lines_are_refused_with_their_error_number(line, answer):
    assert Bench().say(line)[-1:] == [answer]


def test_fluidnc_names_its_settings():
    bench = Bench(firmware="fluidnc")
    assert not [line for line in bench.say("$$", 0.5) if line.startswith("$1=")]
    assert bench.say("$/stepping/idle_ms") == ["$/stepping/idle_ms=255", "ok"]
    assert bench.say("$/Stepping/Idle_ms=25") == ["ok"]
    assert bench.board.settings[1] == 25
    assert bench.say("$/axes/y/max_rate_mm_per_min=70") == ["ok"]
    assert bench.board.settings[111] == 70
    for line, answer in (
        ("$/stepping/idle", "error:3"),
        ("$/axes/w/steps_per_mm", "error:3"),
        ("$100=2", "error:162"),
        ("$22=1", "error:162"),
        ("$11=1", "error:3"),
        ("$1=255", "error:3"),
        ("$10=7", "error:80"),
        ("$10=3", "ok"),
    ):
        assert bench.say(line)[0] == answer
    for value in ("x", "nan"):
        said = bench.say(f"$/axes/x/steps_per_mm={value}")
        assert said == ["[MSG:ERR: Bad numeric value]", "ok"]
    assert bench.say("$/junction_deviation_mm=0.5") == ["ok"]
    assert bench.board.settings[11] == 0.5
    assert Bench().say("$/stepping/idle_ms") == ["error:3"]


def test_fluidnc_tells_few_settings_by_number():
    told = [line.partition("=")[0] for line in Bench(firmware="fluidnc").say("$$", 0.5)]
    groups = [f"${group + axis}" for group in (100, 110, 120, 130) for axis in range(6)]
    assert told == ["$13", "$20", "$21", "$22", "$23", "$30", "$32", *groups, "$10", "ok"]


def test_settings_of_the_factory_are_the_published_ones():
    said = Bench({}, factory=True).say("$$", 0.5)
    for line in ("$1=25", "$10=1", "$100=250.000", "$110=500.000", "$120=10.000", "$130=200.000"):
        assert line in said


def test_noise_is_answered_by_errors_and_breaks_nothing():
    bench = Bench()
    noise = bytes(byte for byte in range(256) if byte not in b"!~\x18\x84") * 8
    for start in range(0, len(noise), 37):
        bench.put(noise[start : start + 37])
        bench.wait(0.01)
    bench.wait(5.0)
    assert {line.partition(":")[0] for line in bench.heard if line[0] not in "<[G"} <= {
        "ok",
        "error",
    }
    bench.say("")  # an end for what has been begun
    assert bench.say("G1X1F3000", 1.0)[-1] == "ok"
    assert bench.x == 1.0


# -- Alarms ----------------------------------------------------------------------------------------

HOLD, RESUME, RESET, DOOR = "!", "~", "\x18", "\x84"
LIMITED = {**MACHINE, 21: 1}
SOFT = {**MACHINE, 22: 1, 20: 1}
RAMP = 25.0**2 / (2 * SLOPE) * 10
"""The steps of a ramp from 25 units/s, by which the arm overruns a dead stop."""


def test_a_reset_in_motion_is_an_alarm_and_loses_the_ramp_that_was_not_made():
    bench = Bench()
    before = bench.device.world.motors[0]
    bench.say("G1X100F1500", 1.0)
    assert bench.say(RESET, 0.4) == ["ALARM:3"]
    bench.wait(1.0)
    assert bench.heard[-2:] == ["Grbl 1.1q ['$' for help]", "[MSG:'$H'|'$X' to unlock]"]
    assert bench.ask().state is State.ALARM
    assert bench.device.world.motors[0] - before == pytest.approx(
        bench.board.drive.counts[0] + RAMP, abs=1.5
    )
    assert bench.say("G1X5F100") == ["error:9"]
    assert bench.say("$J=X5F100") == ["error:8"]
    assert bench.say("$X") == ["[MSG:Caution: Unlocked]", "ok"]
    assert bench.ask().state is State.IDLE
    bench.say("G1X-100F1500", 1.0)
    bench.put(HOLD + RESET)  # while it brakes
    assert bench.wait(0.4) == ["ALARM:3"]


def test_an_alarm_in_motion_switches_the_motors_off_until_the_board_has_started():
    bench = Bench()
    bench.say("G1X100F1500", 1.0)
    bench.say(RESET, 0.4)
    assert not bench.device.world.energised
    bench.wait(0.6)
    assert bench.device.world.energised
    shoulder = bench.device.world.joints["shoulder"]
    assert shoulder < Bench().device.world.joints["shoulder"]  # it has sagged


@every_row(
    "firmware, off",
    [
        ("grbl", (0.255, 0.755)),
        ("mega5x", (0.255, 0.755)),
        ("fluidnc", None),
        ("grblhal", None),
    ],
)
def test_when_a_reset_in_motion_takes_the_current_away_is_that_of_the_firmware(firmware, off):
    bench = Bench({**MACHINE, 1: 255}, firmware=firmware)
    bench.say("G1X100F1500", 1.0)
    bench.put(RESET)
    began_s, seen = bench.now_s, []
    for _ in range(200):
        bench.wait(0.005)
        if not bench.device.world.energised:
            seen.append(bench.now_s - began_s)
    assert bench.heard.count("ALARM:3") == 1
    assert bench.device.world.energised
    if off is None:
        assert not seen
    else:
        assert (seen[0], seen[-1]) == pytest.approx(off, abs=0.015)


def test_fluidnc_drives_what_it_has_computed_after_a_reset_and_counts_it():
    bench = Bench(firmware="fluidnc")
    before = bench.device.world.motors[0]
    bench.say("G1X100F1500", 1.0)  # 250 steps a second
    here = bench.board.drive.counts[0]
    assert bench.say(RESET, 0.4)[-1] == "ALARM:3"
    bench.wait(1.0)
    assert bench.board.drive.counts[0] - here == pytest.approx(0.11 * 250, abs=4)
    assert bench.device.world.motors[0] - before == pytest.approx(
        bench.board.drive.counts[0] + RAMP, abs=1.5
    )
    assert bench.ask().state is State.ALARM


def test_fluidnc_carries_out_one_line_that_it_read_in_a_hold():
    bench = Bench(firmware="fluidnc")
    bench.say(HOLD)
    bench.put("G91G1X5F3000\n" * 3)
    bench.wait(0.2)
    bench.say(RESET, 2.0)
    assert bench.heard[-1] == "ok"
    assert bench.x == 5.0
    bench.say(HOLD)
    bench.put("G91G1X5F3000\n" * 3)
    bench.wait(0.2)
    assert bench.say(RESET + HOLD, 1.0)[-1] == "ok"
    assert bench.ask().state is State.HOLD
    bench.say(RESET, 1.0)
    assert (bench.ask().state, bench.x) == (State.IDLE, 5.0)


FLUIDNC_SAID = (
    (f"G1X{'1' * 299}", ["error:14"]),
    ("XX", ["error:2"]),
    ("))GG", ["error:2"]),
    ("$foo", ["error:3"]),
    ("$HX", ["error:19"]),
    ("$C", ["Enabled", "ok"]),
    ("$C", ["Disabled", "Grbl 4.0 [FluidNC"]),
    ("M3S500", ["ok"]),
    ("M5", ["ok"]),
    ("?", ["FS:0,500"]),
    ("S200", ["ok"]),
    ("?", ["FS:0,500"]),
    ("M30", ["Program End", "ok"]),
    ("$SLP", ["ok", "Sleeping"]),
    ("\x18", ["ALARM:3", "Grbl 4.0 [FluidNC"]),
    (f"G1X{'1' * 299}", ["error:9"]),
    ("$X", ["Caution: Unlocked", "ok"]),
    ("$X", ["ok"]),
    ("G4P3", []),
    ("\x18", ["Grbl 4.0 [FluidNC"]),  # no ok for the line that it ended
)
"""Lines to FluidNC 4.0.5 and parts of its answers, as its native build gave them, but for those in
words around its errors and alarms."""


def test_fluidnc_answers_as_observed():
    bench = Bench(firmware="fluidnc")
    for line, parts in FLUIDNC_SAID:
        said = bench.say(line, 0.7)
        assert len(said) == len(parts), (line, said)
        for heard, part in zip(said, parts, strict=True):
            assert part in heard, line


@pytest.mark.parametrize(("goes", "after"), [(True, State.RUN), (False, State.IDLE)])
def test_fluidnc_without_homing_comes_out_of_a_limit_alarm_unlocked_or_hung(goes, after):
    bench = with_switches_ahead(Bench({**MACHINE, 21: 1}, firmware="fluidnc"))
    if goes:
        bench.say("G91G1X50F3000", 0.3)
    bench.board.set_switch(0, SwitchState.CLOSED)
    assert "ALARM:1" in bench.wait(1.0)
    bench.board.set_switch(0, SwitchState.FREE)
    bench.say(RESET, 1.0)
    assert bench.ask().state is after
    if goes:
        assert bench.say("G4P0", 1.0) == []
        bench.say(HOLD)
        assert (bench.ask().state, bench.reports[-1].sub_state) == (State.HOLD, 1)
        assert "ALARM:3" in bench.say(RESET, 1.0)
        bench.say("$X")
        assert bench.ask().state is State.IDLE


def test_fluidnc_echoes_lines_once_it_has_heard_a_control_character():
    bench = Bench(firmware="fluidnc")
    assert bench.say("\x0b$G")[0].startswith("$G\n[GC:")
    assert bench.say("\x0c$G")[0].startswith("[GC:")


def test_a_reset_clears_what_was_queued_and_read():
    bench = Bench()
    bench.say(HOLD)
    bench.put("G1X5F3000\n" * 5)
    bench.wait(0.2)
    bench.say(RESET, 0.5)
    bench.say("", 1.0)
    assert bench.heard[-1] == "ok"
    assert (bench.x, bench.heard.count("ok")) == (0.0, 1)


def test_a_line_at_work_is_answered_with_ok_by_the_reset_that_ends_it():
    bench = Bench()
    bench.say("G4P5")
    bench.say(RESET, 0.2)
    assert bench.heard[-2:] == ["ok", "Grbl 1.1q ['$' for help]"]


def test_a_reset_board_reports_zero_whatever_the_truth_and_the_arm_has_sagged():
    bench = Bench()
    assert isinstance(bench.device.board, Resettable)
    bench.say("G1X50F3000", 3.0)
    before = bench.device.world.motors
    bench.device.board.reset()
    assert bench.wait(0.5) == []  # its loader waits, the motors have no current
    assert not bench.device.world.energised
    bench.wait(2.0)
    assert len(bench.banners) == 2
    assert bench.ask().machine_position == (0.0,) * 6
    assert bench.ask().state is State.IDLE
    assert bench.device.world.energised
    assert bench.device.world.motors[1] != before[1]


def test_with_homing_on_a_board_starts_locked():
    bench = Bench(SOFT)
    bench.device.board.reset()
    bench.wait(2.0)
    assert bench.heard[-1] == "[MSG:'$H'|'$X' to unlock]"
    assert bench.ask().state is State.ALARM
    assert Bench(homing=True).ask().state is State.ALARM


@pytest.mark.parametrize(
    ("firmware", "locks"), [("mega5x", True), ("grbl", True), ("grblhal", False)]
)
def test_a_board_with_hard_limits_starts_locked_while_a_switch_is_pressed(firmware, locks):
    """Observed on the Mega, also on the build that otherwise ignores its switches."""
    bench = with_switches_ahead(Bench(firmware=firmware), 0.0)
    bench.say(RESET, 0.2)
    assert bench.ask().state is State.IDLE
    bench.say("$21=1")
    said = bench.say(RESET, 0.2)
    assert ("[MSG:Check Limits]" in said, bench.ask().state is State.ALARM) == (locks, locks)
    bench.say("$X")
    assert bench.ask().state is State.IDLE


def test_homing_an_axis_that_the_build_refuses_leaves_the_board_in_home_until_a_reset():
    bench = Bench(SOFT, firmware="grbl")
    assert bench.say("$HX") == ["error:3"]
    assert bench.ask().state is State.HOME
    assert bench.say("$I") == ["error:8"]
    assert bench.say("$X") == ["ok"]
    assert bench.say(RESET, 1.0)[0] == "ALARM:6"
    assert bench.ask().state is State.ALARM
    bench.say("$X")
    assert bench.ask().state is State.IDLE
    bench.say("$22=0")
    assert bench.say("$HX") == ["error:5"]
    assert bench.ask().state is State.IDLE


def test_a_safety_door_holds_until_it_is_resumed():
    bench = Bench()
    bench.say("G1X10F600", 0.5)
    bench.say(DOOR, 0.5)
    assert bench.ask().state is State.DOOR
    bench.say(RESUME)
    bench.finish()
    assert bench.x == 10.0


def test_control_pins_do_what_their_commands_do():
    bench = Bench()
    bench.say("G1X10F600", 0.5)
    bench.device.set_input(2, True)
    bench.wait(0.5)
    assert bench.ask().state is State.HOLD
    assert bench.reports[-1].pins == "H"
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
    assert bench.ask().state is State.ALARM
    assert bench.reports[-1].pins == "X"
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
    assert isinstance(bench.device.board, HasSwitches)
    act(bench.device)
    assert bench.wait(0.1) == ["ALARM:1", "[MSG:Reset to continue]"]
    assert bench.ask().state is State.ALARM  # the newer firmware goes on reporting
    with pytest.raises(BadRequest, match="0 to 5"):
        bench.device.board.set_switch(6, SwitchState.OPEN)


@pytest.mark.parametrize(("firmware", "line"), [("mega5x", "$21=1"), ("grbl", "$21=0")])
def test_without_hard_limits_a_switch_only_shows(firmware, line):
    """The usual build of six axes accepts $21=1 and does nothing."""
    bench = with_switches_ahead(Bench(firmware=firmware), 10.0)
    assert bench.say(line) == ["ok"]
    bench.say("G1X12F1500", 2.0)
    bench.device.board.set_switch(2, SwitchState.CLOSED)
    bench.wait(0.1)
    assert (bench.ask().state, bench.reports[-1].pins) == (State.IDLE, "XZ")


@pytest.mark.parametrize(("firmware", "reports"), [("grbl", False), ("mega5x", True)])
def test_a_target_outside_the_travel_is_refused_of_a_jog_and_an_alarm_of_a_move(firmware, reports):
    """Observed: the Mega goes on reporting in the alarm, GRBL 1.1 does not."""
    bench = Bench(SOFT, firmware=firmware)
    bench.say("$X")
    bench.say("$J=X-10F3000", 2.0)
    assert bench.x == -10.0
    assert bench.say("$J=X1F3000") == ["error:15"]
    assert bench.say("$J=X-201F3000") == ["error:15"]
    assert bench.say("G1X1F3000", 1.0) == ["ALARM:2", "[MSG:Reset to continue]"]
    assert (bench.ask() is not None) == reports
    bench.say(RESET, 0.5)
    bench.say("$X")
    assert (bench.ask().machine_position[0], bench.ask().state) == (-10.0, State.IDLE)


def test_a_move_under_way_brakes_before_a_soft_limit_alarm_and_keeps_its_place():
    bench = Bench(SOFT)
    bench.say("$X")
    bench.say("G1X-100F1500", 1.0)
    bench.say("G1X5", 1.0)
    assert bench.heard[-2:] == ["ALARM:2", "[MSG:Reset to continue]"]
    assert bench.x == pytest.approx(-27.0, abs=1.0)
    assert bench.device.world.motors[0] == bench.board.drive.counts[0]


# -- Files -----------------------------------------------------------------------------------------

HUGE = 1.7e308


def board(**table):
    """Build the board of an arm file."""
    table = {"model": "teachmover", "connection": {"dialect": "grbl"}, **table}
    return simulate(parse_arm(table, name="bench")).device


@every_row(
    "table, named",
    [
        ({"grbl": {"accelerations": [500.0]}}, "grbl.accelerations must have 6 entries"),
        ({"grbl": {"rates": [500.0] * 5}}, "grbl.rates must have 6 entries"),
        ({"grbl": {"travel": [500.0] * 7}}, "grbl.travel must have 6 entries"),
        (
            {"grbl": {"gripper_output": 6}, "gripper": {"kind": "output"}},
            "grbl.gripper_output is bit 6",
        ),
        ({"limits_deg": {"base": [-HUGE, 90.0]}}, "limits_deg.base"),
        (
            {"homing": {"joints_deg": dict.fromkeys(JOINT_NAMES, HUGE)}},
            "homing.joints_deg.base",
        ),
        (
            {"speeds_deg_s": {"base": 3600.0}, "steps_per_turn": {"base": 1e7}},
            "a greatest rate",
        ),
        ({"grbl": {"unit": "degrees"}, "steps_per_turn": {"base": 0.1}}, "grbl.unit: motor 1"),
    ],
)
def test_impossible_settings_are_refused_by_the_name_of_their_key(table, named):
    with pytest.raises(ArmFileError, match=named):
        board(**table)


def lists(low, high):
    return st.lists(st.floats(low, high), max_size=7)


SECTIONS = st.fixed_dictionaries(
    {},
    optional={
        "grbl": st.fixed_dictionaries(
            {},
            optional={
                "rates": lists(0.1, 1e6),
                "accelerations": lists(0.1, 1e8),
                "travel": lists(0.1, 1e6),
                "axes": st.permutations("XYZABC").map("".join),
                "unit": st.sampled_from(["steps", "degrees"]),
                "ramp_s": st.floats(0.005, 10.0),
                "junction_steps": st.floats(0.001, 1000.0),
                "outputs": st.lists(st.sampled_from(["flood", "mist", "P0", "P99"]), max_size=3),
                "gripper_output": st.integers(0, 7),
            },
        ),
        "gripper": st.fixed_dictionaries({"kind": st.sampled_from(["servo", "output", "none"])}),
        "speeds_deg_s": st.dictionaries(st.sampled_from(JOINT_NAMES), st.floats(0.01, 3600.0)),
        "steps_per_turn": st.dictionaries(
            st.sampled_from(JOINT_NAMES[:3]), st.floats(0.1, 1e7), max_size=2
        ),
        "limits_deg": st.dictionaries(
            st.sampled_from(JOINT_NAMES), st.tuples(st.floats(-HUGE, 0), st.floats(1, HUGE))
        ).map(lambda limits: {joint: list(ends) for joint, ends in limits.items()}),
    },
)


@given(SECTIONS)
def test_any_arm_file_gives_a_board_or_a_sentence(table):
    with contextlib.suppress(ArmError, KinematicsError):
        board(**table).to_json()
