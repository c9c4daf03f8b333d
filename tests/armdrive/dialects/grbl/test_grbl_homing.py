"""A GRBL board that homes by its switches, each motor by its own command."""

import functools
import itertools
import re
from dataclasses import replace

import pytest
from amounts import amount, each_value
from faults import OVER_THE_TABLE, Rule, becoming, lost
from grbl_arm import HOME_SINGLE_AXES, config, found, stands

from armdrive import Arm, Jog
from armdrive.blocking import run_blocking
from armdrive.config.sections import HomingSettings
from armdrive.connect.parts import connect_simulated
from armdrive.errors import DeviceFault, SettingsDiffer
from armdrive.motion.device import compare_settings
from armdrive.motion.reference import home_device
from armdrive.registry import simulate
from armdrive.sim.grbl.firmware import AlarmNumber
from armdrive.sim.mechanics.motors import SwitchState
from armdrive.status import State, Trust
from firmware_protocol.grbl import State as BoardMode
from firmware_protocol.grbl.answers import Ok
from kinematics import Joints

HOMED = Joints.of(60.0, 20.0, -90.0, -20.0, 0.0)
ONE_BY_ONE = ((3,), (2,), (1,), (4, 5))
"""All motors but the last: FluidNC would stay locked, because axis C is not homed."""


def homing_config(groups=(), **device):
    homing = HomingSettings(HOMED, 60.0, groups)
    return replace(config(device={"homing": True, **device}), homing=homing)


def compare(arm):
    """Read the board's settings, and compare them with the arm file."""
    run_blocking(arm.parts.runner.perform(compare_settings(arm.parts.context)))


@each_value("firmware, groups", HOME_SINGLE_AXES, [ONE_BY_ONE, ()])
def test_homing_ends_where_the_arm_file_says(firmware, groups):
    arm = found(homing_config(groups), firmware=firmware)
    if firmware != "grblhal":
        assert (arm.status.state, arm.status.notice_code) == (State.STANDBY, "E506")
        assert "until it has homed" in arm.status.notice
    arm.home()
    assert (arm.status.state, arm.status.notice) == (State.STANDBY, "")
    assert arm.status.trust is Trust.REFERENCED
    motors = arm.twin.world.motors
    if not groups:
        assert motors == arm.status.acknowledged
    homed = [piece for _, piece in arm.twin.link.sent if piece.startswith(b"$H")]
    homed = [piece for piece, _ in itertools.groupby(homed)]  # FluidNC's counts stay zero
    one_by_one = "ZYXAB" if groups else "".join(arm.config.device.axes[:6])
    assert homed == [f"$H{letter}\n".encode() for letter in one_by_one]
    arm.home()  # it stands at its switches already
    assert arm.twin.world.motors == motors
    arm.move_j(base_deg=50)
    assert arm.status.joints.deg["base"] == pytest.approx(50, abs=0.1)


@pytest.mark.parametrize("firmware", HOME_SINGLE_AXES[: amount(1, 3)])
def test_a_search_that_finds_no_switch_ends_within_the_time_that_the_boards_settings_give(firmware):
    made = homing_config(homing_s=290.0)
    arm = found(made, firmware=firmware)
    announced_s = arm.parts.core.controller.search(made.homing.requests()[0]).time_s
    assert announced_s != made.device.homing_s  # what is assumed of a board that says nothing
    arm.twin.board.set_switch(0, SwitchState.OPEN)
    began_s = arm.status.time_s
    with pytest.raises(DeviceFault, match="did not find the switch"):
        arm.home()
    assert 50.0 < arm.status.time_s - began_s <= announced_s


def test_homing_that_takes_too_long_names_the_key_that_allows_more():
    arm = found(homing_config(homing_s=5.0))
    arm.parts.core.controller.searches_s = (None,) * 6  # the board does not report its speeds
    with pytest.raises(DeviceFault, match=r"not ended after 11 s.* raise grbl.homing_s in the arm"):
        arm.home()
    assert not arm.twin.device.moving


@pytest.mark.parametrize(
    ("firmware", "least_s"), [("mega5x", 30.0), ("grblhal", 200.0), ("fluidnc", 30.0)]
)
def test_a_board_that_homes_slowly_has_the_time_that_its_settings_give(firmware, least_s):
    made = homing_config(((1,),), homing_s=1.0)
    twin = simulate(made, firmware=firmware)
    twin.board.settings.values[25] = 5.0 * 60.0  # steps a minute
    arm = Arm(connect_simulated(made, twin=twin))
    began_s = arm.status.time_s
    arm.home()
    assert arm.status.time_s - began_s > least_s
    assert arm.status.trust is Trust.REFERENCED


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


# -- Homing that goes wrong references nothing -----------------------------------------------------


def test_a_homing_command_that_was_changed_on_the_wire_references_nothing():
    """The board answered what had become a comment with ok."""
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


@pytest.mark.parametrize("firmware", ["mega5x", "grblhal"])
def test_a_homing_command_that_turns_another_motor_references_nothing(firmware):
    arm = homing_with_a_changed_line(firmware, b"X", b"Y")
    with pytest.raises(DeviceFault, match="changed on the wire, because another motor has turned"):
        arm.home()
    assert not arm.twin.device.moving
    assert arm.status.trust is not Trust.REFERENCED


@pytest.mark.parametrize(
    ("firmware", "letter", "other"),
    [(each, b"Z", b"X") for each in HOME_SINGLE_AXES] + [("fluidnc", b"X", b"Y")],
)
def test_a_homing_command_after_which_no_count_has_changed_is_repeated(firmware, letter, other):
    arm = homing_with_a_changed_line(firmware, letter, other)
    arm.home()
    assert arm.twin.world.motors == arm.status.acknowledged


