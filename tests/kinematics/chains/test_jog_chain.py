"""The quick solver of chains for jogs: it holds the pose, stays near and within the limits."""

import dataclasses
import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from kinematics.chains.arm import ChainArm
from kinematics.errors import KinematicsError
from kinematics.frames.transforms import translation
from kinematics.presets import preset
from kinematics.spaces import Joints
from kinematics.textbook.systems import system

MINI = ChainArm(system("minimover5").chain())
PUMA = ChainArm(dataclasses.replace(system("puma").chain(), base=translation(0.0, 0.0, 660.0)))
FIVE = preset("minimover5").arm
STEPS = st.tuples(*[st.floats(-2.0, 2.0)] * 3)


def postures(arm):
    spans = [(one.low_rad + 0.1, one.high_rad - 0.1) for one in arm.limits]
    return st.tuples(*[st.floats(max(low, -3.0), min(high, 3.0)) for low, high in spans]).map(
        lambda angles: Joints(angles, arm.joint_names)
    )


def moved(pose, step):
    x, y, z = step
    return dataclasses.replace(pose, x_mm=pose.x_mm + x, y_mm=pose.y_mm + y, z_mm=pose.z_mm + z)


@settings(max_examples=40, deadline=None)
@given(st.sampled_from([MINI, PUMA]), st.data(), STEPS)
def test_a_small_step_is_met_exactly_and_within_the_limits_or_not_at_all(arm, data, step):
    seed = data.draw(postures(arm))
    goal = moved(arm.fk(seed), step)
    found = arm.solve_near(goal, seed)
    if found is None:
        return
    made = arm.fk(found)
    gap_mm = math.dist((made.x_mm, made.y_mm, made.z_mm), (goal.x_mm, goal.y_mm, goal.z_mm))
    assert gap_mm < 1e-5
    assert math.remainder(made.pitch_rad - goal.pitch_rad, math.tau) == pytest.approx(0, abs=1e-6)
    assert arm.violations(found) == ()


@settings(max_examples=40, deadline=None)
@given(postures(MINI), STEPS)
def test_a_link_table_of_the_build_is_solved_as_its_closed_form(joints, step):
    assume(abs(math.sin(joints[2])) > 0.2)
    goal = moved(FIVE.fk(joints), step)
    assume(math.hypot(goal.x_mm, goal.y_mm) > 60.0)
    expected = FIVE.solve(goal, joints)
    assume(expected is not None and math.dist(expected, joints) < 0.3)
    found = MINI.solve_near(goal, joints)
    assert found is not None
    assert tuple(found) == pytest.approx(tuple(expected), abs=1e-6)


def test_beyond_the_reach_or_a_limit_there_is_nothing():
    straight = Joints((0.0, 0.3, 0.0, 0.0, 0.0), MINI.joint_names)
    assert MINI.solve_near(moved(MINI.fk(straight), (20.0, 0.0, 5.0)), straight) is None
    turned = Joints((math.pi / 2, 0.7, -1.4, -0.7, 0.0), MINI.joint_names)
    assert MINI.solve_near(moved(MINI.fk(turned), (-5.0, 0.0, 0.0)), turned) is None
    assert FIVE.solve_near(moved(FIVE.fk(straight), (20.0, 0.0, 5.0)), straight) is None


def test_a_straight_elbow_can_be_left():
    straight = Joints((0.0, 0.3, 0.0, 0.0, 0.0), MINI.joint_names)
    found = MINI.solve_near(moved(MINI.fk(straight), (-0.5, 0.0, 0.0)), straight)
    assert found is not None
    assert found[2] < -0.05


def test_a_pose_of_other_axes_is_none_of_this_arm():
    seed, pose = Joints((0.0,) * 6, PUMA.joint_names), FIVE.fk(Joints((0.0, 0.7, -1.4, -0.7, 0.0)))
    with pytest.raises(KinematicsError):
        PUMA.goal(pose)
    assert PUMA.solve_near(pose, seed) is None
