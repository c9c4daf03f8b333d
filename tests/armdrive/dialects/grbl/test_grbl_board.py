"""A GRBL board apart from motion: alarms, resets, settings, homing, outputs."""

from dataclasses import replace

import pytest
from faults import OVER_THE_TABLE
from grbl_arm import config, found, ready, standing_as_said

from armdrive.blocking import run_blocking
from armdrive.config.sections import HomingSettings
from armdrive.errors import DeviceFault, PendantStop, Refused, SettingsDiffer
from armdrive.sim.mechanics.switches import SwitchState
from armdrive.status import State, Trust
from kinematics import Joints

HOLD_PIN = 2


def test_a_limit_alarm_mutes_the_board_which_is_no_broken_wire():
    arm = ready(config(device={"hard_limits": True}), limit_interrupts=True)
    handle = arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.6)
    arm.twin.board.set_switch(0, SwitchState.CLOSED)
    with pytest.raises(DeviceFault, match="alarm 1"):
        handle.wait(8.0)
    assert arm.status.state is State.ERROR_STOP
    assert "even if the cable is fine" in arm.status.error
    assert arm.status.trust is Trust.SUSPECT
    arm.twin.board.set_switch(0, SwitchState.FREE)
    arm.reset()
    assert arm.status.state is State.STANDBY


def test_a_limit_alarm_of_an_arm_that_stands_makes_its_position_suspect():
    arm = ready(config(device={"hard_limits": True}), limit_interrupts=True)
    arm.twin.board.set_switch(0, SwitchState.CLOSED)
    arm.sleep(2.0)
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.trust is Trust.SUSPECT


def test_somebody_at_the_hold_button_stops_the_arm_and_its_position_is_kept():
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
    musts = [each for each in arm.core.differences if each.must]
    assert {each.mend for each in musts} >= {"$1=255", "$10=3", "$100=1", "$105=1"}
    arm.declare_posture(OVER_THE_TABLE, opening_mm=20.0)
    with pytest.raises(SettingsDiffer, match=r"\$1=255"):
        arm.move_j(base_deg=3)
    from armdrive.motion.device import mend_settings

    lines = tuple(each.mend for each in arm.core.differences)
    run_blocking(arm.runner.perform(mend_settings(arm.wire, lines)))
    assert arm.core.differences == ()
    arm.move_j(base_deg=3)
    assert standing_as_said(arm)


@pytest.mark.parametrize("line", ["$J=G91X9F99", "$H", "$N0=G0X9", "$RST=*", "$X", "$100", "G0X9"])
def test_a_line_that_writes_no_setting_is_not_sent(line):
    arm = ready()
    sent, motors = len(arm.twin.link.sent), arm.twin.world.motors
    with pytest.raises(Refused, match="is not a GRBL setting"):
        arm.mend_settings([line])
    arm.sleep(1.0)
    assert not [piece for _, piece in arm.twin.link.sent[sent:] if line.encode() in piece]
    assert arm.twin.world.motors == motors


HOMED = Joints.of(60.0, 20.0, -90.0, -20.0, 0.0)
ONE_BY_ONE = ((2,), (1,), (4, 5))


def homing_config(groups=()):
    homing = HomingSettings(HOMED, 60.0, groups)
    return replace(config(device={"homing": True}), homing=homing)


@pytest.mark.parametrize(
    ("firmware", "groups"), [("grbl", ()), ("mega5x", ((3,), *ONE_BY_ONE)), ("grblhal", ())]
)
def test_homing_ends_where_the_arm_file_says(firmware, groups):
    arm = found(homing_config(groups), firmware=firmware)
    arm.home()
    assert arm.status.trust is Trust.REFERENCED
    if not groups:
        assert arm.twin.world.motors == arm.status.acknowledged
    homed = [piece for _, piece in arm.twin.link.sent if piece.startswith(b"$H")]
    assert homed == ([b"$HZ\n", b"$HY\n", b"$HX\n", b"$HA\n", b"$HB\n"] if groups else [b"$H\n"])


def test_a_board_that_cannot_home_says_so():
    arm = found(homing_config(((1,),)), firmware="grbl")
    with pytest.raises(DeviceFault, match="not known or not supported"):
        arm.home()


def test_outputs_and_a_servo_come_back_after_a_stop():
    arm = ready(config(gripper="servo", device={"outputs": ("flood",)}))
    arm.gripper.open(76.0)
    arm.set_outputs(1)
    assert arm.twin.world.opening_mm == pytest.approx(76.0, abs=1.0)
    before = arm.twin.board.details()["outputs"]
    arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.6)
    arm.stop()
    arm.sleep(0.5)
    assert arm.twin.board.details()["outputs"] == before
    with pytest.raises(Refused, match=r"grbl\.outputs"):
        arm.set_outputs(2)


@pytest.mark.parametrize(
    ("valve", "firmware"), [("flood", "mega5x"), ("mist", "mega5x"), ("P0", "grblhal")]
)
def test_a_gripper_on_a_valve_opens_and_closes(valve, firmware):
    other = "flood" if valve == "mist" else "mist"
    device = {"outputs": (other, valve), "gripper_output": 1}
    arm = ready(config(gripper="output", device=device), firmware=firmware)
    arm.gripper.open(76.0)
    assert arm.twin.world.opening_mm == pytest.approx(76.0, abs=1.0)
    arm.gripper.close(0.0)
    assert arm.twin.world.opening_mm == pytest.approx(0.0, abs=1.0)
