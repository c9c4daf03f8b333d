"""Laws that every arm keeps that can be driven, whatever its build and however it is solved."""

import math
from dataclasses import replace

import pytest
from chain_cases import gap
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from kinematics_cases import (
    HALF_TURNS,
    MEASURED,
    MINI,
    OFF_PLANE,
    PUMA,
    TEACHMOVER,
    UNEVEN,
    deviation_mm,
    distance_mm,
    same_pose,
    turn_between,
)

from kinematics import Joints, PathBroken, Pose, Unreachable, line_path
from kinematics.frames.rotations import multiply, transpose
from kinematics.geometry import Tool
from kinematics.paths.curves import LEAP_RAD

ARMS = {
    "teachmover": TEACHMOVER,
    "uneven": UNEVEN,
    "half turns": HALF_TURNS,
    "offset tool": TEACHMOVER.with_tool(Tool(along_mm=60.0, up_mm=12.0, side_mm=-7.0)),
    "link table": MINI,
    "as measured, by numbers": MEASURED,
    "off its plane": OFF_PLANE,
    "six joints": PUMA,
}
every_arm = pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
laws = settings(max_examples=25, deadline=None)
few_laws = settings(max_examples=3, deadline=None)


def drawn(arm, data, margin=0.01):
    """A posture within the limits, its tip away from the base axis."""
    angles = [st.floats(one.low_rad + margin, one.high_rad - margin) for one in arm.limits]
    joints = Joints(data.draw(st.tuples(*angles)), arm.joint_names)
    pose = arm.fk(joints)
    assume(math.hypot(pose.x_mm, pose.y_mm) > 2.0)
    return joints, pose


def held(arm, joints, pose, mm=1e-3, rad=1e-5):
    """Whether a posture holds the hand at a pose; its turn is compared as a whole."""
    if arm.has_yaw:
        frame, goal = arm.chain.fk(joints.angles_rad), arm.goal(pose).frame
        return gap(frame[:3], goal[:3]) < max(mm, rad)
    return same_pose(arm.fk(joints), pose, mm=mm, rad=rad)


def tried(call, refusal):
    """What a call returns, and None; or None, and the error with which it refuses."""
    try:
        return call(), None
    except refusal as error:
        return None, error


@every_arm
@laws
@given(st.data())
def test_the_points_end_at_the_tip_and_the_hand_s_axes_are_a_rotation(arm, data):
    joints, pose = drawn(arm, data)
    points, axes = arm.points(joints), arm.hand_axes(joints)
    assert points[-1] == pytest.approx(pose.position_mm, abs=1e-9)
    assert len(points) > len(arm.moving_points) > 1
    square = multiply(axes, transpose(axes))
    assert gap(square, ((1, 0, 0), (0, 1, 0), (0, 0, 1))) < 1e-12
    assert not arm.violations(joints)


@every_arm
@laws
@given(st.data())
def test_the_pose_of_a_posture_is_held_again_within_the_limits(arm, data):
    joints, pose = drawn(arm, data)
    for found in (arm.ik(pose, joints), arm.ik(pose), arm.solve(pose, joints)):
        assert held(arm, found, pose)
        assert not arm.violations(found)


@every_arm
@laws
@given(st.data())
def test_every_branch_holds_the_pose_and_the_posture_is_among_them(arm, data):
    joints, pose = drawn(arm, data)
    branches = arm.branches(pose, joints)
    assert len({branch.name for branch in branches}) == len(branches) >= 1
    for branch in branches:
        assert held(arm, branch.joints, pose)
        assert branch.violations == arm.violations(branch.joints)
    if arm is MEASURED or abs(math.sin(joints[2])) < 0.05 or abs(math.sin(joints[-2])) < 0.05:
        return  # found by numbers, or next to a singular posture: another one may be the same
    assert min(math.dist(branch.joints, joints) for branch in branches) < 1e-4


