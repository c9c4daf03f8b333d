"""Goals: which turn leads from a hand to what is asked of it, and what is left free."""

import math

import pytest
from frame_cases import rotations
from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import arm_and_posture

from kinematics import KinematicsError, Pose
from kinematics.chains.goals import ALL_PARTS, Part, frame_goal, pose_goal
from kinematics.five_axis.closed_form import forward_frame
from kinematics.frames.rotations import columns, multiply, rot_x, rot_y, rot_z
from kinematics.frames.transforms import transform
from kinematics.frames.vectors import X_AXIS, angle_between, dot, norm

angles = st.floats(-3.0, 3.0)
hands = st.builds(lambda rotation: transform(rotation, (200.0, 50.0, 100.0)), rotations)
free_parts = st.sets(st.sampled_from([Part.HEADING, Part.PITCH, Part.ROLL]))


def hand_of(frame):
    return (frame[0][2], frame[1][2], frame[2][2])


@given(hands, free_parts)
def test_a_hand_at_its_goal_is_asked_nothing(frame, free):
    assert norm(frame_goal(frame, ALL_PARTS - free).turn(frame)[0]) < 1e-7


@given(hands, hands, free_parts)
def test_what_is_wanted_is_a_rotation_that_wants_nothing_more(goal_frame, now, free):
    goal = frame_goal(goal_frame, ALL_PARTS - free)
    wanted = goal.wanted(now)
    x, y, z = columns(wanted)
    assert max(abs(dot(x, y)), abs(dot(y, z)), abs(dot(z, x))) < 1e-9
    assert norm(goal.turn(transform(wanted, (0.0, 0.0, 0.0)))[0]) < 1e-6


@given(hands, hands)
def test_with_the_roll_free_only_the_direction_is_turned(goal_frame, now):
    goal = frame_goal(goal_frame, ALL_PARTS - {Part.ROLL})
    between = angle_between(hand_of(goal_frame), hand_of(now))
    assert norm(goal.turn(now)[0]) == pytest.approx(between, abs=1e-6)
    assert columns(goal.wanted(now))[2] == pytest.approx(hand_of(goal_frame), abs=1e-12)


@given(hands, hands)
def test_with_all_asked_the_goal_s_own_rotation_is_wanted(goal_frame, now):
    wanted = frame_goal(goal_frame).wanted(now)
    assert transform(wanted, (200.0, 50.0, 100.0)) == goal_frame


@given(arm_and_posture)
def test_a_pose_asks_for_the_hand_that_the_arm_gives_it(case):
    arm, joints = case
    pose = arm.fk(joints)
    if math.hypot(pose.x_mm, pose.y_mm) < 1.0:
        return
    hand = forward_frame(joints.angles_rad, arm.lengths)
    goal = pose_goal(pose)
    assert norm(goal.turn(hand)[0]) < 1e-6
    assert math.dist(*([row[3] for row in one] for one in (goal.frame, hand))) < 1e-9


@given(arm_and_posture, st.floats(-1.0, 1.0))
def test_a_free_pitch_or_roll_may_be_anything(case, change):
    arm, joints = case
    pose = arm.fk(joints)
    if math.hypot(pose.x_mm, pose.y_mm) < 1.0:
        return
    base, shoulder, elbow, wrist, roll = joints.angles_rad
    pitched = forward_frame((base, shoulder, elbow, wrist + change, roll), arm.lengths)
    rolled = forward_frame((base, shoulder, elbow, wrist, roll + change), arm.lengths)
    assert norm(pose_goal(pose, pitch_free=True).turn(pitched)[0]) < 1e-6
    assert norm(pose_goal(pose, roll_free=True).turn(rolled)[0]) < 1e-6
    assert norm(pose_goal(pose).turn(rolled)[0]) == pytest.approx(abs(change), abs=1e-6)


@given(angles, st.floats(-3.0, 3.0), st.floats(-1.5, 1.5))
def test_on_the_base_axis_the_plane_is_free(base, pitch, roll):
    goal = pose_goal(Pose(0.0, 0.0, 500.0, pitch, roll))
    assert Part.HEADING not in goal.parts
    # a hand in any plane through the axis, with this pitch and roll in it
    hand = forward_frame((base, 0.0, 0.0, pitch, roll), (0.0, 1.0, 1.0, 0.0))
    if abs(math.cos(pitch)) > 1e-3:
        assert norm(goal.turn(hand)[0]) < 1e-6


def test_the_misses_are_named_by_axes():
    level = transform(rot_y(math.pi / 2), (300.0, 0.0, 100.0))  # the hand points along x
    goal = frame_goal(level)
    for part, turn in (
        (Part.ROLL, rot_x(0.1)),
        (Part.PITCH, rot_y(0.1)),
        (Part.HEADING, rot_z(0.1)),
    ):
        now = transform(multiply(turn, rot_y(math.pi / 2)), (300.0, 0.0, 100.0))
        misses = {one: abs(miss) for one, _, miss in goal.turn(now)[1]}
        assert misses[part] == pytest.approx(0.1)
        assert sum(misses.values()) == pytest.approx(0.1)


def test_a_vertical_hand_takes_its_plane_from_the_place():
    down = transform(rot_x(math.pi), (0.0, 250.0, 100.0))
    assert frame_goal(down).outwards == (0.0, 1.0, 0.0)
    assert frame_goal(transform(rot_x(math.pi), (0.0, 0.0, 9.0))).outwards == X_AXIS


def test_a_goal_of_nothing_is_refused():
    with pytest.raises(KinematicsError, match="asks at least one of position, heading"):
        frame_goal(transform(rot_x(0.0), (0.0, 0.0, 0.0)), frozenset())