@pytest.mark.parametrize("firmware", HOME_SINGLE_AXES[amount(1, 0) :])
def test_a_damaged_report_is_no_motor_that_turns_while_another_one_homes(firmware):
    arm = found(homing_config(), firmware=firmware)
    arm.reset()
    report = rb"(<(?:Idle|Home|Alarm)\|MPos:[^,]+,[^,]+,[^,]+,[^,]+,)[^,]+"
    damage = becoming(lambda line: re.sub(report, rb"\g<1>7.000", line))
    rules = [Rule(report, damage, skip=skip) for skip in (0, 3, 9, 17)]
    arm.twin.link.back += rules
    arm.home()
    assert arm.twin.world.motors == arm.status.acknowledged
    assert not rules[0].times


def test_a_board_that_executes_no_lines_does_not_home():
    arm = found(homing_config(), firmware="mega5x")
    arm.reset()  # it boots locked
    arm.twin.board.state = BoardMode.SLEEP
    began_s = arm.status.time_s
    with pytest.raises(DeviceFault, match=r"the board's state is Sleep; `reset\(\)` leaves it"):
        arm.home()
    assert arm.status.time_s - began_s < 1.0


@pytest.mark.parametrize("firmware", HOME_SINGLE_AXES[amount(2, 0) :])
def test_after_homing_that_failed_the_next_motion_begins_where_the_arm_stands(firmware):
    """FluidNC drove on from where its search was to end."""
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


@pytest.mark.parametrize("firmware", ["mega5x", "fluidnc"])
def test_homing_away_from_a_switch_is_named_beforehand_and_refused(firmware):
    arm = found(homing_config(), firmware=firmware)
    assert "differ" not in arm.reference.homing_words
    values = arm.twin.board.settings.values
    ways, start = int(values[23]), arm.twin.world.motors
    values[23] = float(ways ^ 1)  # of the base, which homes near an end
    compare(arm)
    assert "$23 (homing directions" in arm.reference.homing_words
    with pytest.raises(SettingsDiffer) as refused:
        arm.home()
    assert arm.twin.world.motors == start
    arm.reset()  # it boots locked
    arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=0.5)
    arm.sleep(1.0)
    assert arm.twin.world.motors != start  # to find out what is right, it may turn its motors
    if firmware == "fluidnc":
        assert "in the board's configuration file" in str(refused.value)
        assert "--fix" not in str(refused.value)
    else:
        assert f"send `$23={ways}`" in str(refused.value)
        arm.controller.fix_settings([f"$23={ways}"])
        arm.home()
        assert arm.status.trust is Trust.REFERENCED


def test_an_alarm_right_after_homing_is_not_unlocked(monkeypatch):
    arm = found(homing_config(), firmware="mega5x")
    arm.reset()  # it boots locked
    board = arm.twin.board

    def touched(answer, say=board.say):
        say(answer)
        if isinstance(answer, Ok) and arm.twin.link.sent[-1][1] == b"$HC\n":
            board.routines.critical(board, AlarmNumber.HARD_LIMIT)

    monkeypatch.setattr(board, "say", touched)
    with pytest.raises(DeviceFault):
        arm.home()
    assert board.state.value == "Alarm"
    assert arm.status.state is State.ERROR_STOP


def test_homing_is_refused_on_a_board_that_cannot_home():
    arm = found(homing_config(((1,),)), firmware="grbl")
    arm.reset()  # it boots locked
    with pytest.raises(DeviceFault, match="not known or not supported"):
        arm.home()
    arm.reset()  # it stays in the state of homing until then
    assert arm.status.state is State.STANDBY


# -- A stop ends homing ----------------------------------------------------------------------------


def homing(firmware, for_s=1.0, **values):
    """Return an arm that has homed for a while on a board with some settings, and the task."""
    made = homing_config()
    arm = found(made, firmware=firmware)
    arm.twin.board.settings.values.update({int(key[1:]): value for key, value in values.items()})
    task = arm.parts.runner.submit(home_device(arm.parts.context, made.homing))
    arm.sleep(for_s)
    return arm, task


def wait_until(arm, *, moving):
    while arm.twin.device.moving is not moving:
        arm.sleep(0.01)


def stop_homing(arm, task):
    status = arm.status
    arm.request_stop()
    assert stands(arm) - status.time_s <= status.stop_time_s
    arm.sleep(3.0)
    assert task.done
    assert arm.status.trust is not Trust.REFERENCED
    assert arm.status.state is State.STANDBY


@each_value("firmware, what", HOME_SINGLE_AXES, [rb"\x18", "nothing", "message"])
def test_homing_that_is_stopped_ends_in_time_although_a_byte_is_lost(firmware, what):
    arm, task = homing(firmware)
    assert arm.twin.device.moving
    if what == "message":
        arm.twin.faults.add("drop", "next", side="host")
    elif what != "nothing":
        arm.twin.link.to.append(Rule(what, lost))
    stop_homing(arm, task)


@each_value("firmware, backs_off", HOME_SINGLE_AXES, [True, False])
def test_a_stop_ends_homing_that_is_at_a_switch(firmware, backs_off):
    """If it backs off, the alarm is 8, as if that had failed: observed on grbl-Mega-5X."""
    arm, task = homing(firmware)
    wait_until(arm, moving=False)
    if backs_off:
        wait_until(arm, moving=True)
        assert arm.twin.board.switches.mask()
    stop_homing(arm, task)


def test_a_stop_of_fluidnc_before_a_slow_approach_is_announced_in_full():
    arm, task = homing("fluidnc", for_s=0.0, s24=600.0)  # its motors turn no slower than 38 steps/s
    for moving in (True, False, True, False):  # to the switch, off it, and then slowly on again
        wait_until(arm, moving=moving)
    stop_homing(arm, task)