@every_arm
@few_laws
@given(st.data())
def test_a_refusal_names_a_pose_that_can_be_taken(arm, data):
    place = st.floats(-900.0, 900.0)
    x, y, z, pitch, turn = data.draw(st.tuples(*[place] * 3, *[st.floats(-1.5, 1.5)] * 2))
    goal = Pose(x, y, z, pitch, turn, turn if arm.has_yaw else None)
    assume(math.hypot(x, y) > 2.0)
    found, refusal = tried(lambda: arm.ik(goal), Unreachable)
    if refusal is None:
        assert held(arm, found, goal)
        return
    assert arm.solve(goal) is None
    assert refusal.goal == goal
    assert refusal.excess > 0.0
    nearest = refusal.nearest
    assert not arm.violations(arm.ik(nearest))
    assert distance_mm(nearest, goal) + abs(nearest.pitch_rad - pitch) > 1e-6


@every_arm
@laws
@given(st.data())
def test_no_point_travels_further_than_the_bound_and_no_lever_is_longer_than_the_most(arm, data):
    start, _ = drawn(arm, data)
    changes = data.draw(st.tuples(*[st.floats(-0.3, 0.3)] * len(start)))
    end = Joints(tuple(a + b for a, b in zip(start, changes, strict=True)), start.names)
    bound = arm.travel_bound_mm(changes)
    for a, b in zip(arm.points(start), arm.points(end), strict=True):
        assert math.dist(a, b) <= bound + 1e-9
    for lever, most in zip(arm.levers_mm(start), arm.levers_mm(None), strict=True):
        assert lever <= most + 1e-6


@every_arm
@laws
@given(st.data())
def test_turning_one_joint_moves_the_tip_by_its_lever(arm, data):
    start, pose = drawn(arm, data)
    for index, lever in enumerate(arm.levers_mm(start)):
        turned = [angle + 1e-6 * (each == index) for each, angle in enumerate(start)]
        moved = arm.fk(Joints(tuple(turned), start.names))
        assert distance_mm(moved, pose) <= 1e-6 * lever * (1 + 1e-4) + 1e-9


@every_arm
@laws
@given(st.data())
def test_a_small_step_is_met_exactly_and_within_the_limits_or_not_at_all(arm, data):
    seed, pose = drawn(arm, data, 0.1)
    x, y, z = data.draw(st.tuples(*[st.floats(-2.0, 2.0)] * 3))
    goal = replace(pose, x_mm=pose.x_mm + x, y_mm=pose.y_mm + y, z_mm=pose.z_mm + z)
    found = arm.solve_near(goal, seed)
    if found is not None:
        made = arm.fk(found)
        assert distance_mm(made, goal) < 1e-5
        assert turn_between(made.pitch_rad, goal.pitch_rad) < 1e-6
        assert arm.violations(found) == ()
    near, refusal = tried(lambda: arm.ik_near(goal, seed), Unreachable)
    assert refusal is None or refusal.reason
    if near is not None and arm is MEASURED:
        assert max(abs(a - b) for a, b in zip(near, seed, strict=True)) <= LEAP_RAD * math.sqrt(5)


@every_arm
@few_laws
@given(st.data())
def test_a_line_stays_within_its_tolerance_and_ends_at_its_goal_or_says_where_it_breaks(arm, data):
    start, pose = drawn(arm, data, 0.1)
    x, y, z, turn = data.draw(st.tuples(*[st.floats(-60.0, 60.0)] * 3, st.floats(-0.3, 0.3)))
    goal = replace(
        pose,
        x_mm=pose.x_mm + x,
        y_mm=pose.y_mm + y,
        z_mm=pose.z_mm + z,
        roll_rad=pose.roll_rad + turn,
    )
    way, broken = tried(lambda: line_path(arm, start, goal, tolerance_mm=0.5), PathBroken)
    if broken is not None:
        assert 0.0 <= broken.fraction <= 1.0
        assert broken.reason
        return
    assert way[0] == start
    assert deviation_mm(arm, way, goal) <= 0.5
    assert held(arm, way[-1], goal)
    assert not arm.violations(way[-1])
