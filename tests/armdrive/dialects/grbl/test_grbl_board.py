"""A driven GRBL board apart from motion: contact, alarms, resets, settings, homing, outputs."""

import functools
import itertools
import math
import re
from dataclasses import replace

import pytest
from amounts import amount, in_pairs
from faults import OVER_THE_TABLE, Rule, becoming, garbled, instead, lost
from grbl_arm import (
    BEGINNINGS,
    FIRMWARES,
    HOME_SINGLE_AXES,
    Disturbed,
    begin_line,
    begin_planned,
    config,
    found,
    over,
    ready,
    standing_as_said,
    stands,
    tip_mm,
)

from armdrive import Jog
from armdrive.arm import Arm
from armdrive.blocking import run_blocking
from armdrive.config.sections import HomingSettings
from armdrive.connect.parts import assemble, connect_simulated
from armdrive.dialects.grbl.contact import MODES
from armdrive.errors import DeviceFault, PendantStop, Refused, SettingsDiffer
from armdrive.motion.device import compare_settings
from armdrive.motion.reference import home_device
from armdrive.registry import simulate
from armdrive.runtime.arm_state import alerted
from armdrive.runtime.clock import SimulatedPace
from armdrive.sim.grbl.firmware import AlarmNumber
from armdrive.sim.mechanics.motors import SwitchState
from armdrive.status import State, Trust
from armdrive.tasks import Alert, AlertKind
from firmware_protocol.grbl import State as BoardMode
from firmware_protocol.grbl.answers import Ok
from kinematics import Joints

HOLD_PIN = 2
HOMED = Joints.of(60.0, 20.0, -90.0, -20.0, 0.0)


def homing_config(groups=()):
    homing = HomingSettings(HOMED, 60.0, groups)
    return replace(config(device={"homing": True}), homing=homing)


def with_device(made, **device):
    return replace(made, device=replace(made.device, **device))


def compare(arm):
    """Read the board's settings, and compare them with the arm file."""
    run_blocking(arm.parts.runner.perform(compare_settings(arm.parts.context)))


def run_into_a_switch(arm):
    """End a motion of the base by a limit switch, which stays pressed."""
    handle = arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.6)
    arm.twin.board.set_switch(0, SwitchState.CLOSED)
    with pytest.raises(DeviceFault, match="alarm 1"):
        handle.wait(8.0)


def test_a_board_that_starts_locked_because_a_switch_is_pressed_says_which():
    made = config(device={"hard_limits": True})
    twin = simulate(made, firmware="mega5x")
    twin.board.set_switch(1, SwitchState.CLOSED)
    arm = Arm(connect_simulated(made, twin=twin))
    locked = r"locked.*limit switch is pressed \(Y\).*`reset\(\)`"
    assert re.search(locked, arm.status.notice)
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    with pytest.raises(DeviceFault, match=locked):
        arm.move_j(base_deg=3)
    arm.reset()
    assert not arm.status.notice
    arm.move_j(base_deg=3)
    assert arm.status.joints.deg["base"] == pytest.approx(3, abs=0.1)


@pytest.mark.parametrize("leave", [Arm.home, Arm.reset])
@pytest.mark.parametrize("firmware", ["mega5x", "fluidnc"])
def test_a_board_that_starts_locked_is_in_standby_with_a_notice_until_it_is_homed_or_reset(
    firmware, leave
):
    arm = found(homing_config(), firmware=firmware)
    assert (arm.status.state, arm.status.notice_code) == (State.STANDBY, "E506")
    assert "until it has homed" in arm.status.notice
    arm.enable()
    assert arm.status.notice_code == "E506"
    leave(arm)
    assert (arm.status.state, arm.status.notice) == (State.STANDBY, "")
    arm.move_motors(1, 0, 0, 0, 0, 0)


def test_a_locked_board_whose_settings_differ_is_said_to_be_both_until_each_is_mended():
    made = homing_config()
    twin = simulate(made, firmware="mega5x")
    twin.board.settings.values[1] = 25.0
    arm = Arm(connect_simulated(made, twin=twin))
    both = r"locked.*`reset\(\)`.*\[E206\] \$1 .* is 25"
    for look_again in (lambda: None, arm.enable):
        look_again()
        assert re.search(both, arm.status.notice)
        assert arm.status.notice_code == "E506"
    arm.controller.fix_settings(["$1=255"])
    assert "locked" in arm.status.notice
    assert "E206" not in arm.status.notice
    twin.board.settings.values[1] = 25.0
    arm.enable()
    compare(arm)
    arm.reset()
    assert arm.status.notice_code == "E206"
    assert "locked" not in arm.status.notice
    with pytest.raises(SettingsDiffer):
        arm.move_motors(1, 0, 0, 0, 0, 0)


@pytest.mark.parametrize("code", [1, 2])
def test_an_alarm_while_connecting_latches_no_error_but_is_said(code):
    """After ALARM:2 the board vouches for its position, after ALARM:1 it does not."""
    made = config()
    twin = simulate(made, firmware="mega5x")
    link = Disturbed(twin.link)
    link.back.append(Rule(rb"\$0=", instead(b"ALARM:%d\r\n" % code)))
    arm = Arm(connect_simulated(made, twin=replace(twin, link=link)))
    assert (arm.status.state, arm.status.error) == (State.STANDBY, "")
    assert f"the board is in alarm {code}" in arm.status.notice
    assert arm.status.notice_code


def test_a_board_that_was_asleep_when_its_link_came_back_is_unlocked_as_the_arm_is_enabled():
    arm = ready(firmware="mega5x")
    arm.disable()
    locked = Alert(AlertKind.LOCKED, "the board is locked by an alarm")
    alerted(arm.parts.core, locked, arm.status.time_s)
    assert (arm.status.state, arm.status.notice_code) == (State.DISABLED, "E506")
    arm.enable()
    assert (arm.status.state, arm.status.notice) == (State.STANDBY, "")


