"""A GRBL arm paused while its wire is disturbed: a segment already drawn is not sent."""

import pytest
from backlash_bench import arm_with_play, off_steps
from faults import OVER_THE_TABLE, Rule, lost, without_byte
from grbl_arm import config, ready, standing_as_said, tip_mm

from armdrive import Jog
from armdrive.runtime.backlash import Slack
from armdrive.status import State, Trust
from kinematics import Motors

GOAL = {"base_deg": 18.0, "shoulder_deg": 52.0}


def pause_and_resume(arm, after_s, disturb):
    """Pause in mid-motion: the arm stops in time, and continues to its target."""
    handle = arm.move_j(wait=False, **GOAL)
    arm.sleep(after_s)
    disturb(arm)
    status, tip = arm.status, arm.twin.world.tip
    assert status.state is State.MOVING
    arm.pause()
    sent = len(arm.twin.link.motions)
    arm.sleep(status.pause_time_s)
    stood = arm.twin.world.motors
    arm.sleep(1.0)
    assert arm.twin.world.motors == stood
    assert tip_mm(arm, tip) <= status.pause_distance_mm
    assert len(arm.twin.link.motions) == sent
    assert arm.status.commanded == arm.status.acknowledged == stood
    arm.resume()
    handle.wait()
    assert standing_as_said(arm)
    assert arm.status.trust is Trust.REFERENCED
    assert arm.joints.deg["base"] == pytest.approx(GOAL["base_deg"], abs=0.1)


DISTURBANCES = {
    "nothing": lambda _: None,
    "a report's end lost": lambda arm: arm.twin.link.back.append(Rule(rb"<", without_byte(-1))),
    "two reports lost": lambda arm: arm.twin.link.back.append(Rule(rb"<", lost, times=2)),
    "an answer garbled": lambda arm: arm.twin.faults.add("corrupt", "next", side="device"),
    "answers late": lambda arm: arm.twin.faults.add("delay", 0.2, "next", side="device"),
}


@pytest.mark.parametrize("disturb", DISTURBANCES.values(), ids=DISTURBANCES)
def test_a_pause_ends_the_way_in_time_whatever_befalls_a_report(disturb):
    for after_s in (0.1, 0.5):
        pause_and_resume(ready(config(planned_burst_s=0.2)), after_s, disturb)


def test_a_motion_that_is_paused_again_and_again_ends_on_the_same_steps():
    arm = ready()
    arm.move_j(**GOAL)
    goal = arm.twin.world.motors
    arm.move_j(base_deg=0.0, shoulder_deg=OVER_THE_TABLE.deg["shoulder"])
    handle = arm.move_j(wait=False, **GOAL)
    for moving_s in (0.03, 0.05, 0.07, 0.11, 0.13, 0.3):
        arm.sleep(moving_s)
        disturbed = DISTURBANCES["two reports lost"]
        disturbed(arm)
        arm.pause()
        arm.sleep(1.0)
        assert arm.status.commanded == arm.twin.world.motors
        arm.resume()
    handle.wait()
    assert arm.twin.world.motors == goal


def test_a_pause_that_is_over_at_once_holds_up_nothing():
    arm = ready()
    handle = arm.move_j(wait=False, **GOAL)
    for _ in range(20):
        arm.sleep(0.05)
        arm.pause()
        arm.sleep(0.01)
        arm.resume()
    handle.wait()
    assert standing_as_said(arm)
    assert arm.status.underruns == 0


@pytest.mark.parametrize("after_s", [0.08, 0.1, 0.5])
def test_backlash_that_was_to_be_taken_up_is_taken_up_after_the_pause(after_s):
    arm = arm_with_play("grbl", motion={"planned_burst_s": 0.2})
    there = arm.joints.deg["base"]
    arm.move_j(base_deg=there + 8.0)
    handle = arm.move_j(base_deg=there - 8.0, wait=False)
    arm.sleep(after_s)
    arm.pause()
    arm.sleep(1.0)
    assert off_steps(arm) <= 1
    arm.resume()
    handle.wait()
    assert off_steps(arm) <= 1
    assert arm.status.trust is Trust.REFERENCED


def test_an_increment_of_a_jog_that_is_paused_ends_where_it_is():
    for after_s in (0.08, 0.12):
        arm = ready(config(jog_burst_s=0.2))
        arm.nudge(Jog.joint(base=40.0), speed=1.0)
        arm.sleep(after_s)
        DISTURBANCES["two reports lost"](arm)
        arm.pause()
        sent = len(arm.twin.link.motions)
        arm.sleep(2.0)
        assert len(arm.twin.link.motions) == sent
        assert arm.status.state is State.STANDBY
        assert arm.status.commanded == arm.twin.world.motors
        assert 0.0 < arm.joints.deg["base"] < 20.0
        arm.resume()
        arm.move_j(base_deg=0.0)
        assert standing_as_said(arm)


def test_what_is_taken_back_of_the_backlash_is_as_if_it_had_never_been_sent():
    slack = Slack((5, 5))
    slack.refer()
    slack.sends(Motors((9, 0)))
    ahead = slack.ahead
    slack.sends(Motors((-3, 4)))
    slack.takes_back()
    assert slack.ahead == ahead
