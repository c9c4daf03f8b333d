"""The reachable pose nearest to a goal."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import (
    ARMS,
    TEACHMOVER,
    UNEVEN,
    any_arm,
    arm_and_posture,
    distance_mm,
    goals,
    same_pose,
    turn_between,
)

from kinematics import FiveAxisArm, JointRange, Joints, Pose
from kinematics.five_axis.nearest import nearest


@given(any_arm, goals)
def test_the_answer_can_be_reached_and_is_as_far_as_it_says(arm, goal):
    found = nearest(arm, goal)
    solved = arm.ik(found.pose)
    assert same_pose(arm.fk(solved), found.pose, mm=1e-4)
    assert not arm.violations(found.joints)
    assert same_pose(arm.fk(found.joints), found.pose)
    assert found.distance_mm == pytest.approx(distance_mm(found.pose, goal), abs=1e-9)


@given(arm_and_posture)
def test_a_pose_in_reach_is_its_own_nearest(case):
    arm, joints = case
    pose = arm.fk(joints)
    assert nearest(arm, pose, joints).distance_mm < 1e-4


def postures_like(arm, goal, seed, count):
    """Random postures within limits whose pose has the goal's pitch and roll."""
    chance = random.Random(seed)
    for _ in range(count):
        base, shoulder, elbow = (
            chance.uniform(bounds.low_rad, bounds.high_rad) for bounds in arm.limits[:3]
        )
        back = chance.random() < 0.5
        pitch = math.pi - goal.pitch_rad if back else goal.pitch_rad
        roll = goal.roll_rad + math.pi * back
        wrist = math.remainder(pitch - shoulder - elbow, math.tau)
        for turn in (0.0, math.tau, -math.tau):
            joints = Joints((base, shoulder, elbow, wrist, math.remainder(roll, math.tau) + turn))
            pose = arm.fk(joints)
            if (
                not arm.violations(joints)
                and turn_between(pose.pitch_rad, goal.pitch_rad) < 1e-9
                and turn_between(pose.roll_rad, goal.roll_rad) < 1e-9
            ):
                yield pose
                break


@given(any_arm, goals, st.integers(0, 2**32))
def test_no_posture_of_that_pitch_and_roll_is_nearer(arm, goal, seed):
    found = nearest(arm, goal)
    for pose in postures_like(arm, goal, seed, 60):
        assert distance_mm(pose, goal) >= found.distance_mm - 1e-4
        assert found.pose.pitch_rad == goal.pitch_rad
        assert found.pose.roll_rad == goal.roll_rad


@given(arm_and_posture, st.integers(0, 2**32), st.floats(0.0, 30.0))
def test_no_posture_close_to_the_answer_is_nearer(case, seed, push):
    """Goals just outside the reach, and random postures beside the answer's own."""
    arm, joints = case
    pose = arm.fk(joints)
    goal = Pose(
        pose.x_mm * 1.3 + push, pose.y_mm * 1.3, pose.z_mm - push, pose.pitch_rad, pose.roll_rad
    )
    found = nearest(arm, goal)
    chance = random.Random(seed)
    for _ in range(60):
        size = 10.0 ** chance.uniform(-6, -1)
        base, shoulder, elbow, _, _ = (
            bounds.clamp(angle + chance.uniform(-size, size))
            for angle, bounds in zip(found.joints, arm.limits, strict=True)
        )
        wrist = sum(found.joints.angles_rad[1:4]) - shoulder - elbow
        beside = Joints((base, shoulder, elbow, wrist, found.joints[4]))
        pose = arm.fk(beside)
        if not arm.violations(beside) and turn_between(pose.pitch_rad, goal.pitch_rad) < 1e-6:
            assert distance_mm(pose, goal) >= found.distance_mm - 1e-4