def test_a_limit_alarm_mutes_the_board_which_is_no_broken_wire():
    arm = ready(config(device={"hard_limits": True}), firmware="grbl")
    run_into_a_switch(arm)
    assert arm.status.state is State.ERROR_STOP
    assert "even if the cable is fine" in arm.status.error
    assert arm.status.trust is Trust.SUSPECT
    arm.twin.board.set_switch(0, SwitchState.FREE)
    arm.reset()
    assert arm.status.state is State.STANDBY


def test_a_fluidnc_board_with_homing_raises_another_alarm_as_it_is_reset_after_a_limit_alarm():
    arm = found(config(device={"hard_limits": True, "homing": True}), firmware="fluidnc")
    arm.reset()  # it boots locked
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    run_into_a_switch(arm)
    arm.twin.board.set_switch(0, SwitchState.FREE)
    arm.reset()
    arm.sleep(1.0)
    assert arm.status.state is State.STANDBY
    assert arm.status.trust is Trust.SUSPECT


def test_a_fluidnc_board_without_homing_reports_a_motion_after_a_limit_alarm_until_it_is_reset():
    arm = ready(config(device={"hard_limits": True}), firmware="fluidnc")
    run_into_a_switch(arm)
    arm.twin.board.set_switch(0, SwitchState.FREE)
    motors = arm.twin.world.motors
    arm.reset()
    assert [each for each in arm.twin.link.messages if each == b"\x18"] == [b"\x18"] * 2
    assert arm.twin.world.motors == motors
    assert arm.status.state is State.STANDBY
    assert arm.status.trust is Trust.SUSPECT


@in_pairs("firmware, later_s", FIRMWARES, [0.001, 0.003, 0.005, 0.007, 0.009])
def test_a_late_feed_hold_does_not_keep_the_arm_in_its_error(firmware, later_s):
    arm = ready(firmware=firmware)
    arm.estop()
    arm.sleep(2.0)
    arm.twin.device.set_input(HOLD_PIN, on=True)
    assert arm.twin.board.state == "Hold"
    resets = 2 if firmware == "fluidnc" else 1  # the last one is followed by the hold
    late = Rule(rb"\x18", lambda message: [(0.0, message), (later_s, b"!")], skip=resets - 1)
    arm.twin.link.to.append(late)
    arm.reset()
    assert not late.times
    assert arm.status.state is State.STANDBY


def test_a_limit_alarm_of_an_arm_that_stands_makes_its_position_suspect():
    arm = ready(config(device={"hard_limits": True}), firmware="grbl")
    arm.twin.board.set_switch(0, SwitchState.CLOSED)
    arm.sleep(2.0)
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.trust is Trust.SUSPECT


def test_a_pressed_feed_hold_stops_the_arm_and_keeps_its_position():
    arm = ready()
    handle = arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.6)
    arm.twin.device.set_input(HOLD_PIN, on=True)
    with pytest.raises(PendantStop):
        handle.wait(5.0)
    arm.twin.device.set_input(HOLD_PIN, on=False)
    assert arm.status.trust is Trust.REFERENCED
    assert standing_as_said(arm)
    arm.reset()
    arm.move_j(base_deg=0)
    assert standing_as_said(arm)


def test_a_board_from_the_factory_moves_nothing_until_it_is_mended():
    arm = found(factory=True)
    musts = [each for each in arm.parts.core.differences if each.must]
    assert {each.fix for each in musts} >= {"$1=255", "$10=3", "$100=1", "$105=1"}
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    with pytest.raises(SettingsDiffer, match=r"\$1=255"):
        arm.move_j(base_deg=3)
    from armdrive.motion.device import fix_settings

    lines = tuple(each.fix for each in arm.parts.core.differences)
    run_blocking(arm.parts.runner.perform(fix_settings(arm.parts.context, lines)))
    assert arm.parts.core.differences == ()
    arm.move_j(base_deg=3)
    assert standing_as_said(arm)


@pytest.mark.parametrize(("number", "what"), [(110, "highest rate"), (121, "acceleration")])
def test_an_axis_that_its_settings_keep_from_ever_arriving_moves_nothing(number, what):
    """grbl-Mega-5X and grblHAL accept the zero, and a motion of that axis never ends."""
    made = homing_config()
    twin = simulate(made, firmware="mega5x")
    wanted, twin.board.settings.values[number] = twin.board.settings.values[number], 0.0
    arm = Arm(connect_simulated(made, twin=twin))
    arm.reset()  # it boots locked
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    motors = twin.world.motors
    refusal = rf"the {what} of .*: a motion would never end\) is 0, expected .*`\${number}="
    for move in (lambda: arm.move_j(base_deg=3), arm.home, lambda: arm.jog_j(base_deg=3)):
        with pytest.raises(SettingsDiffer, match=refusal):
            move()
    assert twin.world.motors == motors
    arm.controller.fix_settings([f"${number}={wanted}"])
    arm.move_j(base_deg=3)


@pytest.mark.parametrize("jog", ["hold", "nudge"])
def test_a_jog_that_wrong_settings_forbid_says_so_at_every_press(jog):
    arm = found(factory=True)
    motors = arm.twin.world.motors
    for _ in range(2):
        notices = arm.status.notices
        if jog == "hold":
            arm.jogging.hold(Jog.joint(base=1.0), speed=0.1, for_s=0.2)
        else:
            arm.jogging.nudge(Jog.joint(base=0.02), speed=0.1)
        arm.sleep(1.0)
        assert arm.status.notices > notices
        assert arm.status.notice_code == "E206"
        assert "the arm does not move while" in arm.status.notice
    assert arm.twin.world.motors == motors


