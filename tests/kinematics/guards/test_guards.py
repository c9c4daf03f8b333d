"""Guards on postures, and the nearest pose outside them."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import LOOSE, TEACHMOVER, distance_mm, goals, postures, same_pose

from kinematics import Guards, Joints, Pose, nearest_allowed

GUARDS = Guards()


def at(x_mm, z_mm, pitch_deg, elbow="up", arm=LOOSE):
    pose = Pose.of(x_mm=x_mm, y_mm=0, z_mm=z_mm, pitch_deg=pitch_deg)
    for branch in arm.branches(pose):
        if branch.base.value == "front" and branch.elbow.value == elbow:
            return branch.joints
    raise AssertionError("not in reach")


def test_a_posture_in_the_open_breaks_nothing():
    assert GUARDS.violation(LOOSE, at(250, 120, -90)) is None
    assert GUARDS.depth_mm(LOOSE, at(250, 120, -90)) == 0.0


@pytest.mark.parametrize(("z_mm", "broken"), [(0.0, False), (-0.9, False), (-1.1, True)])
def test_the_table_has_a_tolerance(z_mm, broken):
    violation = GUARDS.violation(LOOSE, at(250, z_mm, -90))
    assert (violation is not None) == broken


def test_below_the_table_says_which_point_and_how_deep():
    violation = GUARDS.violation(LOOSE, at(250, -12, -90))
    assert (violation.guard, violation.quantity) == ("table", "tip z")
    assert (violation.value_mm, violation.bound_mm) == (pytest.approx(-12), 0.0)
    assert violation.excess_mm == pytest.approx(12)
    assert violation.sentence == "the tip would be 12.0 mm below the table"


def test_the_wrist_and_the_elbow_are_kept_above_the_table_too():
    hand_up = GUARDS.violation(LOOSE, at(250, 60, 90))
    assert hand_up.quantity == "wrist z"
    low = Joints.of(0, -90, 60, 30, 0)
    arm = replace(LOOSE, base_height_mm=150.0)
    assert "elbow z" in {broken.quantity for broken in GUARDS.violations(arm, low)}


@pytest.mark.parametrize(
    ("x_mm", "z_mm", "broken"),
    [(56, 300, True), (58, 300, False), (57, 300, False), (40, 380, True), (40, 382, False)],
)
def test_the_body_is_kept_clear(x_mm, z_mm, broken):
    violation = GUARDS.violation(LOOSE, at(x_mm, z_mm, 0))
    assert (violation is not None) == broken
    if broken:
        assert violation.guard == "inner radius"
        assert violation.excess_mm == pytest.approx(min(57 - x_mm, 381 - z_mm))


def test_the_outer_radius_is_kept():
    arm = replace(LOOSE, hand_mm=120.0)
    violation = GUARDS.violation(arm, at(460, 193.7, 0, arm=arm))
    assert violation.guard == "outer radius"
    assert violation.excess_mm == pytest.approx(7)
    assert Guards(outer_radius_mm=None).violation(arm, at(460, 193.7, 0, arm=arm)) is None


def test_a_hand_that_points_backwards_into_the_base_is_refused():
    only_hand = Guards(inner_radius_mm=None)
    violation = only_hand.violation(LOOSE, at(40, 20, -110))
    assert violation.guard == "hand against base"
    assert "points backwards" in violation.sentence
    assert only_hand.violation(LOOSE, at(40, 20, -90)) is None
    assert only_hand.violation(LOOSE, at(40, 40, -110)) is None
    assert only_hand.violation(LOOSE, at(60, 20, -110)) is None
    assert only_hand.violation(LOOSE, at(50, 20, -150)) is None  # the wrist is far enough out


def test_leaving_a_guard_makes_it_shallower():
    depths = [GUARDS.depth_mm(LOOSE, at(x_mm, 300, 0)) for x_mm in (20, 30, 40, 50, 57)]
    assert depths == sorted(depths, reverse=True)
    assert depths[0] == pytest.approx(37)
    assert depths[-1] == 0.0


def test_the_deepest_of_several_is_named():
    both = at(20, -30, -90)
    assert {broken.guard for broken in GUARDS.violations(LOOSE, both)} == {"table", "inner radius"}
    assert GUARDS.violation(LOOSE, both).guard == "inner radius"


@given(goals)
def test_the_nearest_allowed_pose_is_reachable_and_allowed(goal):
    found = nearest_allowed(TEACHMOVER, GUARDS, goal)
    if found is not None:
        joints = TEACHMOVER.ik(found)
        assert GUARDS.violations(TEACHMOVER, joints) == ()
        assert same_pose(TEACHMOVER.fk(joints), found, mm=1e-4)


@given(postures(TEACHMOVER))
def test_a_pose_that_breaks_nothing_is_its_own_answer(joints):
    pose = TEACHMOVER.fk(joints)
    if not GUARDS.violations(TEACHMOVER, TEACHMOVER.ik(pose, joints)):
        found = nearest_allowed(TEACHMOVER, GUARDS, pose, joints)
        assert distance_mm(found, pose) < 1e-4


@given(st.floats(150, 340), st.floats(-300, -1.01), st.floats(-1.5, 1.5))
def test_a_goal_below_the_table_is_lifted_onto_it(r, z_mm, direction):
    goal = Pose(r * math.cos(direction), r * math.sin(direction), z_mm, -math.pi / 2)
    found = nearest_allowed(TEACHMOVER, GUARDS, goal)
    assert -1.0 <= found.z_mm <= 1e-6
    assert (found.x_mm, found.y_mm) == pytest.approx((goal.x_mm, goal.y_mm), abs=5.0)
    assert found.pitch_rad == goal.pitch_rad


def test_a_goal_in_the_body_comes_out_by_the_shorter_way():
    aside = nearest_allowed(LOOSE, GUARDS, Pose(30, 0, 200, 0.3))
    assert math.hypot(aside.x_mm, aside.y_mm) == pytest.approx(57)
    assert aside.z_mm == pytest.approx(200)
    above = nearest_allowed(LOOSE, GUARDS, Pose(10, 0, 370, 0.3))
    assert (above.x_mm, above.z_mm) == pytest.approx((10, 381))


def test_a_goal_on_the_axis_comes_out_in_the_seeds_direction():
    found = nearest_allowed(LOOSE, GUARDS, Pose(0, 0, 200, 0.3), Joints.of(90, 40, -60, 0, 0))
    assert (found.x_mm, found.y_mm) == pytest.approx((0, 57), abs=1e-6)


def test_guards_that_leave_no_room_have_no_answer():
    walled_in = Guards(inner_radius_mm=500.0, inner_height_mm=900.0)
    assert nearest_allowed(TEACHMOVER, walled_in, Pose(250, 0, 100, 0)) is None
