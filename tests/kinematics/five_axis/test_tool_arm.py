"""A tool in the fingers: its point is where it is said to be, and the inverse finds it again."""

import math

import pytest
from amounts import every_row
from hypothesis import example, given
from hypothesis import strategies as st
from kinematics_cases import TEACHMOVER as BARE
from kinematics_cases import postures, same_pose

from kinematics import (
    FiveAxisArm,
    Joints,
    KinematicsError,
    Pose,
    Unreachable,
)
from kinematics.five_axis.tool_arm import ToolArm, holding
from kinematics.frames.vectors import cross
from kinematics.geometry import Tool

LENGTHS = st.floats(-80.0, 80.0)
TOOLS = st.builds(Tool, along_mm=st.floats(0.0, 120.0), up_mm=LENGTHS, side_mm=LENGTHS)
POSTURES = postures(BARE)


def test_up_is_up_and_side_is_to_the_right_of_a_level_hand() -> None:
    level = BARE.ik(Pose.of(x_mm=250, y_mm=0, z_mm=150, pitch_deg=0))
    pose = ToolArm(BARE, Tool(along_mm=5, up_mm=20, side_mm=30)).fk(level)
    assert pose.position_mm == pytest.approx((255.0, -30.0, 170.0))
    up, side, along = zip(*BARE.hand_axes(level), strict=True)
    assert cross(up, side) == pytest.approx(along)


def test_a_point_nearer_to_the_axis_than_the_tool_is_refused_with_one_in_reach() -> None:
    arm, seed = ToolArm(BARE, Tool(side_mm=50)), Joints.of(70, 120, -60, -60, 0)
    for z_mm, nearest in ((300, None), (470, Pose.of(x_mm=0, y_mm=-50, z_mm=470, pitch_deg=0))):
        with pytest.raises(Unreachable, match="beside the arm's plane") as refusal:
            arm.ik(Pose.of(x_mm=0, y_mm=-20, z_mm=z_mm, pitch_deg=0), seed)
        nearest = nearest or refusal.value.nearest
        assert same_pose(refusal.value.nearest, nearest)
        assert same_pose(arm.fk(arm.ik(nearest)), nearest, mm=1e-3)


@given(TOOLS, st.floats(0.0, 700.0), st.floats(-math.pi, math.pi), st.floats(-3.0, 3.0))
@example(Tool(side_mm=1.0), 0.0, 0.0, 0.0)
@example(Tool(up_mm=-21.0, side_mm=1.0), 145.0, 0.0, 0.0)
@example(Tool(), 0.0, 2.0, 0.0)
def test_over_the_base_axis_a_pose_is_held_or_refused(
    tool: Tool, z_mm: float, pitch: float, roll: float
) -> None:
    arm = ToolArm(BARE, tool)
    across = abs(tool.up_mm * math.sin(roll) + tool.side_mm * math.cos(roll))
    pose = Pose(across, 0.0, z_mm, pitch, roll)
    try:
        joints = arm.ik(pose)
    except Unreachable as refusal:
        arm.ik(refusal.nearest)
    else:
        assert math.dist(arm.points(joints)[-1], (across, 0.0, z_mm)) < 1e-3


@every_row("turned_deg", [-90, -30, 0, 60])
@every_row("seed_deg", [-90, 0, 40, 90])
def test_fingers_over_the_base_axis_turn_the_base_to_where_the_tool_has_to_be(
    seed_deg: float, turned_deg: float
) -> None:
    arm, seed = ToolArm(BARE, Tool(along_mm=50)), Joints.of(seed_deg, 120, -60, -60, 0)
    x, y = (50 * turn(math.radians(turned_deg)) for turn in (math.cos, math.sin))
    pose = Pose.of(x_mm=x, y_mm=y, z_mm=470, pitch_deg=0)
    for found in (arm.ik(pose, seed), *(one.joints for one in arm.branches(pose, seed))):
        assert same_pose(arm.fk(found), pose)
        assert found.deg["base"] % 180 == pytest.approx(turned_deg % 180, abs=1e-6)


@every_row("pitch_deg, z_mm", [(90, 660), (70, 620)])
@every_row("base_deg", [-80, 0, 30])
def test_a_point_over_the_base_axis_leaves_the_base_where_it_is(
    base_deg: float, pitch_deg: float, z_mm: float
) -> None:
    arm, seed = ToolArm(BARE, Tool(along_mm=50)), Joints.of(base_deg, 90, -40, 40, 0)
    pose = Pose.of(x_mm=0, y_mm=0, z_mm=z_mm, pitch_deg=pitch_deg)
    found = arm.ik(pose, seed)
    assert found.deg["base"] == pytest.approx(base_deg)
    assert math.dist(arm.points(found)[-1], pose.position_mm) < 1e-6


def test_a_tool_is_not_held_twice_and_not_a_kilometre_long() -> None:
    with pytest.raises(KinematicsError, match="already holds"):
        holding(ToolArm(BARE, Tool(1.0)), Tool(1.0))
    with pytest.raises(KinematicsError, match="within 1000 mm"):
        Tool(along_mm=1e6)
    assert isinstance(BARE, FiveAxisArm)