@pytest.mark.parametrize(
    ("firmware", "named"),
    [
        ("mega5x", "Grbl 1.1q.20210103"),
        ("grblhal", "GrblHAL 1.1f.20260817"),
        ("fluidnc", "4.0 FluidNC v4.0.5-pre2 (esp32-wifi)"),
    ],
)
def test_the_settings_of_a_board_that_was_already_running_name_its_firmware(firmware, named):
    assert found(firmware=firmware).controller.fix_settings([]).firmware == named


def test_a_fluidnc_board_from_the_factory_is_mended_by_paths():
    arm = found(factory=True, firmware="fluidnc")
    lines = [each.fix for each in arm.parts.core.differences]
    assert "$/stepping/idle_ms=255" in lines
    assert "$10=3" in lines
    assert "$/axes/x/steps_per_mm=1" in lines
    assert "$/junction_deviation_mm=1" in lines
    arm.controller.fix_settings()
    assert arm.parts.core.differences == ()
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    arm.move_j(base_deg=3)
    assert standing_as_said(arm)


def test_settings_only_in_fluidncs_file_are_reported_and_not_sent():
    arm = found(config(device={"hard_limits": True}), factory=True, firmware="fluidnc")
    arm.controller.fix_settings()
    (left_over,) = arm.parts.core.differences
    assert str(left_over).startswith("$21 (hard limits, in the board's configuration file) is 0")
    assert left_over.fix == ""


@pytest.mark.parametrize(
    "line",
    [
        "$J=G91X9F99",
        "$H",
        "$/axes/x/motor0=",
        "$/a=G1X9",
        "$N0=G0X9",
        "$RST=*",
        "$X",
        "$100",
        "G0X9",
    ],
)
def test_a_line_that_writes_no_setting_is_not_sent(line):
    arm = ready()
    sent, motors = len(arm.twin.link.sent), arm.twin.world.motors
    with pytest.raises(Refused, match="is not a GRBL setting"):
        arm.controller.fix_settings([line])
    arm.sleep(1.0)
    assert not [piece for _, piece in arm.twin.link.sent[sent:] if line.encode() in piece]
    assert arm.twin.world.motors == motors


ONE_BY_ONE = ((3,), (2,), (1,), (4, 5))
"""All motors but the last: FluidNC would stay locked, because axis C is not homed."""


@in_pairs("firmware, groups", HOME_SINGLE_AXES, [ONE_BY_ONE, ()])
def test_homing_ends_where_the_arm_file_says(firmware, groups):
    arm = found(homing_config(groups), firmware=firmware)
    arm.home()
    assert arm.status.trust is Trust.REFERENCED
    if not groups:
        assert arm.twin.world.motors == arm.status.acknowledged
    homed = [piece for _, piece in arm.twin.link.sent if piece.startswith(b"$H")]
    one_by_one = "ZYXAB" if groups else "".join(arm.config.device.axes[:6])
    assert homed == [f"$H{letter}\n".encode() for letter in one_by_one]
    arm.move_j(base_deg=50)
    assert arm.status.joints.deg["base"] == pytest.approx(50, abs=0.1)


@pytest.mark.parametrize("firmware", HOME_SINGLE_AXES[: amount(1, 3)])
def test_a_search_that_finds_no_switch_ends_within_the_time_that_the_boards_settings_give(firmware):
    made = with_device(homing_config(), homing_s=290.0)
    arm = found(made, firmware=firmware)
    controller = arm.parts.core.controller
    announced_s = controller.search(made.homing.requests()[0]).time_s
    assert announced_s != made.device.homing_s  # what is assumed of a board that says nothing
    arm.twin.board.set_switch(0, SwitchState.OPEN)
    began_s = arm.status.time_s
    with pytest.raises(DeviceFault, match="did not find the switch"):
        arm.home()
    assert 50.0 < arm.status.time_s - began_s <= announced_s


def test_homing_that_takes_too_long_names_the_key_that_allows_more():
    arm = found(with_device(homing_config(), homing_s=5.0))
    arm.parts.core.controller.searches_s = (None,) * 6  # the board does not report its speeds
    with pytest.raises(DeviceFault, match=r"not ended after 11 s.* raise grbl.homing_s in the arm"):
        arm.home()
    assert not arm.twin.device.moving


@pytest.mark.parametrize(
    ("firmware", "least_s"), [("mega5x", 30.0), ("grblhal", 200.0), ("fluidnc", 30.0)]
)
def test_a_board_that_homes_slowly_has_the_time_that_its_settings_give(firmware, least_s):
    made = with_device(homing_config(((1,),)), homing_s=1.0)
    twin = simulate(made, firmware=firmware)
    twin.board.settings.values[25] = 5.0 * 60.0  # steps a minute
    arm = Arm(connect_simulated(made, twin=twin))
    began_s = arm.status.time_s
    arm.home()
    assert arm.status.time_s - began_s > least_s
    assert arm.status.trust is Trust.REFERENCED


def test_a_board_that_never_answers_the_homing_command_is_reset_after_the_time_that_it_needs():
    arm = found(homing_config(ONE_BY_ONE))
    arm.twin.link.back.append(Rule(rb"ok", lost, times=9))
    search = arm.parts.core.controller.search(arm.config.homing.requests()[0])
    began_s = arm.status.time_s
    with pytest.raises(DeviceFault, match="not ended after") as caught:
        arm.home()
    assert arm.status.time_s - began_s <= search.lasts.waited_s + 3.0
    assert "homing_s" not in str(caught.value)


