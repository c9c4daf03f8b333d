"""Joint motions, straight lines, and guards along them."""

import math

import pytest
from amounts import every_row
from kinematics_cases import TEACHMOVER, UNEVEN, same_pose, turn_between
from route_cases import START as FRONT
from route_cases import pose

from kinematics import (
    Guards,
    JointPath,
    Joints,
    PathBroken,
    Pose,
    first_violation,
    line_path,
)


def test_a_joint_path_turns_every_joint_in_proportion_and_ends_exactly():
    start, goal = Joints.of(0, 10, -20, 30, 40), Joints.of(90, 20, -40, 0, 40)
    path = JointPath(start, goal)
    assert path.at(0.0) == start
    assert path.at(1.0) == goal
    assert tuple(path.at(0.25).deg.values()) == pytest.approx((22.5, 12.5, -25, 22.5, 40))
    assert path.changes_rad[0] == pytest.approx(math.pi / 2)


def test_pitch_and_roll_change_in_proportion_to_the_way():
    goal = pose(300, 80, 220, 0, 170)
    waypoints = line_path(TEACHMOVER, FRONT, goal)
    origin = TEACHMOVER.fk(FRONT)
    for joints in waypoints[1:]:
        here = TEACHMOVER.fk(joints)
        share = (here.x_mm - origin.x_mm) / (goal.x_mm - origin.x_mm)
        assert here.pitch_deg == pytest.approx(-90 + 90 * share, abs=1e-6)
        assert here.roll_deg == pytest.approx(170 * share, abs=1e-6)


def test_roll_takes_the_shorter_way_unless_the_range_forbids_it():
    start = UNEVEN.ik(pose(200, 0, 150, 0, 150))
    start = start.replace(wrist_roll=math.radians(150))
    goal = pose(200, 50, 150, 0, -150)
    assert line_path(UNEVEN, start, goal)[-1].deg["wrist_roll"] == pytest.approx(-150)
    free = FRONT.replace(wrist_roll=math.radians(150))
    goal = pose(250, 0, 120, -90, -150)
    assert line_path(TEACHMOVER, free, goal)[-1].deg["wrist_roll"] == pytest.approx(210)


@every_row(
    "goal, reason",
    [
        (pose(600, 100, 300, -20), "355.6 mm that the arm spans"),
        (pose(60, 0, 120), "elbow would pass its limit of -149"),
    ],
)
def test_a_line_that_leaves_the_reach_says_where_and_why(goal, reason):
    with pytest.raises(PathBroken, match=reason) as caught:
        line_path(TEACHMOVER, FRONT, goal)
    broken = caught.value
    assert 0.0 < broken.fraction < 1.0
    origin = TEACHMOVER.fk(FRONT)
    assert broken.point.x_mm == pytest.approx(
        origin.x_mm + broken.fraction * (goal.x_mm - origin.x_mm)
    )
    before = Pose(
        *(
            a + 0.999 * broken.fraction * (b - a)
            for a, b in (
                (origin.x_mm, goal.x_mm),
                (origin.y_mm, goal.y_mm),
                (origin.z_mm, goal.z_mm),
                (origin.pitch_rad, goal.pitch_rad),
            )
        )
    )
    assert same_pose(TEACHMOVER.fk(line_path(TEACHMOVER, FRONT, before)[-1]), before, mm=1e-4)
    assert TEACHMOVER.solve(broken.point, FRONT) is None


def test_a_line_through_the_base_axis_is_broken_there():
    start = UNEVEN.ik(Pose(100, 0, 350, 0.5))
    with pytest.raises(PathBroken, match="the base would have to turn by 180° at once") as caught:
        line_path(UNEVEN, start, Pose(-100, 0, 350, 0.5))
    assert caught.value.fraction == pytest.approx(0.5, abs=1e-4)
    assert caught.value.point.x_mm == pytest.approx(0, abs=0.05)


def test_lines_on_to_and_along_the_base_axis_keep_the_base():
    start = TEACHMOVER.ik(Pose(100, 0, 470, 0))
    on_axis = line_path(TEACHMOVER, start, Pose(0, 0, 470, 0))
    assert {joints["base"] for joints in on_axis} == {0.0}
    up = line_path(TEACHMOVER, on_axis[-1], Pose(0, 0, 490, 0))
    assert same_pose(TEACHMOVER.fk(up[-1]), Pose(0, 0, 490, 0))
    back = line_path(TEACHMOVER, on_axis[-1], Pose(100, 0, 470, 0))
    assert back[-1].angles_rad == pytest.approx(start.angles_rad)
    with pytest.raises(PathBroken, match="meets the base axis") as caught:
        line_path(TEACHMOVER, on_axis[-1], Pose(0, 100, 470, 0))
    assert caught.value.fraction < 1e-4


@every_row("elbow_deg", [-70.0, 70.0])
def test_a_line_keeps_the_elbow_that_it_starts_with(elbow_deg):
    start = Joints.of(10, 20, elbow_deg, -15, 0)
    pose = UNEVEN.fk(start)
    goal = Pose(pose.x_mm - 20, pose.y_mm + 40, pose.z_mm + 10, pose.pitch_rad, pose.roll_rad)
    waypoints = line_path(UNEVEN, start, goal)
    assert same_pose(UNEVEN.fk(waypoints[-1]), goal, mm=1e-4)
    assert all(each["elbow"] * elbow_deg > 0.0 for each in waypoints)


def test_a_line_behind_the_base_axis_stays_behind():
    start = TEACHMOVER.ik(TEACHMOVER.fk(Joints.of(0, 130, -20, 0, 180)), Joints.of(0, 130, 0, 0, 0))
    origin = TEACHMOVER.fk(start)
    assert origin.x_mm < 0
    goal = Pose(origin.x_mm, origin.y_mm + 30, origin.z_mm - 5, origin.pitch_rad, origin.roll_rad)
    waypoints = line_path(TEACHMOVER, start, goal)
    assert same_pose(TEACHMOVER.fk(waypoints[-1]), goal, mm=1e-4)
    assert turn_between(waypoints[-1]["base"], start["base"]) < 0.5


def test_a_joint_that_starts_beyond_its_limit_may_only_come_back():
    start = Joints.of(90.5, 40, -80, -20, 0)
    pose = TEACHMOVER.fk(start)
    r = math.hypot(pose.x_mm, pose.y_mm)

    def turned(base_deg):
        base = math.radians(base_deg)
        return Pose(r * math.cos(base), r * math.sin(base), pose.z_mm, pose.pitch_rad)

    assert line_path(TEACHMOVER, start, turned(70))[-1].deg["base"] == pytest.approx(70)
    with pytest.raises(PathBroken, match=r"base would pass its limit of 90\.5"):
        line_path(TEACHMOVER, start, turned(92))


def test_a_path_through_the_body_is_found_though_its_ends_are_free():
    arm, guards = UNEVEN, Guards(outer_radius_mm=None)
    start, goal = (Joints.of(base, 40, -60, 0, 0) for base in (-10, 10))
    folded = Joints.of(0, 120, -149, -90, 0)
    assert guards.violation(arm, folded) is not None
    assert first_violation(arm, guards, (start, goal)) is None
    fraction, violation = first_violation(arm, guards, (start, folded, goal))
    assert 0.0 < fraction < 1.0
    assert violation.guard == "inner radius"
    assert violation.excess_mm <= 2.0
    assert first_violation(arm, guards, (folded, goal))[0] < 0.01  # it first leads further in
