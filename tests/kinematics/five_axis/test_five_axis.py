"""Forward and inverse kinematics of the five-axis build."""

import math
import random
from dataclasses import replace
from itertools import pairwise

import pytest
from amounts import every_row
from chain_cases import gap
from hypothesis import example, given
from hypothesis import strategies as st
from kinematics_cases import (
    ARMS,
    HALF_TURNS,
    TEACHMOVER,
    UNEVEN,
    any_arm,
    arm_and_posture,
    distance_mm,
    goals,
    postures,
    same_pose,
    turn_between,
)

from kinematics import (
    BadNumber,
    Constraint,
    FiveAxisArm,
    JointLimit,
    JointRange,
    Joints,
    Pose,
    Unreachable,
)
from kinematics.five_axis.nearest import nearest
from kinematics.geometry import AXIS_MM
from kinematics.limits import refuse_worst
from kinematics.presets import PRESETS

FREE = FiveAxisArm(150.0, 120.0, 120.0, 80.0, (JointRange.of(-400, 400),) * 5)
"""Every joint turns more than once, so that each angle has several turns to choose from."""

arms = st.sampled_from((TEACHMOVER, UNEVEN, FREE, HALF_TURNS))
seeds = st.tuples(*[st.floats(-4.0, 4.0)] * 5)


def test_the_zero_posture_stretches_forward_at_shoulder_height():
    pose = TEACHMOVER.fk(Joints.of(0, 0, 0, 0, 0))
    assert same_pose(pose, Pose(452.1, 0, 193.7, 0))


@given(arm_and_posture)
def test_the_points_end_at_the_tip_and_keep_the_lengths(case):
    arm, joints = case
    points = arm.points(joints)
    lengths = [math.dist(a, b) for a, b in pairwise(points)]
    assert lengths == pytest.approx(arm.lengths)
    pose = arm.fk(joints)
    assert points[4] == pytest.approx(pose.position_mm, abs=1e-9)


@given(arm_and_posture)
def test_every_branch_holds_the_pose_even_beyond_the_limits(case):
    arm, joints = case
    pose = arm.fk(joints)
    branches = arm.branches(pose, joints)
    assert len(branches) == (2 if math.hypot(pose.x_mm, pose.y_mm) <= 1e-9 else 4)
    assert len({branch.name for branch in branches}) == len(branches)
    for branch in branches:
        assert same_pose(arm.fk(branch.joints), pose, mm=1e-4)
        assert branch.violations == arm.violations(branch.joints)


@given(goals, st.sampled_from((TEACHMOVER, UNEVEN)))
def test_every_branch_of_any_goal_holds_it_and_bends_the_elbow_by_half_a_turn_at_most(goal, arm):
    for branch in arm.branches(goal):
        assert same_pose(arm.fk(branch.joints), goal, mm=1e-4)
        assert abs(branch.joints["elbow"]) <= math.pi


@given(arm_and_posture)
def test_the_posture_itself_is_among_the_branches_of_its_pose(case):
    arm, joints = case
    pose = arm.fk(joints)
    if math.hypot(pose.x_mm, pose.y_mm) < 1e-3:
        return  # the base is free there, and others of the family are returned
    nearest = min(
        max(abs(a - b) for a, b in zip(branch.joints, joints, strict=True))
        for branch in arm.branches(pose, joints)
    )
    assert nearest < 1e-5


@given(arms.flatmap(lambda arm: st.tuples(st.just(arm), postures(arm))))
def test_ik_returns_a_posture_within_limits_for_every_pose_that_one_has(case):
    arm, joints = case
    pose = arm.fk(joints)
    solved = arm.ik(pose, joints)
    assert not arm.violations(solved)
    assert same_pose(arm.fk(solved), pose, mm=1e-4)


def test_elbow_up_and_base_front_mean_what_they_say():
    branches = UNEVEN.branches(Pose(200, 0, 150, 0))
    heights = {b.name: UNEVEN.points(b.joints)[2][2] for b in branches}
    assert heights["base front, elbow up"] > heights["base front, elbow down"]
    assert heights["base front, elbow up"] == pytest.approx(heights["base back, elbow up"])
    for branch in branches:
        faces = 0.0 if "front" in branch.name else math.pi
        assert abs(branch.joints["base"]) == pytest.approx(faces)


@every_row("turns", [-1, 1])
def test_roll_is_solved_to_the_turn_nearest_the_seed(turns):
    joints = Joints.of(10, 60, -70, -20, 190 * turns)
    pose = TEACHMOVER.fk(joints)
    assert abs(pose.roll_deg) == pytest.approx(170)
    assert TEACHMOVER.ik(pose, joints).angles_rad == pytest.approx(joints.angles_rad)
    assert abs(TEACHMOVER.ik(pose)["wrist_roll"]) == pytest.approx(math.radians(170))


