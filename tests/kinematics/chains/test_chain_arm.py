"""Arms driven by their link tables: the five-axis arm's answers, and laws of six joints."""

import dataclasses
import math

import pytest
from chain_cases import gap
from hypothesis import assume, given
from hypothesis import strategies as st
from kinematics_cases import (
    MINI,
    PUMA,
    START,
    TABLE,
    deviation_mm,
    distance_mm,
    same_pose,
)
from named_arms import calibrated

from kinematics import (
    Joints,
    Pose,
    first_violation,
    line_path,
    nearest_allowed,
    preset,
)
from kinematics.chains.arm import ChainArm
from kinematics.chains.goals import HandTask, goal_of, pose_of
from kinematics.five_axis.tool_arm import Tool, holding
from kinematics.frames.rotations import multiply, transpose
from kinematics.frames.transforms import rotation_of
from kinematics.paths.curves import straight_line

FIVE = preset("minimover5").arm
STEPS = st.tuples(*[st.floats(-2.0, 2.0)] * 3)
MEASURED = ChainArm(calibrated(MINI.chain, 1e-4))
"""No closed form of an arm as it was measured is exact, so that a small step is a descent."""
EITHER = pytest.mark.parametrize("arm", [MINI, MEASURED], ids=["closed form", "descent"])


def moved(pose, step):
    x, y, z = step
    return dataclasses.replace(pose, x_mm=pose.x_mm + x, y_mm=pose.y_mm + y, z_mm=pose.z_mm + z)


def postures(arm, margin=0.02):
    return st.tuples(
        *(st.floats(one.low_rad + margin, one.high_rad - margin) for one in arm.limits)
    ).map(arm.joints_of)


@given(postures(MINI))
def test_a_mini_mover_by_its_link_table_is_the_five_axis_arm(joints):
    ours, theirs = MINI.fk(joints), FIVE.fk(joints)
    if math.hypot(theirs.x_mm, theirs.y_mm) > 0.1:
        assert same_pose(ours, theirs, mm=1e-9, rad=1e-9)
        assert ours.yaw_rad is None
    for a, b in zip(MINI.points(joints), FIVE.points(joints), strict=True):
        assert math.dist(a, b) < 1e-9
    # about the shoulder the table counts the distance from its axis, as the fast arm does
    for a, b in zip(MINI.levers_mm(joints), FIVE.levers_mm(joints), strict=True):
        assert math.isclose(a, b, abs_tol=1e-5)
    assert MINI.travel_bound_mm((1, 2, 3, 4, 5)) == pytest.approx(
        FIVE.travel_bound_mm((1, 2, 3, 4, 5))
    )
    for a, b in zip(TABLE.violations(MINI, joints), TABLE.violations(FIVE, joints), strict=True):
        assert math.isclose(a.value, b.value, abs_tol=1e-9)


@given(postures(MINI))
def test_a_tool_in_the_hand_of_a_link_table_is_where_the_five_axis_arms_is(joints):
    """A tool that the roll swings out of the arm's plane leaves pitches up to 90 degrees."""
    for tool in (Tool(along_mm=60.0), Tool(along_mm=60.0, up_mm=12.0, side_mm=-7.0)):
        ours, theirs = holding(MINI, tool), holding(FIVE, tool)
        pose = theirs.fk(joints)
        assume(math.hypot(pose.x_mm, pose.y_mm) > 0.1)
        if not tool.up_mm or abs(pose.pitch_rad) < math.pi / 2.0 - 0.01:
            assert same_pose(ours.fk(joints), pose, mm=1e-9, rad=1e-9)
        assert distance_mm(ours.fk(joints), pose) < 1e-9
        found = ours.ik(ours.fk(joints), joints)
        assert distance_mm(theirs.fk(found), pose) < 1e-3


@given(postures(PUMA))
def test_a_pose_and_its_frame_are_one(joints):
    frame = PUMA.chain.fk(joints.angles_rad)
    pose = pose_of(frame, HandTask.WHOLE, (0.0, 0.0, 660.0))
    again = goal_of(pose, HandTask.WHOLE, (0.0, 0.0, 660.0)).frame
    assert gap(again, frame) < 1e-9


def test_a_straight_line_of_six_joints_stays_straight_and_turns_the_hand_evenly():
    here = PUMA.fk(START)
    goal = dataclasses.replace(moved(here, (-80.0, 150.0, 0.0)), yaw_rad=here.yaw_rad + 0.6)
    way = line_path(PUMA, START, goal)
    assert deviation_mm(PUMA, way, goal) <= 0.5
    assert way[0] == START
    line = straight_line(PUMA, START, goal)
    end = line.pose(1.0)
    assert end.position_mm == goal.position_mm
    angles = (end.pitch_rad, end.roll_rad, end.yaw_rad)
    assert angles == pytest.approx((goal.pitch_rad, goal.roll_rad, goal.yaw_rad), abs=1e-12)
    half = PUMA.goal(line.pose(0.5)).frame
    turns = [
        multiply(transpose(rotation_of(a)), rotation_of(b))
        for a, b in (
            (PUMA.chain.fk(START.angles_rad), half),
            (half, PUMA.goal(goal).frame),
        )
    ]
    for first, second in zip(*turns, strict=True):
        assert first == pytest.approx(second, abs=1e-9)


def test_the_table_is_kept_by_every_point_and_left_upwards():
    low = Pose.of(x_mm=500, y_mm=0, z_mm=-60, pitch_deg=-60, yaw_deg=0)
    joints = PUMA.ik(low, START)
    broken = TABLE.violations(PUMA, joints)
    assert "tip z" in [one.quantity for one in broken]
    allowed = nearest_allowed(PUMA, TABLE, low, START)
    assert allowed is not None
    assert allowed.z_mm == pytest.approx(0.0, abs=0.01)
    found = first_violation(PUMA, TABLE, [START, joints])
    assert found is not None
    assert 0.0 < found[0] <= 1.0


# The quick solver for jogs: it holds the pose, stays near and within the limits.


@EITHER
def test_beyond_the_reach_or_a_limit_there_is_nothing(arm):
    straight = Joints((0.0, 0.3, 0.0, 0.0, 0.0))
    turned = Joints((math.pi / 2, 0.7, -1.4, -0.7, 0.0))
    assert arm.solve_near(moved(arm.fk(straight), (20.0, 0.0, 5.0)), straight) is None
    assert arm.solve_near(moved(arm.fk(turned), (-5.0, 0.0, 0.0)), turned) is None
    assert FIVE.solve_near(moved(FIVE.fk(straight), (20.0, 0.0, 5.0)), straight) is None


@EITHER
def test_a_straight_elbow_can_be_left(arm):
    straight = Joints((0.0, 0.3, 0.0, 0.0, 0.0))
    found = arm.solve_near(moved(arm.fk(straight), (-0.5, 0.0, 0.0)), straight)
    assert found is not None
    assert found[2] < -0.05
