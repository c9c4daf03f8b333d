"""Jogs of a driven arm: frames, increments as far as the bounds, and what waits too long."""

import math

import pytest
from amounts import amount
from faults import ready_arm, sim_arm
from jog_trials import Ground, trials

from armdrive import Jog
from armdrive.errors import BadRequest, OutOfBounds, WrongState
from armdrive.moves import JogMove
from armdrive.registry.arm_files import parse_arm
from armdrive.status import State


def test_a_jog_in_the_tools_frame_goes_where_the_hand_points():
    arm = ready_arm()
    before = arm.pose
    arm.jog_l(frame="tool", z=1.0, duration_s=1.0)
    after, pitch = arm.pose, before.pitch_rad
    way = (after.x_mm - before.x_mm, after.z_mm - before.z_mm)
    assert math.hypot(*way) > 3.0
    assert math.atan2(way[1], way[0]) == pytest.approx(pitch, abs=0.05)
    arm.jog_l(frame="tool", z_mm=-math.hypot(*way))
    assert arm.pose.z_mm == pytest.approx(before.z_mm, abs=0.4)


def test_an_unknown_frame_is_refused_with_those_that_are_known():
    arm = ready_arm()
    with pytest.raises(BadRequest, match="known are base, tool"):
        arm.jog_l(frame="bench", x=1.0, duration_s=1.0)
    arm.hold(Jog.cartesian(frame="bench", x=1.0), speed=0.5, for_s=0.5)
    arm.sleep(0.5)
    assert "bench" in arm.status.notice
    assert not arm.twin.link.named(b"@STEP")


def test_an_increment_that_is_too_long_ends_at_the_bound_and_says_why():
    arm = ready_arm()
    jogged = arm.jog_l(z_mm=-400.0, gripper_mm=5.0)
    assert "table" in jogged.note
    assert -1.5 < arm.twin.world.pose.z_mm < 0.0
    assert arm.status.state is State.STANDBY
    assert "gripper" in arm.jog_j(gripper_mm=200.0).note
    assert arm.twin.world.opening_mm == pytest.approx(76.0, abs=0.1)


def test_a_long_increment_of_the_tip_is_straight():
    arm = ready_arm()
    before, off_mm = arm.twin.world.tip, 0.0
    arm.nudge(Jog.cartesian(y=150.0), speed=1.0)
    for _ in range(400):
        arm.sleep(0.02)
        x_mm, _, z_mm = arm.twin.world.tip
        off_mm = max(off_mm, math.hypot(x_mm - before[0], z_mm - before[2]))
    assert arm.twin.world.tip[1] == pytest.approx(before[1] + 150.0, abs=0.4)
    assert off_mm < 1.0


def test_an_increment_that_had_to_wait_too_long_is_dropped():
    arm = ready_arm()
    arm.nudge(Jog.joint(base=60.0), speed=1.0)
    arm.sleep(0.1)
    arm.nudge(Jog.joint(base=5.0), speed=1.0)
    arm.sleep(8.0)
    assert arm.joints.deg["base"] == pytest.approx(60.0, abs=0.03)
    assert "dropped" in arm.status.notice


def test_a_program_cannot_queue_increments_either():
    arm = ready_arm()
    arm.nudge(Jog.joint(base=2.0), speed=1.0)
    with pytest.raises(WrongState, match="already waiting"):
        arm.jog_j(base_deg=5.0)
    arm.sleep(1.0)
    assert arm.joints.deg["base"] == pytest.approx(2.0, abs=0.03)


def test_fingers_at_the_end_of_their_range_leave_the_tip_alone():
    arm = ready_arm()
    arm.gripper.open(65.0)
    before = arm.twin.world.tip
    jogged = arm.jog_l(z=0.3, gripper=1.0, duration_s=6.0, speed=0.5)
    assert jogged.note == "the gripper stopped at the limit"
    assert arm.twin.world.tip[2] > before[2] + 30.0


def test_a_held_jog_that_has_ended_at_a_bound_does_not_creep_on():
    arm = ready_arm()
    arm.jog_l(z=-1.0, speed=1.0, duration_s=8.0)
    motors = arm.twin.world.motors
    for _ in range(20):
        arm.hold(Jog.cartesian(z=-1.0), speed=1.0, for_s=0.3)
        arm.sleep(0.1)
    assert arm.twin.world.motors == motors
    assert "table" in arm.status.notice