def test_a_base_beyond_half_a_turn_wraps_into_its_range():
    pose = UNEVEN.fk(Joints.of(183, 40, -60, 0, 0))
    solved = UNEVEN.ik(pose, Joints.of(170, 40, -60, 0, 0))
    assert math.degrees(solved["base"]) == pytest.approx(183)


def test_a_posture_behind_holds_the_pose_of_the_front_posture_that_holds_it_alike():
    behind = Joints.of(0, 144, -20, 40, 0)
    pose = TEACHMOVER.fk(behind)
    assert pose.x_mm < 0
    assert pose.pitch_deg == pytest.approx(180 - 164)
    assert abs(pose.roll_deg) == pytest.approx(180)
    (front,) = (
        branch for branch in TEACHMOVER.branches(pose) if branch.name == "base front, elbow down"
    )
    turned = TEACHMOVER.points(front.joints)
    assert gap(turned, TEACHMOVER.points(behind)) < 1e-6


@given(st.floats(-1.5, 1.5), st.floats(0.0, 40.0))
def test_a_tip_on_the_base_axis_takes_the_seeds_base(base, rise):
    pose = Pose(0.0, 0.0, 470.0 + rise, 0.0)
    seed = Joints((base, 2.0, -1.0, -1.0, 0.0))
    branches = TEACHMOVER.branches(pose, seed)
    assert [branch.joints["base"] for branch in branches] == [base, base]
    solved = TEACHMOVER.ik(pose, seed)
    assert solved["base"] == base
    assert same_pose(TEACHMOVER.fk(solved), pose)


def test_on_the_base_axis_an_elevation_that_only_its_mirror_image_holds_is_held():
    """With the base free, a hand leaning one way or the other over the axis is one elevation."""
    arm = PRESETS["minimover5"].arm
    pose = Pose.of(x_mm=0.0, y_mm=0.0, z_mm=480.0, pitch_deg=70.0)
    reached = arm.fk(arm.ik(pose))
    assert reached.position_mm == pytest.approx((0.0, 0.0, 480.0), abs=1e-6)
    assert math.sin(reached.pitch_rad) == pytest.approx(math.sin(pose.pitch_rad))
    assert arm.solve(pose) == arm.ik(pose)  # the same answer without a reason


def test_a_free_base_beyond_its_limits_is_brought_within():
    solved = TEACHMOVER.ik(Pose(0, 0, 470, 0), Joints.of(120, 120, -60, -60, 0))
    assert math.degrees(solved["base"]) == pytest.approx(90)


def test_straight_up_is_reached_by_an_arm_whose_hand_points_up():
    pose = Pose.of(x_mm=0, y_mm=0, z_mm=193.7 + 452.1, pitch_deg=90)
    solved = TEACHMOVER.ik(pose)
    assert solved.deg["shoulder"] == pytest.approx(90, abs=1e-3)
    assert same_pose(TEACHMOVER.fk(solved), pose, mm=1e-4)


def test_a_folded_arm_of_equal_links_has_a_free_shoulder():
    arm = replace(TEACHMOVER, limits=(JointRange.of(-180, 180),) * 5)
    seed = Joints.of(0, 33, 180, 0, 0)
    pose = Pose(96.5, 0, 193.7, 0)
    for branch in arm.branches(pose, seed):
        assert "base back" in branch.name or branch.joints["shoulder"] == pytest.approx(seed[1])
        assert same_pose(arm.fk(branch.joints), pose)


def test_too_far_says_how_far_and_what_is_near():
    with pytest.raises(Unreachable) as caught:
        TEACHMOVER.ik(Pose(600, 0, 193.7, 0))
    error = caught.value
    assert (error.constraint, error.joint, error.unit) == (Constraint.TOO_FAR, None, "mm")
    assert error.excess == pytest.approx(600 - 452.1)
    assert same_pose(error.nearest, Pose(452.1, 0, 193.7, 0))
    assert str(error) == (
        "x 600.0, y 0.0, z 193.7 mm, pitch 0.0°, roll 0.0° is out of reach: the wrist would be "
        "147.9 mm beyond the 355.6 mm that upper arm and forearm span; nearest pose that can be "
        "reached with this pitch: x 452.1, y 0.0, z 193.7 mm, pitch 0.0°, roll 0.0°"
    )


