"""Goals given as a full frame: met, or flagged with the angle by which five axes miss them."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from kinematics_cases import TEACHMOVER, UNEVEN, arm_and_posture, same_pose

from kinematics import Joints
from kinematics.five_axis.closed_form import ON_MANIFOLD_RAD
from kinematics.frames.rotations import multiply, rot_x, rot_y, rot_z, transpose
from kinematics.frames.transforms import compose, position_of, rotation_of, transform

HALF = math.pi / 2


def dh_frame(arm, q):
    """The product of five A matrices, the links turned and moved one by one."""
    rows = (
        (q[0], arm.base_height_mm, 0.0, HALF),
        (q[1], 0.0, arm.upper_arm_mm, 0.0),
        (q[2], 0.0, arm.forearm_mm, 0.0),
        (q[3] + HALF, 0.0, 0.0, HALF),
        (q[4], arm.hand_mm, 0.0, 0.0),
    )
    return compose(
        *(
            compose(transform(rot_z(theta), (0.0, 0.0, d)), transform(rot_x(alpha), (a, 0.0, 0.0)))
            for theta, d, a, alpha in rows
        )
    )


def turn_of(matrix):
    """The angle of a rotation, exact for small ones too."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return math.atan2(math.hypot(h - f, c - g, d - b), a + e + i - 1.0)


def apart(a, b):
    """Distance in mm and angle in rad between two frames."""
    turn = multiply(transpose(rotation_of(a)), rotation_of(b))
    return math.dist(position_of(a), position_of(b)), turn_of(turn)


@given(arm_and_posture)
def test_the_hands_frame_is_the_product_of_the_link_matrices(case):
    arm, joints = case
    for ours, theirs in zip(arm.transform(joints), dh_frame(arm, joints), strict=True):
        assert ours == pytest.approx(theirs, abs=1e-9)


@given(arm_and_posture)
def test_every_frame_of_the_arm_is_met_by_a_posture_that_holds_it(case):
    arm, joints = case
    goal = arm.transform(joints)
    found = arm.solve_transform(goal, joints)
    assert found.met
    distance, turn = apart(arm.transform(found.joints), goal)
    assert distance < 1e-4
    assert turn < 1e-5


@given(arm_and_posture)
def test_the_pose_of_a_frame_is_the_posture_s_pose(case):
    arm, joints = case
    pose = arm.fk(joints)
    assume(math.hypot(pose.x_mm, pose.y_mm) > 1.0)
    assert same_pose(arm.solve_transform(arm.transform(joints)).pose, pose)


@given(arm_and_posture, st.floats(-1.5, 1.5))
def test_a_hand_turned_out_of_the_plane_is_flagged_with_the_angle(case, turn):
    arm, joints = case
    level = arm.transform(joints.replace(wrist_pitch=-joints[1] - joints[2]))
    assume(math.hypot(*position_of(level)[:2]) > 1.0)
    normal_turn = multiply(rot_z(joints[0]), rot_z(turn), rot_z(-joints[0]))
    goal = transform(multiply(normal_turn, rotation_of(level)), position_of(level))
    found = arm.solve_transform(goal, joints)
    assert found.off_manifold_rad == pytest.approx(abs(turn), abs=1e-7)
    assert found.on_manifold == (found.off_manifold_rad <= ON_MANIFOLD_RAD)
    if found.joints is not None:
        distance, missed = apart(arm.transform(found.joints), goal)
        assert distance < 1e-4
        assert missed == pytest.approx(abs(turn), abs=1e-5)


@given(
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    st.floats(100.0, 300.0),
    st.floats(-3.0, 3.0),
    st.floats(0.0, 300.0),
)
def test_no_other_pitch_or_roll_is_nearer_to_a_frame_off_the_manifold(turns, r, base, z):
    a, b, c = turns
    place = r * math.cos(base), r * math.sin(base), z
    goal = transform(multiply(rot_z(a), rot_y(b), rot_x(c)), place)
    found = UNEVEN.solve_transform(goal)
    assume(found.joints is not None and found.off_manifold_rad < 1.5)
    _, least = apart(UNEVEN.transform(found.joints), goal)
    nudges = [(d, e) for d in (-0.01, 0.0, 0.01) for e in (-0.01, 0.0, 0.01)]
    for pitch, roll in nudges:
        q = found.joints.angles_rad
        frame = UNEVEN.transform(Joints((*q[:3], q[3] + pitch, q[4] + roll)))
        turned = multiply(transpose(rotation_of(frame)), rotation_of(goal))
        assert turn_of(turned) >= least - 1e-7


def test_on_the_base_axis_the_hand_gives_the_base():
    _, upper, fore, hand = TEACHMOVER.lengths
    steep = Joints.of(37, 120, -50, 0, 20)
    wrist_r = upper * math.cos(steep[1]) + fore * math.cos(steep[1] + steep[2])
    steep = steep.replace(wrist_pitch=math.acos(-wrist_r / hand) - steep[1] - steep[2])
    goal = TEACHMOVER.transform(steep)
    assert math.hypot(*position_of(goal)[:2]) < 1e-9
    found = TEACHMOVER.solve_transform(goal)
    assert found.met
    assert not found.base_free
    assert apart(TEACHMOVER.transform(found.joints), goal) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_a_vertical_hand_on_the_base_axis_takes_the_seeds_base():
    goal = TEACHMOVER.transform(Joints.of(0, 90, 0, 0, 30))
    found = TEACHMOVER.solve_transform(goal, Joints.of(40, 80, -10, 10, 0))
    assert found.met
    assert found.base_free
    assert found.joints.deg["base"] == pytest.approx(40)
    assert apart(TEACHMOVER.transform(found.joints), goal) == pytest.approx((0.0, 0.0), abs=1e-4)


def test_out_of_reach_is_no_posture_and_still_says_the_pose():
    found = TEACHMOVER.solve_transform(transform(rot_y(HALF), (900.0, 0.0, 100.0)))
    assert found.joints is None
    assert not found.met
    assert found.pose.x_mm == 900.0


@given(arm_and_posture)
def test_solving_a_frame_turned_about_its_axis_changes_only_the_roll(case):
    arm, joints = case
    goal = arm.transform(joints)
    turned = transform(multiply(rotation_of(goal), rot_z(0.3)), position_of(goal))
    a, b = arm.solve_transform(goal).pose, arm.solve_transform(turned).pose
    assert math.remainder(b.roll_rad - a.roll_rad - 0.3, math.tau) == pytest.approx(0, abs=1e-6)