def test_a_homing_command_that_was_changed_on_the_wire_references_nothing():
    """Mission grbl 710001090: the board answered what had become a comment with ok."""
    arm = found(homing_config(ONE_BY_ONE))
    arm.twin.link.to.append(Rule(rb"\$HY", becoming(lambda line: line.replace(b"$", b"("))))
    with pytest.raises(DeviceFault, match=r"`.HY` at once, so it has not homed"):
        arm.home()
    assert arm.status.trust is not Trust.REFERENCED


def homing_with_a_changed_line(firmware, letter, other):
    arm = found(homing_config(), firmware=firmware)
    line = Rule(b"[$]H" + letter, becoming(lambda line: line.replace(letter, other)))
    arm.twin.link.to.append(line)
    return arm


@pytest.mark.parametrize(
    ("firmware", "letter", "other"),
    [(each, b"X", b"Y") for each in HOME_SINGLE_AXES] + [("fluidnc", b"Y", b"X")],
)
def test_a_homing_command_that_turns_another_motor_references_nothing(firmware, letter, other):
    arm = homing_with_a_changed_line(firmware, letter, other)
    with pytest.raises(DeviceFault, match="changed on the wire, because another motor has turned"):
        arm.home()
    assert not arm.twin.device.moving
    assert arm.status.trust is not Trust.REFERENCED


@pytest.mark.parametrize("firmware", ["mega5x", "grblhal"])
@pytest.mark.parametrize("letter", [b"Y", b"Z"])
def test_a_homing_command_that_homes_a_homed_motor_once_more_is_repeated(firmware, letter):
    """These boards do not report while they home, and the count of that motor is as before."""
    arm = homing_with_a_changed_line(firmware, letter, b"X")
    arm.home()
    assert arm.twin.world.motors == arm.status.acknowledged


@pytest.mark.parametrize("firmware", HOME_SINGLE_AXES[amount(2, 0) :])
def test_a_damaged_report_is_no_motor_that_turns_while_another_one_homes(firmware):
    arm = found(homing_config(), firmware=firmware)
    arm.reset()
    report = rb"(<(?:Idle|Home|Alarm)\|MPos:[^,]+,[^,]+,[^,]+,[^,]+,)[^,]+"
    damage = becoming(lambda line: re.sub(report, rb"\g<1>7.000", line))
    rules = [Rule(report, damage, skip=skip) for skip in (0, 3, 9, 17, 30)]
    arm.twin.link.back += rules
    arm.home()
    assert arm.twin.world.motors == arm.status.acknowledged
    assert not rules[0].times


def test_homing_an_arm_that_stands_at_its_switches_leaves_it_there():
    arm = found(homing_config(), firmware="mega5x")
    arm.home()
    motors = arm.twin.world.motors
    arm.home()
    assert arm.twin.world.motors == motors == arm.status.acknowledged


@pytest.mark.parametrize("state", ["Sleep", "Check"])
def test_a_board_that_executes_no_lines_does_not_home(state):
    arm = found(homing_config(), firmware="mega5x")
    arm.reset()  # it boots locked
    arm.twin.board.state = BoardMode(state)
    began_s = arm.status.time_s
    with pytest.raises(DeviceFault, match=rf"the board's state is {state}; `reset\(\)` leaves it"):
        arm.home()
    assert arm.status.time_s - began_s < 1.0


def test_a_board_that_reports_while_it_homes_is_lost_soon_once_it_is_silent():
    arm = found(homing_config(), firmware="fluidnc")
    arm.twin.link.back.append(Rule(rb".", lost, skip=50, times=math.inf))
    began_s = arm.status.time_s
    with pytest.raises(DeviceFault, match="not ended after"):
        arm.home()
    assert arm.status.time_s - began_s < 16.0
    assert not arm.twin.device.moving


@pytest.mark.parametrize("firmware", HOME_SINGLE_AXES[amount(2, 0) :])
def test_after_homing_that_failed_the_next_motion_begins_where_the_arm_stands(firmware):
    """Mission grbl 710001233: FluidNC drove on from where its search was to end."""
    arm = found(homing_config(), firmware=firmware)
    arm.twin.board.set_switch(0, SwitchState.OPEN)
    with pytest.raises(DeviceFault, match="did not find the switch"):
        arm.home()
    arm.twin.board.set_switch(0, SwitchState.FREE)
    arm.reset()
    arm.twin.world.drive_to(arm.twin.world.body.transmission.to_motors(OVER_THE_TABLE, 20.0))
    before = arm.twin.world.motors
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    arm.jog_j(base_deg=2.0)
    turned = arm.twin.world.motors - before
    assert abs(turned[0] - 2.0 * abs(arm.parts.core.transmission.matrix[0][0]) * 0.01745) < 2.0
    assert not any(turned[1:])


def test_an_axis_seeks_its_switch_no_faster_than_its_highest_rate():
    arm = found(homing_config(ONE_BY_ONE))
    controller, values = arm.parts.core.controller, arm.twin.board.settings.values
    search = functools.partial(controller.search, arm.config.homing.requests()[0])
    values[25] = values[110] / 2.0
    compare(arm)
    slow_s = search().lasts.s
    values[25], values[110] = 100.0 * values[110], values[110] / 2.0
    compare(arm)
    assert search().lasts.s == pytest.approx(slow_s, rel=0.1)