def test_too_near_says_so_where_the_links_cannot_fold_up():
    with pytest.raises(Unreachable, match="nearer to the shoulder than the 80") as caught:
        UNEVEN.ik(Pose(110, 0, 100, 0))
    assert caught.value.constraint is Constraint.TOO_NEAR
    assert caught.value.excess == pytest.approx(30)


def test_a_joint_limit_is_named_with_value_and_bound():
    goal = Pose.of(x_mm=0, y_mm=0, z_mm=400, pitch_deg=90)
    with pytest.raises(Unreachable) as caught:
        TEACHMOVER.ik(goal)
    error = caught.value
    assert (error.constraint, error.joint, error.unit) == (
        Constraint.JOINT_LIMIT,
        "shoulder",
        "rad",
    )
    assert math.degrees(error.bound) == pytest.approx(144)
    by_cosine_rule = 90 + math.degrees(math.acos((400 - 193.7 - 96.5) / 355.6))
    assert math.degrees(error.value) == pytest.approx(by_cosine_rule)
    assert error.excess == pytest.approx(error.value - error.bound)
    assert "the shoulder would have to be at 162.0°, 18.0° beyond its limit of 144.0°" in str(error)


@every_row(
    "goal",
    [
        Pose(900, 0, 100, 0),
        Pose(30, 0, 190, 0),
        Pose(-300, 10, 100, -1.5),
        Pose(200, 0, -400, -1.5),
        Pose(0, 0, 300, -1.5),
        Pose(0, 0, 900, 1.5),
    ],
    ids=["too far", "too near", "behind", "below", "on the axis", "straight above"],
)
def test_what_cannot_be_reached_names_something_that_can(goal):
    with pytest.raises(Unreachable) as caught:
        TEACHMOVER.ik(goal)
    error = caught.value
    assert error.goal == goal
    assert error.excess > 0
    assert same_pose(TEACHMOVER.fk(TEACHMOVER.ik(error.nearest)), error.nearest, mm=1e-4)
    assert distance_mm(error.nearest, goal) > 1e-3


@every_row("bad", [math.nan, math.inf, -math.inf, "250", None, True])
def test_what_is_no_number_never_becomes_a_pose(bad):
    with pytest.raises(BadNumber, match="y_mm"):
        Pose(200.0, bad, 100.0, 0.0)
    with pytest.raises(BadNumber, match="elbow_rad"):
        Joints((0.0, 0.0, bad, 0.0, 0.0))
    with pytest.raises(BadNumber, match="forearm_mm"):
        FiveAxisArm(195, 177.8, bad, 96.5, TEACHMOVER.limits)


def test_the_refusal_names_the_joint_that_passes_its_limit_furthest():
    refuse_worst(TEACHMOVER.violations(Joints.of(90, 144, -149, 90, 360)))
    with pytest.raises(
        JointLimit, match=r"elbow would have to be at 20\.0°, 20\.0° beyond"
    ) as caught:
        refuse_worst(TEACHMOVER.violations(Joints.of(95, 0, 20, 0, 0)))
    assert caught.value.joint == "elbow"
    assert turn_between(caught.value.excess_rad, math.radians(20)) < 1e-9


def best_of_all(arm, goal, seed):
    """The least sum of squared changes of any branch within limits, or None."""
    inside = [one.joints for one in arm.branches(goal, seed) if one.within_limits]
    if not inside and math.hypot(goal.x_mm, goal.y_mm) <= AXIS_MM:  # the other way over the axis
        mirrored = replace(
            goal, pitch_rad=math.pi - goal.pitch_rad, roll_rad=goal.roll_rad + math.pi
        )
        inside = [one.joints for one in arm.branches(mirrored, seed) if one.within_limits]
    return min((change(joints, seed) for joints in inside), default=None)


def change(joints, seed):
    return sum((a - b) ** 2 for a, b in zip(joints, seed, strict=True))


@given(arms, goals, seeds)
@example(TEACHMOVER, Pose(0.0, 0.0, 0.0, 0.0), (0.0,) * 5)
def test_no_branch_within_limits_is_nearer_to_the_seed(arm, goal, angles):
    seed = Joints((arm.limits[0].clamp(angles[0]), *angles[1:]))
    found, least = arm.solve(goal, seed), best_of_all(arm, goal, seed)
    assert (found is None) == (least is None)
    if found is not None and least is not None:
        assert found == arm.ik(goal, seed)
        assert math.isclose(change(found, seed), least, rel_tol=1e-9, abs_tol=1e-9)


# The reachable pose nearest to a goal.


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


@every_row(
    "goal, expected",
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


@every_row("arm", ARMS)
@every_row("z_mm", [-200.0, 0.0, 150.0, 400.0, 700.0])
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
