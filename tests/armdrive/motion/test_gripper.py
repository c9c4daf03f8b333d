"""Grasping: widths, forces, a switch that is closed already or never trips, and stopping."""

from dataclasses import replace

import pytest
from faults import OVER_THE_TABLE, sim_arm, sim_config

from armdrive.errors import BadRequest, DeviceFault, OutOfBounds, Stopped
from armdrive.runtime.position import DeviceReadings, FingerState
from armdrive.sim.world.table import TableBlock
from armdrive.status import Current, State, Trust
from armdrive.tasks import Registers
from kinematics import Motors, Pose

TAKE = Pose.of(x_mm=260, y_mm=0, z_mm=15, pitch_deg=-90)


def arm_around_a_block(width_mm, config=None):
    """An arm whose open fingers stand around a block."""
    block = TableBlock("A", 260.0, 0.0, 0.0, width_mm, 30.0)
    arm = sim_arm(config, at=OVER_THE_TABLE, blocks=[block])
    arm.gripper.open()
    arm.move_to(Pose.of(x_mm=260, y_mm=0, z_mm=80, pitch_deg=-90))
    arm.move_l(TAKE)
    return arm


@pytest.mark.parametrize(
    ("force_n", "width_mm"),
    [(4.0, 3.0), (8.9, 12.7), (20.0, 25.0), (4.0, 38.4), (8.9, 60.0), (20.0, 74.0)],
)
def test_a_grasp_measures_the_block_and_presses_as_asked(width_mm, force_n):
    arm = arm_around_a_block(width_mm)
    found = arm.gripper.feel(force_n=force_n)
    assert found.holding
    assert found.width_mm == pytest.approx(width_mm, abs=0.3)
    assert arm.twin.world.grip_force_n == pytest.approx(force_n, abs=1.0)
    assert found.force_n == pytest.approx(arm.gripper.force_n)
    assert arm.gripper.force_n == pytest.approx(arm.twin.world.grip_force_n, abs=1.0)
    assert arm.gripper.opening_mm == found.width_mm  # the block keeps the fingers apart
    arm.move_l(Pose.of(x_mm=260, y_mm=0, z_mm=70, pitch_deg=-90))
    assert arm.twin.world.scene.blocks["A"].z_mm == pytest.approx(55.0, abs=1.0)
    arm.gripper.open()
    assert arm.gripper.force_n == 0.0


def test_the_force_grows_with_the_cable_pulled_in_behind_the_touch_until_they_open():
    config = sim_config()
    fingers = FingerState(config, config.model.transmission)
    assert fingers.force_n(20.0) == 0.0
    fingers.touch_mm = 30.0
    assert fingers.force_n(28.0) == pytest.approx(2.0 * fingers.force_n(29.0))
    assert fingers.seen_mm(28.0) == 30.0  # what they hold keeps them apart
    fingers.arrive(30.0)
    assert fingers.force_n(28.0) == 0.0
    assert fingers.seen_mm(28.0) == 28.0


@pytest.mark.parametrize("grip_switch", [True, False])
def test_without_a_grip_switch_nothing_tells_whether_they_grip(grip_switch):
    readings = DeviceReadings(grip_switch=grip_switch)
    readings.sense(Registers(Motors([0] * 6), 5, gripping=True, held=False))
    assert readings.gripping is (True if grip_switch else None)
    assert (readings.inputs, readings.sensed, readings.current) == (5, 1, Current.OFF)


def test_nothing_between_the_fingers_is_a_width_of_zero():
    arm = sim_arm(at=OVER_THE_TABLE)
    assert arm.gripper.grasp() == 0.0
    assert arm.status.trust is Trust.REFERENCED


def test_a_grip_switch_that_is_already_closed_opens_before_the_grasp_measures():
    arm = arm_around_a_block(30.0)
    first = arm.gripper.grasp(force_n=25.0)
    assert arm.status.gripping
    again = arm.gripper.grasp(force_n=4.0)
    assert again == pytest.approx(first, abs=0.3)
    assert arm.twin.world.grip_force_n == pytest.approx(4.0, abs=1.0)


@pytest.mark.parametrize("force_n", [-1.0, 36.0])
def test_a_force_out_of_range_is_refused_and_nothing_moves(force_n):
    arm = sim_arm(at=OVER_THE_TABLE)
    with pytest.raises(BadRequest, match="0 to 35 N"):
        arm.gripper.grasp(force_n=force_n)
    assert not arm.twin.link.named(b"@STEP")
    assert arm.status.state is State.STANDBY


@pytest.mark.parametrize("after_s", [0.05, 0.6, 1.5, 2.2])
def test_a_stopped_grasp_stops_closing_within_the_stated_time(after_s):
    arm = arm_around_a_block(20.0)

    began_s, asked_s = arm.engine.now_s, []

    def stop_later(data):
        if not asked_s and arm.engine.now_s - began_s >= after_s:
            asked_s.append(arm.engine.now_s)
            arm.request_stop()

    arm.twin.link.on_write = stop_later
    with pytest.raises(Stopped):
        arm.gripper.grasp(force_n=35.0)
    last_step_s = [at for at, line in arm.twin.link.sent if line.startswith(b"@STEP")][-1]
    assert last_step_s <= asked_s[0]
    assert arm.status.state is State.STANDBY
    assert not arm.twin.device.moving


@pytest.mark.parametrize(
    ("closed", "words"),
    [(False, "did not trip"), (True, "did not release")],
    ids=["never closes", "never opens"],
)
def test_a_grip_switch_that_is_stuck_is_reported_before_the_fingers_are_strained(closed, words):
    arm = sim_arm(at=OVER_THE_TABLE)
    arm.twin.device.set_input(3, closed)
    device = arm.config.device
    arm.core.controller._settings = replace(device, grip_bit=3)
    with pytest.raises(DeviceFault, match=words):
        arm.gripper.grasp()
    assert arm.twin.world.grip_force_n <= 10.0
    assert arm.twin.world.opening_mm < 50.0
    assert arm.status.state is State.STANDBY


def test_opening_and_closing_end_where_asked_while_the_elbow_turns():
    arm = sim_arm(at=OVER_THE_TABLE)
    arm.gripper.open(40.0)
    arm.move_j(elbow_deg=-120)
    assert arm.twin.world.opening_mm == pytest.approx(40.0, abs=0.05)
    assert arm.gripper.opening_mm == pytest.approx(40.0, abs=0.05)
    arm.gripper.close(5.0)
    assert arm.twin.world.opening_mm == pytest.approx(5.0, abs=0.05)
    widest_mm = arm.model.gripper_range_mm[1]
    for opening_mm in (90.0, widest_mm + 0.02):  # which is not rounded to the bound
        with pytest.raises(OutOfBounds, match=f"not to {opening_mm:g} mm"):
            arm.gripper.open(opening_mm)