def test_homing_away_from_a_switch_is_named_beforehand_and_refused():
    arm = found(homing_config())
    assert "differ" not in arm.reference.homing_words
    ways = int(arm.twin.board.settings.values[23])
    arm.twin.board.settings.values[23] = float(ways ^ 1)  # of the base, which homes near an end
    compare(arm)
    assert "$23 (homing directions" in arm.reference.homing_words
    assert f"expected {ways}: send `$23={ways}`." in arm.reference.homing_words
    start = arm.twin.world.motors
    with pytest.raises(SettingsDiffer, match=rf"send `\$23={ways}`.*doctor --fix"):
        arm.home()
    assert arm.twin.world.motors == start
    arm.reset()  # it boots locked
    arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=0.5)
    arm.sleep(1.0)
    assert arm.twin.world.motors != start  # to find out what is right, it may turn its motors
    arm.controller.fix_settings([f"$23={ways}"])
    arm.home()
    assert arm.status.trust is Trust.REFERENCED


def test_a_board_from_the_factory_homes_once_its_travels_are_long_enough():
    """Its 200 are steps for an arm, and homing gives up after 300."""
    arm = found(homing_config(), factory=True)
    fixes = [each.fix for each in arm.parts.core.differences]
    spans = [math.ceil(span) for span in arm.parts.core.controller.axes.spans]
    found_travels = [fix for fix in fixes if fix.startswith("$13")]
    assert found_travels == [f"$13{axis}={span}" for axis, span in enumerate(spans)]
    arm.controller.fix_settings(fixes)
    arm.reset()
    arm.home()
    assert arm.status.trust is Trust.REFERENCED


def test_a_wrong_homing_direction_in_a_configuration_file_is_not_for_doctor_to_fix():
    arm = found(homing_config(), firmware="fluidnc")
    arm.twin.board.settings.values[23] = float(int(arm.twin.board.settings.values[23]) ^ 1)
    compare(arm)
    with pytest.raises(SettingsDiffer, match="in the board's configuration file") as refused:
        arm.home()
    assert "--fix" not in str(refused.value)


def test_an_alarm_right_after_homing_is_not_unlocked(monkeypatch):
    arm = found(homing_config(), firmware="mega5x")
    arm.reset()  # it boots locked
    board = arm.twin.board

    def touched(_answer, say=board.say):
        say(_answer)
        if isinstance(_answer, Ok) and arm.twin.link.sent[-1][1] == b"$HC\n":
            board.routines.critical(board, AlarmNumber.HARD_LIMIT)

    monkeypatch.setattr(board, "say", touched)
    with pytest.raises(DeviceFault):
        arm.home()
    assert board.state.value == "Alarm"
    assert arm.status.state is State.ERROR_STOP


def test_releasing_the_motors_of_a_grblhal_board_that_must_not_sleep_is_refused():
    arm = ready(firmware="grblhal")
    arm.twin.board.settings.values[62] = 0.0
    with pytest.raises(DeviceFault, match=r"`\$SLP`.*error 3"):
        arm.disable()


def test_homing_is_refused_on_a_board_that_cannot_home():
    arm = found(homing_config(((1,),)), firmware="grbl")
    arm.reset()  # it boots locked
    with pytest.raises(DeviceFault, match="not known or not supported"):
        arm.home()
    arm.reset()  # it stays in the state of homing until then
    assert arm.status.state is State.STANDBY


def test_outputs_and_a_servo_come_back_after_a_stop():
    arm = ready(config(gripper="servo", device={"outputs": ("flood",)}))
    arm.gripper.open(76.0)
    arm.io.write(1)
    assert arm.twin.world.opening_mm == pytest.approx(76.0, abs=1.0)
    before = arm.twin.board.details()["outputs"]
    arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.6)
    arm.stop()
    arm.sleep(0.5)
    assert arm.twin.board.details()["outputs"] == before
    with pytest.raises(Refused, match=r"grbl\.outputs"):
        arm.io.write(2)


@pytest.mark.parametrize(
    ("valve", "firmware", "closes"),
    [("flood", "mega5x", True), ("mist", "mega5x", False), ("P0", "grblhal", True)],
)
def test_a_gripper_on_a_valve_opens_and_closes(valve, firmware, closes):
    other = "flood" if valve == "mist" else "mist"
    device = {"outputs": (other, valve), "gripper_output": 1, "gripper_closes": closes}
    arm = ready(config(gripper="output", device=device), firmware=firmware)
    arm.gripper.open(76.0)
    assert arm.twin.world.opening_mm == pytest.approx(76.0, abs=1.0)
    arm.gripper.close(0.0)
    assert arm.twin.world.opening_mm == pytest.approx(0.0, abs=1.0)


# -- First contact: the driver learns the board's axes, and nothing moves --------------------------


# The axes of the board.


@in_pairs("firmware, letters", FIRMWARES, ["XYZABC", "XZYBA", "XYZAC"])
def test_a_board_may_have_more_axes_than_the_arm_has_motors(firmware, letters):
    made = config(gripper="servo", device={"axes": letters})
    arm = ready(made, firmware=firmware, axes="XYZABC")
    assert arm.parts.core.differences == ()
    arm.move_motors(5, -4, 3, -2, 1)
    assert arm.twin.world.motors == arm.status.acknowledged == arm.status.read_back


@pytest.mark.parametrize("banner", [True, False])
def test_the_axes_are_known_whether_the_board_restarts_or_not(banner):
    arm = found(config(gripper="servo"), firmware="fluidnc", axes="XYZABC")
    if banner:
        arm.twin.board.reset()
        arm.sleep(3.0)
        arm.reset()
    assert arm.status.state is State.STANDBY
    assert len(arm.status.read_back) == 5


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_a_board_with_too_few_axes_is_described(firmware):
    twin = simulate(config(gripper="servo", device={"axes": "XYZAB"}), firmware=firmware)
    with pytest.raises(DeviceFault, match=r"the board has 5 axes \(XYZAB\).* on C:"):
        connect_simulated(config(), twin=twin)


