"""A disturbed wire between a GRBL board and its driver: no wrong position is trusted."""

import re
from dataclasses import replace

import pytest
from faults import OVER_THE_TABLE, Rule, becoming, honest, lost, without_byte
from grbl_arm import Disturbed, config, found, ready, stands

from armdrive import Arm, Jog, Pose
from armdrive.connect.parts import connect_simulated
from armdrive.errors import DeviceFault, NoAnswer, SettingsDiffer
from armdrive.registry import simulate
from armdrive.sim.simulated_arm import link_to
from armdrive.status import Evidence, State, Trust

CHANGES = {
    "lost": lost,
    "first byte gone": without_byte(0),
    "second byte gone": without_byte(1),
    "a middle byte gone": without_byte(8),
    "a late byte gone": without_byte(12),
    "end gone": without_byte(-1),
    "a digit changed": becoming(lambda piece: re.sub(rb"\d", b"7", piece, count=1)),
}


def survive(arm):
    """Move; a fault must latch and be cleared, and a trusted position must be right."""
    try:
        arm.move_j(base_deg=8, shoulder_deg=42)
        arm.jog_j(shoulder_deg=2)
        faulty = False
    except DeviceFault:
        assert arm.status.state is State.ERROR_STOP
        faulty = True
    arm.sleep(1.2)
    assert honest(arm)
    if faulty:
        before = arm.twin.world.motors
        arm.reset()
        assert arm.twin.world.motors == before
    arm.declare_posture(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)
    arm.move_j(base_deg=5)
    assert honest(arm)
    assert arm.twin.world.joints.deg["base"] == pytest.approx(5.0, abs=0.1)
    return faulty


MOTION, JOG, MODES = rb"G91G1", rb"\$J=", rb"G17"
GONE = ["lost", "first byte gone", "end gone"]
DISTURBED = [
    ("back", b"ok", 1, GONE),
    ("back", b"ok", 6, GONE),
    ("back", b"<", 6, CHANGES),
    ("to", MODES, 0, CHANGES),
    ("to", MOTION, 0, CHANGES),
    ("to", MOTION, 3, ["lost", "a middle byte gone", "end gone"]),
    ("to", JOG, 0, ["lost", "a middle byte gone", "a late byte gone", "end gone"]),
    ("to", JOG, 3, ["lost", "a middle byte gone"]),
]


@pytest.mark.parametrize(
    ("side", "start", "skip", "change"),
    [(*row, change) for *row, changes in DISTURBED for change in changes],
)
def test_a_disturbed_answer_is_survived_and_a_disturbed_motion_at_least_found_out(
    side, start, skip, change
):
    arm = ready()
    rules = getattr(arm.twin.link, side)
    rules.append(Rule(start, CHANGES[change], skip))
    faulty = survive(arm)
    assert not rules[0].times  # it was disturbed
    assert not faulty or start in (MOTION, JOG)


@pytest.mark.parametrize("byte", [rb"\?", rb"!", rb"\x18", rb"\x85"])
def test_a_lost_real_time_byte_is_said_again(byte):
    arm = ready()
    arm.twin.link.to.append(Rule(byte, lost))
    arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.5)
    arm.stop()
    assert arm.twin.board.details()["state"] == "Idle"
    arm.hold(Jog.joint(base=1.0), speed=1.0, for_s=3.0)
    arm.sleep(0.5)
    arm.release()
    stands(arm)
    assert arm.twin.board.details()["state"] == "Idle"
    assert arm.status.trust is Trust.REFERENCED
    assert arm.twin.world.motors == arm.status.acknowledged


def test_a_banner_that_is_garbled_does_not_lock_the_driver_out():
    arm = ready()
    arm.twin.link.back.append(Rule(b"Grbl", without_byte(2)))
    arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.5)
    arm.stop()
    arm.move_j(base_deg=0)
    assert arm.twin.world.motors == arm.status.acknowledged


def test_an_arm_that_leaves_the_path_is_stopped_on_its_way():
    arm = ready()
    arm.twin.link.to.append(Rule(rb"G91G1", becoming(lambda line: line.replace(b"X+", b"X-")), 8))
    handle = arm.move_j(base_deg=80, wait=False)
    with pytest.raises(DeviceFault, match="off the path"):
        handle.wait(10.0)
    assert arm.twin.world.joints.deg["base"] < 30.0
    assert arm.status.trust is Trust.SUSPECT
    assert arm.status.trust_reason.startswith(Evidence.OFF_THE_PATH.value)
    assert arm.status.state is State.ERROR_STOP


