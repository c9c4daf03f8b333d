"""A GRBL arm driven through its controller, on simulated time: motion and its stops."""

import math

import pytest
from faults import OVER_THE_TABLE
from grbl_arm import (
    BEGINNINGS,
    begin_line,
    begin_planned,
    config,
    killed,
    ready,
    standing_as_said,
    stands,
    tip_mm,
)

from armdrive import Jog
from armdrive.dialects.grbl.settings import BoardAxes
from armdrive.errors import Stopped
from armdrive.status import State


def test_many_ways_in_degrees_come_back_to_the_same_steps():
    arm = ready(config(device={"unit": "degrees"}, idle_poll_s=0.0))
    began = arm.twin.world.motors
    for _ in range(8):
        arm.move_j(base_deg=7.77, wrist_roll_deg=3.3)
        arm.move_j(base_deg=0.0, wrist_roll_deg=0.0)
    assert arm.twin.world.motors == began


@pytest.mark.parametrize(("speed", "turn_deg"), [(1.0, 10), (0.3, 10), (0.02, 3)])
def test_a_motion_is_never_faster_than_asked_and_not_much_slower(speed, turn_deg):
    arm = ready()
    began_s = arm.status.time_s
    arm.move_j(base_deg=turn_deg, speed=speed)
    asked_s = math.radians(turn_deg) / (0.37 * speed)
    assert asked_s <= arm.status.time_s - began_s <= asked_s * 1.15 + 0.4


def test_joints_that_share_motors_are_no_slower_together_than_alone():
    arm = ready()
    began_s = arm.status.time_s
    arm.move_j(
        shoulder_deg=OVER_THE_TABLE.deg["shoulder"] + 20, elbow_deg=OVER_THE_TABLE.deg["elbow"] + 20
    )
    together_s = arm.status.time_s - began_s
    speeds = dict(zip(OVER_THE_TABLE.names, arm.config.model.joint_speeds_rad_s, strict=True))
    alone_s = max(math.radians(20) / speeds[name] for name in ("shoulder", "elbow"))
    motion = arm.config.motion
    assert together_s <= alone_s + motion.ramp_s + motion.jerk_s + 0.3


def test_what_is_expected_of_a_motor_that_several_joints_share_is_their_sum_up_to_the_fastest():
    expected = BoardAxes.of(config()).expected(config().device)
    base, shoulder, elbow, right, left, gripper = expected.rates
    assert right == left == gripper == base  # 733 and 544 would be their sums
    assert shoulder == pytest.approx(168.8, abs=0.1)
    assert elbow == pytest.approx(251.5, abs=0.1)


def test_a_slow_jog_is_slow():
    arm = ready()
    arm.hold(Jog.joint(base=1.0), speed=0.01, for_s=0.5)
    arm.sleep(2.0)
    assert math.radians(arm.twin.world.joints.deg["base"]) <= 0.37 * 0.01 * 0.6 + 2 / 1125


@pytest.mark.parametrize("begin", [begin_planned, begin_line])
def test_a_stop_brakes_and_does_not_only_send_no_more(begin):
    """Without a feed hold, a stopped arm would drive what was sent ahead to its end."""
    ways_mm = []
    for end in (lambda arm: (arm.request_stop(), stands(arm)), killed):
        arm = ready(config(planned_burst_s=0.5))
        begin(arm)
        arm.sleep(0.9)
        tip = arm.twin.world.tip
        end(arm)
        ways_mm.append(tip_mm(arm, tip))
    stopped_mm, sent_ahead_mm = ways_mm
    assert 0.0 < stopped_mm < 0.6 * sent_ahead_mm


@pytest.mark.parametrize(
    ("begin", "ramp_s"), [*((begin, 0.1) for begin in BEGINNINGS), (begin_line, 0.4)]
)
def test_a_board_whose_driver_dies_stops_in_the_announced_time_and_way(begin, ramp_s):
    for after_s in (0.04, 0.11, 0.83):
        arm = ready(config(device={"ramp_s": ramp_s}))
        begin(arm)
        arm.sleep(0.07 + after_s)
        status, tip = arm.status, arm.twin.world.tip
        assert status.state is State.MOVING
        assert killed(arm) <= status.silent_time_s
        assert tip_mm(arm, tip) <= status.silent_distance_mm


def test_a_stop_of_an_arm_that_stands_sends_nothing():
    arm = ready()
    arm.stop()
    arm.sleep(1.0)
    assert not arm.twin.link.pressed(b"!")
    assert not arm.twin.link.pressed(b"\x18")
    arm.move_j(base_deg=3)


def test_a_stop_just_as_the_motion_ends_leaves_no_hold_behind():
    for early_s in (0.0, 0.02, 0.08):
        arm = ready()
        handle = arm.move_j(base_deg=2, wait=False)
        began_s = arm.status.time_s
        took_s = math.radians(2) / 0.37 + 0.15
        arm.sleep(began_s + took_s - early_s - arm.status.time_s)
        arm.request_stop()
        arm.sleep(0.5)
        try:
            handle.wait()
        except Stopped:
            assert arm.status.state is State.STANDBY
        assert arm.twin.board.details()["state"] == "Idle"
        arm.move_j(base_deg=4)
        assert standing_as_said(arm)


def test_a_jog_that_is_let_go_ends_soon_and_only_cancels():
    arm = ready()
    arm.hold(Jog.joint(base=1.0), speed=1.0, for_s=5.0)
    arm.sleep(0.8)
    before = arm.twin.world.joints.deg["base"]
    arm.release()
    released_s = arm.status.time_s
    assert stands(arm) - released_s < 0.2
    assert arm.twin.world.joints.deg["base"] - before < math.degrees(0.37) * 0.2
    assert arm.twin.link.pressed(b"\x85")
    assert not arm.twin.link.pressed(b"\x18")
    assert standing_as_said(arm)
    assert arm.status.state is State.STANDBY


def test_no_more_than_one_line_of_a_jog_is_unanswered():
    arm = ready()
    host = arm.core.controller.exchange.host
    arm.hold(Jog.joint(base=1.0, elbow=-0.5), speed=1.0, for_s=1.0)
    most = 0
    for _ in range(300):
        arm.sleep(0.002)
        most = max(most, len(host.outstanding_lines))
    assert most == 1