# A board that another program has used.

HALF_LINES = ["G1G91X10F300", "G1G91X10F300(a", "G1G91X10F300 (a) Y", "$J=G91X10F300", "$H", "$C"]
IN_A_COMMENT = "G1G91X10F300;a"


def left(made, said, **options):
    """Return an arm whose board another program has used, and the board's counts by then."""
    twin = simulate(made, **options)
    twin.link.read(0.05)
    for number, data in enumerate(said):
        twin.link.write(data.encode("latin-1"), 1.0 + 9.0 * number)
        twin.link.read(9.0 + 9.0 * number)
    before = twin.world.motors, twin.world.opening_mm, twin.device.registers
    pace = SimulatedPace()
    pace.clock.now_s = 9.0 * len(said)
    arm = Arm(assemble(made, twin.link, pace, simulated=True))
    arm.twin = twin
    return arm, before


def now(arm):
    return arm.twin.world.motors, arm.twin.world.opening_mm, arm.twin.device.registers


@pytest.mark.parametrize("half", ["", *HALF_LINES, IN_A_COMMENT])
def test_a_locked_board_stays_locked_until_a_reset_and_forgets_a_half_line(half):
    arm, before = left(config(), ["G1G91X7F600\n", half], homing=True)
    with pytest.raises(DeviceFault, match="reset"):  # the board was locked, and still is
        arm.move_motors(1, 0, 0, 0, 0, 0)
    arm.reset()
    arm.sleep(3.0)
    assert now(arm) == before
    assert before[2][0] == 0
    assert arm.status.state is State.STANDBY
    arm.move_motors(1, 0, 0, 0, 0, 0)


@pytest.mark.parametrize(
    ("firmware", "half"),
    [
        *(("grbl", half) for half in ["", *HALF_LINES, IN_A_COMMENT]),
        *itertools.product(FIRMWARES[1:], ["", "G1G91X10F300(a", "$J=G91X10F300"]),
    ],
)
def test_no_half_line_is_carried_out_and_position_current_and_state_are_kept(firmware, half):
    said = ["$X\n", "G1G91X7F600\n", half]
    check_kept(*left(config(), said, firmware=firmware, homing=True))


def check_kept(arm, before):
    """Check that contact has carried out nothing that was left in the board, and that it moves."""
    arm.sleep(3.0)
    assert now(arm) == before
    assert before[2][0] == 7
    assert arm.status.read_back[0] == 7
    assert arm.status.state is State.STANDBY
    assert arm.twin.world.energised
    arm.move_motors(3, 0, 0, 0, 0, 0)
    assert arm.twin.device.registers[0] == 10


GRIPPERS = [
    ("servo", {}, "M3S1000"),
    ("servo", {"servo": "M67E0"}, "M67E0Q1000"),
    ("output", {"gripper_closes": False}, "M8"),
    ("output", {"gripper_closes": False, "outputs": ("mist",)}, "M7"),
    ("output", {"gripper_closes": False, "outputs": ("P1",)}, "M64P1"),
]


# FluidNC reads one line while it stands in a hold, and a reset carries that line out.


@pytest.mark.parametrize("firmware", FIRMWARES)
@pytest.mark.parametrize("hold", ["!"])
def test_no_line_that_waits_in_a_hold_is_carried_out_when_an_arm_connects(firmware, hold):
    said = ["G1G91X7F600\n", hold, "G1G91X10F300\nG1G91X20F300\n"]
    check_kept(*left(config(), said, firmware=firmware))


@in_pairs("firmware, later_s", FIRMWARES, [0.0, 0.015, 0.03])
def test_a_stop_key_that_is_pressed_as_a_line_arrives_stops_the_arm_for_good(firmware, later_s):
    arm = ready(firmware=firmware)
    begin_line(arm)
    arm.sleep(0.5 + later_s)
    arm.twin.device.set_input(HOLD_PIN, on=True)
    seen = []
    for _ in range(300):
        arm.sleep(0.005)
        seen.append(str(arm.twin.board.state))
    assert "Run" not in seen[seen.index("Hold") :]
    assert standing_as_said(arm)


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_an_echo_that_a_terminal_has_left_on_ends_at_contact(firmware):
    arm, before = left(config(), ["G1G91X7F600\n\x0b\n\x0b"], firmware=firmware)
    arm.sleep(1.0)
    assert now(arm) == before
    assert arm.parts.core.controller.board.recognised
    warnings = arm.parts.core.controller.board.garbled
    arm.move_motors(3, 0, 0, 0, 0, 0)
    assert arm.parts.core.controller.board.garbled == warnings


@in_pairs("gripper, half", GRIPPERS, ["", "G1G91X10F300", "G1G91X10F300(a", "$H"])
def test_contact_does_not_let_go_of_what_a_gripper_on_an_output_holds(gripper, half):
    kind, device, opens = gripper
    said = [opens + "\n", half]
    firmware = "grblhal" if opens.startswith("M6") else "mega5x"
    arm, before = left(config(gripper=kind, device=device), said, firmware=firmware)
    arm.sleep(3.0)
    assert now(arm) == before
    assert before[1] == pytest.approx(76.0, abs=1.0)


TOLD = [each for each in GRIPPERS if each[2].startswith(("M3", "M7", "M8"))]
WITH_COMMENTS = [IN_A_COMMENT, "$J=G91X10F300;a", "M3S700;a", "M8;", "$H;"]


