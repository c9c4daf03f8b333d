"""Forward and inverse kinematics of the five-axis build."""

import math
import random
from dataclasses import replace

import pytest
from amounts import every_row
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
    same_pose,
    turn_between,
)

from kinematics import (
    Constraint,
    FiveAxisArm,
    JointRange,
    Joints,
    Pose,
    Unreachable,
)
from kinematics.five_axis.nearest import nearest
from kinematics.geometry import AXIS_MM
from kinematics.presets import PRESETS

FREE = FiveAxisArm(150.0, 120.0, 120.0, 80.0, (JointRange.of(-400, 400),) * 5)
"""Every joint turns more than once, so that each angle has several turns to choose from."""

arms = st.sampled_from((TEACHMOVER, UNEVEN, FREE, HALF_TURNS))
seeds = st.tuples(*[st.floats(-4.0, 4.0)] * 5)


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


def test_where_the_goals_height_is_not_on_the_axis_the_arm_stops_where_it_crosses_the_axis():
    arm = facing_forward(JointRange.of(-90, -90))
    span = 177.8 * math.sqrt(2)
    height = 193.7 + math.sqrt(span**2 - 96.5**2)  # the elbow is rigid: the wrist is on a circle
    found = nearest(arm, Pose(-300, 0, 293.7, 0))
    assert same_pose(found.pose, Pose(0, 0, height, 0))
    assert same_pose(arm.fk(arm.ik(found.pose)), found.pose, mm=1e-4)
