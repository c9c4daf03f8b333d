"""Goals in the base, the tool and frames of the arm file, driven on simulated arms."""

import math
from dataclasses import replace

import pytest
from faults import ready_arm

from armdrive.connect.target import simulated_config
from armdrive.errors import ArmFileError, BadRequest
from armdrive.motion.frames import axes_of, frame_names
from armdrive.registry.arm_files import parse_arm
from kinematics import Pose
from kinematics.frames.user_frame import UserFrame

BOARD = UserFrame.turned((180.0, 40.0, 30.0), math.radians(30.0))
STEP_MM = 0.6


def framed():
    return replace(simulated_config("teachmover"), frames={"board": BOARD})


def place(pose):
    return pose.x_mm, pose.y_mm, pose.z_mm


def test_a_goal_of_the_board_is_reached_on_the_board():
    with ready_arm(framed()) as arm:
        goal = Pose.of(x_mm=50, y_mm=-20, z_mm=40, pitch_deg=-90)
        arm.move_to(goal, frame="board")
        assert math.dist(place(arm.twin.world.pose), place(BOARD.to_base(goal))) < STEP_MM
        assert math.dist(place(arm.pose_in("board")), place(goal)) < STEP_MM
        arm.move_l(replace(goal, y_mm=0.0), frame="board")
        wanted = BOARD.to_base(replace(goal, y_mm=0.0))
        assert math.dist(place(arm.twin.world.pose), place(wanted)) < STEP_MM


def test_a_goal_of_the_tool_goes_on_as_the_hand_points():
    with ready_arm(framed()) as arm:
        arm.move_to(Pose.of(x_mm=250, y_mm=30, z_mm=120, pitch_deg=-45))
        before, joints = arm.pose, arm.joints
        _, _, along = axes_of(arm.config, joints, "tool")
        arm.move_l(Pose(0.0, 0.0, 25.0, 0.0), frame="tool")
        wanted = [a + 25.0 * b for a, b in zip(place(before), along, strict=True)]
        assert math.dist(place(arm.pose), wanted) < STEP_MM
        assert arm.pose.pitch_deg == pytest.approx(-45.0, abs=0.3)


def test_an_unknown_frame_is_named_and_nothing_moves():
    with ready_arm(framed()) as arm:
        before = arm.twin.world.pose
        with pytest.raises(BadRequest, match="known are base, tool, board"):
            arm.move_to(Pose(0.0, 0.0, 0.0, 0.0), frame="bord")
        assert arm.twin.world.pose == before
    assert frame_names(framed()) == ("base", "tool", "board")


TABLE = {
    "model": "teachmover",
    "tool": {"along_mm": 40.0, "up_mm": 10.0},
    "frames": {"board": {"x_mm": 180.0, "yaw_deg": 30.0}},
}


def test_a_tool_of_the_arm_file_is_what_poses_are_of():
    held = parse_arm(TABLE, name="held")
    bare = parse_arm({"model": "teachmover"}, name="bare")
    joints = bare.model.arm.ik(Pose.of(x_mm=250, y_mm=0, z_mm=150, pitch_deg=0))
    assert place(held.model.arm.fk(joints)) == pytest.approx((290.0, 0.0, 160.0))
    assert held.calibration == bare.calibration  # a remembered position is of the joints


def test_a_tool_is_driven_to_where_its_point_is_wanted():
    config = replace(parse_arm(TABLE, name="held"), connection=framed().connection)
    with ready_arm(config) as arm:
        goal = Pose.of(x_mm=260, y_mm=60, z_mm=120, pitch_deg=-60, roll_deg=20)
        arm.move_l(goal)
        assert math.dist(place(arm.twin.world.pose), place(goal)) < STEP_MM


@pytest.mark.parametrize("name", ["tool", "base", "two words"])
def test_a_frame_needs_a_name_of_its_own(name):
    with pytest.raises(ArmFileError, match="one word"):
        parse_arm({"model": "teachmover", "frames": {name: {}}}, name="x")


def test_links_that_guards_look_at_are_one_more_with_a_tool():
    guards = {"radii_mm": [35.0, 30.0, 25.0], "base_radius_mm": 60.0, "base_top_mm": 150.0}
    table = TABLE | {"guards": guards}
    bare = {key: value for key, value in table.items() if key != "tool"}
    assert len(parse_arm(bare, name="x").model.guards.radii_mm) == 3
    held = parse_arm(table | {"tool": {"along_mm": 40.0, "radius_mm": 8.0}}, name="x")
    assert held.model.guards.radii_mm == (35.0, 30.0, 25.0, 8.0)