@in_pairs("gripper, half, firmware", TOLD, WITH_COMMENTS, FIRMWARES)
def test_no_partial_line_is_executed_where_a_reset_would_open_the_gripper(gripper, half, firmware):
    kind, device, opens = gripper
    said = [opens + "\n", "M5\nM9\nG1G91X7F600\n", half]
    arm, before = left(config(gripper=kind, device=device), said, firmware=firmware)
    arm.sleep(3.0)
    assert now(arm) == before
    assert before[2][0] == 7
    outputs = arm.twin.board.details()["outputs"]
    assert (outputs["spindle"], outputs["flood"], outputs["mist"]) == ("M5", False, False)


def test_a_single_false_report_of_outputs_releases_nothing():
    made = config(gripper="servo")
    twin = simulate(made)
    twin.link.write(b"M3S1000\n", 0.1)
    twin.link.read(9.0)
    link = Disturbed(twin.link)
    link.back.append(Rule(rb"<.*\|A:S", becoming(lambda line: line.replace(b"|A:S", b"|C:S"))))
    pace = SimulatedPace()
    pace.clock.now_s = 9.0
    Arm(assemble(made, link, pace, simulated=True))
    assert not link.back[0].times
    assert not link.pressed(b"\x18")
    assert twin.board.details()["outputs"]["spindle"] == "M3"


# The delay before the board brakes.


def segments(arm):
    """Return the segments of 10 ms that the board may drive before it starts to brake."""
    return arm.parts.core.controller.board.segment_buffer.segments


@pytest.mark.parametrize(
    ("firmware", "wanted"), [("grbl", 5), ("mega5x", 9), ("grblhal", 9), ("fluidnc", 11)]
)
def test_the_segments_computed_ahead_are_those_of_the_firmware(firmware, wanted):
    assert segments(found(firmware=firmware)) == wanted
    told = found(config(device={"segments": 20}), firmware=firmware)
    assert segments(told) == 20
    assert told.status.stop_time_s > found(firmware=firmware).status.stop_time_s


@pytest.mark.parametrize(("times", "wanted"), [(1, 9), (2, 9), (99, 11)])
def test_a_firmware_that_is_not_read_without_a_flaw_counts_as_the_slowest(times, wanted):
    flaw = Rule(rb"\[FIRMWARE", garbled(4, 0x7F), times=times)
    assert segments(over(flaw, firmware="grblhal")) == wanted


# A damaged answer to `$I`: a line has no checksum.


@pytest.mark.parametrize("letters", [b"XYZABV", b"XYZABQ", b""])
def test_axis_letters_that_were_damaged_are_asked_for_again(letters):
    arm = over(Rule(rb"\[AXS", instead(b"[AXS:6:" + letters + b"]\r\n")), firmware="mega5x")
    assert arm.status.state is State.STANDBY


# -- Resets ----------------------------------------------------------------------------------------


def begin_held_jog(arm):
    arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=3.0)


def lose(arm, what):
    """Lose one byte, or all that the next message says."""
    if what == "message":
        arm.twin.faults.add("drop", "next", side="host")
    else:
        arm.twin.link.to.append(Rule(what, lost))


def stops_as_announced(arm, stop):
    status, tip = arm.status, arm.twin.world.tip
    assert status.state is State.MOVING
    stop()
    assert stands(arm) - status.time_s <= status.stop_time_s
    assert tip_mm(arm, tip) <= status.stop_distance_mm


RESET, HOLD, CANCEL = b"\x18", b"!", b"\x85"
BYTES = [rb"\?", HOLD, RESET, CANCEL]
"""What the board reads between the characters of a line."""
CANCELS = {"mega5x": 1, "grblhal": 2}
"""How often a jog is cancelled as it is released."""
LOST = [
    *itertools.product(BEGINNINGS, [RESET, "message"], ["estop"], FIRMWARES[1:2]),
    *itertools.product([begin_planned], [RESET], ["estop"], FIRMWARES),
    *itertools.product([begin_planned], [*BYTES, "message"], ["request_stop"], FIRMWARES[1:3]),
    *itertools.product([begin_line], [HOLD, "message"], ["request_stop"], FIRMWARES[1:2]),
    *itertools.product([begin_held_jog], [*BYTES, "message"], ["release"], FIRMWARES[1:3]),
]  # fmt: skip


@pytest.mark.parametrize(("begin", "what", "stop", "firmware"), LOST[:: amount(3, 1)])
def test_a_lost_stop_is_repeated_within_the_announced_time(begin, what, stop, firmware):
    arm = ready(firmware=firmware)
    begin(arm)
    arm.sleep(0.5)
    lose(arm, what)
    began_s = arm.status.time_s
    stops_as_announced(arm, arm.jogging.release if stop == "release" else getattr(arm, stop))
    arm.sleep(2.0)
    if stop == "estop":
        resets = [sent_s - began_s for sent_s, piece in arm.twin.link.sent if piece == RESET]
        assert resets[1] <= 0.03
        assert arm.status.state is State.ERROR_STOP
        assert arm.status.trust is Trust.SUSPECT
        arm.reset()
    else:
        assert arm.status.trust is Trust.REFERENCED
        assert standing_as_said(arm)
        assert arm.twin.link.pressed(CANCEL) == CANCELS[firmware] * (stop == "release")
        assert arm.twin.board.details()["state"] == "Idle"
    assert arm.status.state is State.STANDBY


def test_a_stop_that_is_lost_before_the_first_report_of_motion_is_repeated_in_time():
    for later_s in (0.0, 0.01, 0.02, 0.04):
        arm = ready()
        begin_planned(arm)
        while len(arm.twin.link.motions) < 1:
            arm.sleep(0.001)
        arm.sleep(later_s)
        lose(arm, rb"\x18")
        stops_as_announced(arm, arm.estop)