def test_no_board_at_all_is_told_after_a_while():
    made = config()
    twin = simulate(made)
    link = Disturbed(twin.link)
    link.to.append(Rule(b"", lost, times=1e9))
    with pytest.raises(NoAnswer, match="switched on"):
        connect_simulated(made, twin=replace(twin, link=link))
    assert not link.motions


def test_a_board_in_a_hold_or_asleep_is_woken_by_connecting_and_moves_nothing():
    arm = found()
    arm.disable()
    arm.sleep(1.0)  # meanwhile the arm sags
    arm.close()
    before = arm.twin.world.motors
    twin = replace(arm.twin, link=Disturbed(link_to(arm.twin.device)))
    again = Arm(connect_simulated(arm.config, twin=twin))
    assert again.status.state is State.STANDBY
    assert twin.board.details()["state"] in ("Idle", "Alarm")
    assert twin.world.motors == before


@pytest.mark.parametrize(
    ("reported", "unheard"), [(True, rb"ALARM|Grbl"), (True, rb"(\r\n)?ALARM"), (False, rb"ALARM")]
)
def test_an_emergency_stop_whose_alarm_is_lost_is_no_kept_position(reported, unheard):
    arm = ready()
    arm.move_j(base_deg=40, wait=False)
    while not arm.twin.device.moving:
        arm.sleep(0.001)
    arm.sleep(0.28 if reported else 0.02)  # the first report of the motion comes between
    arm.twin.link.back.append(Rule(unheard, lost, times=2))
    arm.estop()
    arm.sleep(4.0)
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.trust is Trust.SUSPECT


def test_a_board_that_resets_while_it_is_stopped_is_no_kept_position():
    arm = found()
    arm.declare_posture(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)
    assert not arm.twin.device.registers.largest  # so zero counts do not show a restart
    arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.1)
    arm.twin.board.reset()
    with pytest.raises(NoAnswer):
        arm.stop()
    assert arm.status.trust is Trust.SUSPECT


@pytest.mark.parametrize("count", [2, 3])
def test_oks_that_are_lost_end_no_motion_in_a_traceback(count):
    arm = ready()
    arm.twin.link.back.append(Rule(rb"ok\r\n", lost, skip=1, times=count))
    try:
        arm.move_j(base_deg=25, shoulder_deg=45)
    except DeviceFault:
        arm.reset()
    assert honest(arm)


def test_a_number_of_free_lines_that_is_garbled_keeps_no_motion_from_its_end():
    arm = ready()
    arm.twin.link.back.append(Rule(b"<", becoming(lambda told: told.replace(b"Bf:3", b"Bf:7"))))
    arm.move_j(base_deg=5)
    arm.move_j(base_deg=10)
    assert honest(arm)


def line_at(baud, ahead_s):
    made = config(planned_burst_s=ahead_s)
    arm = ready(replace(made, connection=replace(made.connection, baud=baud)))
    arm.move_to(Pose.of(x_mm=220, y_mm=-60, z_mm=120, pitch_deg=-60))
    before = arm.status.underruns
    moved = arm.move_l(Pose.of(x_mm=220, y_mm=60, z_mm=120, pitch_deg=-60))
    return arm.status.underruns - before, moved.duration_s


def test_a_queue_that_runs_empty_in_mid_motion_is_counted_and_shown():
    none, quick_s = line_at(115_200, 0.4)
    assert none == 0
    many, slow_s = line_at(9600, 0.1)  # at 9600 baud a line takes 35 ms, and a segment 33
    assert many >= 5
    assert slow_s > 1.5 * quick_s


def test_a_motion_that_waits_between_single_steps_is_no_underrun():
    arm = ready()
    before = arm.status.underruns
    arm.move_j(base_deg=OVER_THE_TABLE.deg["base"] + 0.3, speed=0.01)
    assert arm.status.underruns == before


# Settings read over a disturbed wire: a difference counts only if it is read twice.

A_HUNDRED_BECOMES_TEN = without_byte(3)
"""The rest of a damaged `$100=` changes $10, the contents of reports."""


def connected(times):
    twin = simulate(config())
    link = Disturbed(twin.link)
    link.back.append(Rule(rb"\$100=", A_HUNDRED_BECOMES_TEN, times=times))
    return Arm(connect_simulated(config(), twin=replace(twin, link=link)))


def test_a_setting_that_lost_a_byte_on_the_wire_keeps_no_arm_from_moving():
    arm = connected(times=1)
    assert arm.core.differences == ()
    arm.jog_j(base_deg=1.0)


def test_a_setting_that_differs_whenever_it_is_read_does():
    arm = connected(times=99)
    assert arm.core.differences
    with pytest.raises(SettingsDiffer):
        arm.jog_j(base_deg=1.0)