@pytest.mark.parametrize(
    ("goal", "expected"),
    [
        (Pose(600, 0, 193.7, 0), Pose(452.1, 0, 193.7, 0)),
        (Pose(0, 600, 193.7, 0), Pose(0, 452.1, 193.7, 0)),
        (
            Pose.of(x_mm=0, y_mm=0, z_mm=900, pitch_deg=90),
            Pose.of(x_mm=0, y_mm=0, z_mm=645.8, pitch_deg=90),
        ),
    ],
)
def test_beyond_full_stretch_the_nearest_is_full_stretch(goal, expected):
    assert same_pose(nearest(TEACHMOVER, goal).pose, expected)


def test_a_pitch_that_no_posture_holds_becomes_the_nearest_that_one_does():
    stiff = FiveAxisArm(
        195, 177.8, 177.8, 96.5, tuple(JointRange.of(a, a + 20) for a in (-10, 0, -20, -10, -10))
    )
    goal = Pose.of(x_mm=400, y_mm=0, z_mm=200, pitch_deg=100)
    found = nearest(stiff, goal)
    assert found.pose.pitch_deg == pytest.approx(30, abs=1e-6)
    assert found.joints.deg["shoulder"] == pytest.approx(20, abs=1e-6)
    assert same_pose(stiff.fk(stiff.ik(found.pose)), found.pose, mm=1e-4)
    below = nearest(stiff, Pose.of(x_mm=400, y_mm=0, z_mm=200, pitch_deg=-100))
    assert below.pose.pitch_deg == pytest.approx(-30, abs=1e-6)


def test_a_roll_out_of_range_becomes_the_nearest_in_range():
    goal = Pose.of(x_mm=250, y_mm=0, z_mm=100, pitch_deg=0, roll_deg=175)
    behind_is_shut = FiveAxisArm(
        *UNEVEN.lengths,
        (
            JointRange.of(-60, 60),
            JointRange.of(-35, 90),
            *UNEVEN.limits[2:4],
            JointRange.of(-100, 70),
        ),
    )
    found = nearest(behind_is_shut, goal)
    assert found.pose.pitch_rad == goal.pitch_rad
    assert found.joints.deg["wrist_roll"] in (pytest.approx(-100), pytest.approx(-5))
    assert not behind_is_shut.violations(found.joints)


@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize("z_mm", [-200.0, 0.0, 150.0, 400.0, 700.0])
def test_goals_on_the_base_axis_have_a_nearest_pose(arm, z_mm):
    seed = Joints.of(30, 60, -60, 0, 0)
    found = nearest(arm, Pose.of(x_mm=0, y_mm=0, z_mm=z_mm, pitch_deg=-45), seed)
    solved = arm.ik(found.pose, seed)
    assert same_pose(arm.fk(solved), found.pose, mm=1e-4)


def facing_forward(elbow):
    """The TeachMover's links, a base of a third of a turn, and a roll that keeps it in front."""
    full = JointRange.of(-180, 180)
    return FiveAxisArm(
        *TEACHMOVER.lengths, (JointRange.of(-60, 60), full, elbow, full, JointRange.of(-30, 30))
    )


def test_a_goal_behind_an_arm_that_must_face_forward_is_met_at_the_base_axis():
    arm = facing_forward(JointRange.of(-180, 180))
    found = nearest(arm, Pose(-100, 0, 300, 0.3))
    assert same_pose(found.pose, Pose(0, 0, 300, 0.3))
    assert found.distance_mm == pytest.approx(100)


def test_where_the_goals_height_is_not_on_the_axis_the_arm_stops_where_it_crosses_the_axis():
    arm = facing_forward(JointRange.of(-90, -90))
    span = 177.8 * math.sqrt(2)
    height = 193.7 + math.sqrt(span**2 - 96.5**2)  # the elbow is rigid: the wrist is on a circle
    found = nearest(arm, Pose(-300, 0, 293.7, 0))
    assert same_pose(found.pose, Pose(0, 0, height, 0))
    assert same_pose(arm.fk(arm.ik(found.pose)), found.pose, mm=1e-4)