@pytest.mark.parametrize(
    ("begin", "firmware"),
    [*zip(BEGINNINGS, FIRMWARES, strict=True), *((begin_planned, each) for each in FIRMWARES[1:])],
)
def test_a_stop_that_arrives_is_sent_once(begin, firmware):
    arm = ready(firmware=firmware)
    begin(arm)
    for more_s in (0.30, 0.31, 0.32, 0.33):  # with and without a report on its way
        arm.sleep(more_s - 0.3)
    arm.estop()
    arm.sleep(2.5)
    assert arm.twin.link.pressed(b"\x18") == 1
    assert "emergency stop" in arm.status.error


def stop_homing(arm, task):
    status = arm.status
    arm.request_stop()
    assert stands(arm) - status.time_s <= status.stop_time_s
    arm.sleep(3.0)
    assert task.done
    assert arm.status.trust is not Trust.REFERENCED
    assert arm.status.state is State.STANDBY


def homing(firmware, for_s=1.0, **values):
    """Return an arm that has homed for a while on a board with some settings, and the task."""
    made = homing_config()
    arm = found(made, firmware=firmware)
    arm.twin.board.settings.values.update({int(key[1:]): value for key, value in values.items()})
    task = arm.parts.runner.submit(home_device(arm.parts.context, made.homing))
    arm.sleep(for_s)
    return arm, task


@in_pairs("firmware, what", HOME_SINGLE_AXES, [rb"\x18", "nothing", "message"])
def test_homing_that_is_stopped_ends_in_time_although_a_byte_is_lost(firmware, what):
    arm, task = homing(firmware)
    assert arm.twin.device.moving
    if what != "nothing":
        lose(arm, what)
    stop_homing(arm, task)


@functools.cache
def to_the_switch_s(firmware):
    """Return for how long it goes on until it waits at a switch: the same in every run."""
    arm, _ = homing(firmware)
    began_s = arm.status.time_s
    while arm.twin.device.moving:
        arm.sleep(0.005)
    return arm.status.time_s - began_s


@in_pairs("firmware, waited_s", HOME_SINGLE_AXES[:: amount(2, 1)], [0.0, 0.2])
def test_a_stop_ends_homing_that_waits_at_a_switch(firmware, waited_s):
    arm, task = homing(firmware)
    arm.sleep(to_the_switch_s(firmware) - 0.01)
    assert arm.twin.device.moving
    arm.sleep(0.01 + waited_s)
    assert not arm.twin.device.moving
    stop_homing(arm, task)


@pytest.mark.parametrize("firmware", HOME_SINGLE_AXES)
def test_a_stop_ends_homing_that_backs_off_a_switch(firmware):
    """The alarm is 8 then, as if backing off had failed: observed on grbl-Mega-5X."""
    arm, task = homing(firmware)
    arm.sleep(to_the_switch_s(firmware) + 0.1)
    while not arm.twin.device.moving:
        arm.sleep(0.002)
    assert arm.twin.board.switches.mask()
    stop_homing(arm, task)


def test_a_stop_of_fluidnc_before_a_slow_approach_is_announced_in_full():
    arm, task = homing("fluidnc", for_s=0.0, s24=600.0)  # its motors turn no slower than 38 steps/s
    for moves in (True, False, True, False):  # to the switch, off it, and then slowly on again
        while arm.twin.device.moving is not moves:
            arm.sleep(0.005)
    stop_homing(arm, task)


def at_zeros(**options):
    """Return an arm whose counts are zero, so that only the greeting shows a reset."""
    arm = found(**options)
    arm.reference.declare(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)
    assert not arm.twin.device.registers.largest
    arm.twin.link.sent.clear()
    return arm


def reset_instead(arm):
    """Press the board's own button just as the driver sends its reset."""

    def press(_):
        assert not arm.twin.device.registers.largest
        arm.twin.board.reset()
        return []

    arm.twin.link.to.append(Rule(rb"\x18", press))


@in_pairs("firmware, after_s", FIRMWARES, [0.003, 0.006])
def test_a_greeting_that_comes_late_is_no_answer_to_a_stop(firmware, after_s):
    arm = at_zeros(firmware=firmware)
    handle = arm.move_j(base_deg=40, wait=False)
    arm.sleep(after_s)
    reset_instead(arm)
    arm.stop()
    arm.sleep(3.0)
    assert handle.done
    assert arm.twin.link.pressed(b"\x18") == 1
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.state is State.ERROR_STOP
    assert "reset, or lost its power" in arm.status.error
    arm.reset()
    arm.enable()
    assert arm.status.state is State.STANDBY


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_a_second_greeting_shows_that_the_board_has_restarted(firmware):
    arm = at_zeros(firmware=firmware)
    arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.003)
    arm.stop()
    assert arm.status.trust is Trust.REFERENCED
    arm.twin.board.reset()
    arm.sleep(2.0)
    assert arm.status.trust is Trust.SUSPECT
    arm.reset()
    arm.twin.link.sent.clear()
    arm.jog_j(base_deg=1)
    assert MODES.text.encode() + b"\n" in arm.twin.link.messages  # the board has forgotten them


def test_a_greeting_of_a_silent_board_during_its_reset_makes_it_suspect():
    arm = at_zeros()
    arm.estop()
    arm.sleep(0.5)
    assert arm.status.trust is Trust.REFERENCED
    arm.sleep(0.1)
    arm.twin.board.reset()  # its start takes longer than the timeout of a report
    arm.reset()
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.state is State.STANDBY


def test_a_greeting_in_time_keeps_the_position():
    for after_s in (0.003, 0.05, 0.2, 0.6):
        arm = at_zeros()
        arm.move_j(base_deg=40, wait=False)
        arm.sleep(after_s)
        arm.stop()
        arm.sleep(2.0)
        assert arm.status.trust is Trust.REFERENCED
        assert standing_as_said(arm)