def test_the_note_of_a_bound_disappears_when_the_jog_leads_back():
    arm = ready_arm()
    arm.move_j(base_deg=86.0)
    for _ in range(12):
        arm.hold(Jog.joint(base=1.0), speed=1.0, for_s=0.3)
        arm.sleep(0.1)
    assert "limit" in arm.status.notice
    arm.hold(Jog.joint(base=-1.0), speed=1.0, for_s=0.5)
    arm.sleep(0.4)
    assert arm.status.notice == ""


def test_a_pens_tip_is_jogged_along_its_own_line():
    config = parse_arm(
        {"model": "teachmover", "tool": {"along_mm": 60.0, "up_mm": 12.0}}, name="with a pen"
    )
    arm = ready_arm(config)
    before = arm.pose
    arm.jog_l(x=1.0, speed=1.0, duration_s=0.8)
    after = arm.pose
    assert after.x_mm > before.x_mm + 8.0
    assert (after.y_mm, after.z_mm) == pytest.approx((before.y_mm, before.z_mm), abs=0.5)
    assert "table" in arm.jog_l(z_mm=-400.0).note


TOO_FAR = [
    pytest.param(lambda arm: arm.jog_j(base_deg=1e6), "base", 1e6, 180.0, id="increment"),
    pytest.param(lambda arm: arm.jog_j(base_deg=-181.0), "base", -181.0, 180.0, id="just too far"),
    pytest.param(lambda arm: arm.jog_j(gripper_mm=200.0), "gripper", 200.0, 76.0, id="fingers"),
    pytest.param(
        lambda arm: arm.start(JogMove(Jog.joint(elbow=1e6))), "elbow", 1e6, 149.0, id="move"
    ),
    pytest.param(
        lambda arm: arm.jog_j(base=-1.0, duration_s=1e5, speed=0.01), "base", None, 180.0, id="held"
    ),
]


@pytest.mark.parametrize(("call", "name", "amount", "whole"), TOO_FAR)
def test_no_jog_without_limits_is_longer_than_the_whole_range(call, name, amount, whole):
    arm = sim_arm()
    with pytest.raises(OutOfBounds, match=f"the {name} would move by .* whole range is") as refused:
        call(arm)
    assert refused.value.name == name
    assert refused.value.bound == pytest.approx(whole, abs=0.1)
    assert amount is None or refused.value.value == pytest.approx(amount)
    assert not arm.twin.link.named(b"@STEP")


def test_a_nudge_longer_than_the_whole_range_moves_nothing_and_says_so():
    arm = sim_arm()
    arm.nudge(Jog.joint(base=1e6), speed=1.0)
    arm.sleep(1.0)
    assert "whole range is 180°" in arm.status.notice
    assert not arm.twin.link.named(b"@STEP")
    assert arm.jog_j(base_deg=180.0, speed=1.0).joints.deg["base"] == pytest.approx(180.0, abs=0.1)


def test_what_a_jog_was_answered_is_gone_when_the_next_motion_begins():
    arm = ready_arm()
    arm.jog_l(z_mm=-400.0)
    assert "table" in arm.status.notice
    arm.move_j(base_deg=5.0)
    assert arm.status.notice == ""
    arm.hold(Jog.cartesian(frame="bench", x=1.0), speed=0.5, for_s=0.5)
    assert "bench" in arm.status.notice
    arm.gripper.open(30.0)
    assert arm.status.notice == ""


# -- a sample of the jogs of benchmarks/jog_limits.py ---------------------------------------------


SEED = 22
COUNTS = {"teachmover": 4, "robko01": amount(1, 2), "armdroid": amount(1, 2), "grbl": amount(1, 3)}
LATER_S = 0.2
NEAR_STEPS = 3.0


@pytest.mark.parametrize("dialect", COUNTS)
def test_a_jog_at_full_speed_ends_at_its_bound_and_turns_back_at_once(dialect):
    ground = Ground(dialect, SEED)
    for one in trials(dialect, SEED, COUNTS[dialect]):
        assert one.kept, one
        assert one.left_steps is None or one.left_steps <= NEAR_STEPS, one
        assert one.back_s <= ground.begins_s + LATER_S, one
        assert one.stall_s <= ground.stands_s + LATER_S, one
