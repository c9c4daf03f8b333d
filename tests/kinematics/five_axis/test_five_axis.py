"""Forward and inverse kinematics of the five-axis build."""

import math
import random
from dataclasses import replace

import pytest
from amounts import every_row
from hypothesis import example, given
from hypothesis import strategies as st
from kinematics_cases import (
    HALF_TURNS,
    TEACHMOVER,
    UNEVEN,
    any_arm,
    distance_mm,
    goals,
    same_pose,
    turn_between,
)
from kinematics_cases import TEACHMOVER as BARE

from kinematics import (
    Constraint,
    FiveAxisArm,
    JointRange,
    Joints,
    KinematicsError,
    Pose,
    Unreachable,
)
from kinematics.five_axis.nearest import nearest
from kinematics.frames.vectors import cross
from kinematics.geometry import AXIS_MM, Tool
from kinematics.presets import PRESETS

FREE = FiveAxisArm(150.0, 120.0, 120.0, 80.0, (JointRange.of(-400, 400),) * 5)
"""Every joint turns more than once, so that each angle has several turns to choose from."""

arms = st.sampled_from((TEACHMOVER, UNEVEN, FREE, HALF_TURNS))
seeds = st.tuples(*[st.floats(-4.0, 4.0)] * 5)


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
    for asked_deg, held_deg in ((99.5, 30.0), (-99.5, -30.0)):
        goal = Pose.of(x_mm=400, y_mm=0, z_mm=200, pitch_deg=asked_deg)
        found = nearest(stiff, goal)
        assert found.pose.pitch_deg == pytest.approx(held_deg, abs=1.0)
        assert same_pose(stiff.fk(stiff.ik(found.pose)), found.pose, mm=1e-4)


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


# Postures that rounding makes hard: what one holds is met, and what is offered for it holds it.

GOALS = 60

NO_HAND = FiveAxisArm(150.0, 120.0, 90.0, 0.0, (JointRange.of(-180, 180),) * 5)
ARMS = {
    "teachmover": TEACHMOVER,
    "uneven": UNEVEN,
    "equal links, half turns": HALF_TURNS,
    "no hand": NO_HAND,
}


def tiny(chance):
    """Nothing, or anything from rounding to a micron's worth."""
    return chance.choice((0.0, 1.0, -1.0)) * 10.0 ** chance.uniform(-16.0, -5.0)


def anywhere(arm, q, chance):
    return q


def stretched(arm, q, chance):
    return [q[0], q[1], arm.limits[2].clamp(tiny(chance)), *q[3:]]


def folded(arm, q, chance):
    return [q[0], q[1], arm.limits[2].low_rad, *q[3:]]


def vertical(arm, q, chance):
    return [*q[:3], math.pi / 2.0 - q[1] - q[2] + tiny(chance), q[4]]


def over_the_axis(arm, q, chance):
    _, upper, fore, hand = arm.lengths
    r = upper * math.cos(q[1]) + fore * math.cos(q[1] + q[2]) + 1e3 * tiny(chance)
    if abs(r) > hand or hand == 0.0:
        return q
    return [*q[:3], chance.choice((1.0, -1.0)) * math.acos(-r / hand) - q[1] - q[2], q[4]]


def at_a_limit(arm, q, chance):
    joint = chance.randrange(5)
    bounds = arm.limits[joint]
    return [*q[:joint], chance.choice((bounds.low_rad, bounds.high_rad)), *q[joint + 1 :]]


KINDS = (anywhere, stretched, folded, vertical, over_the_axis, at_a_limit)


def hard_postures(arm, kind, chance):
    for _ in range(GOALS):
        q = [chance.uniform(bounds.low_rad, bounds.high_rad) for bounds in arm.limits]
        yield tuple(kind(arm, q, chance))


@every_row("kind", KINDS, ids=lambda kind: kind.__name__)
@every_row("arm", ARMS.values(), ids=ARMS)
def test_what_a_posture_holds_is_met_and_what_is_offered_holds(arm, kind):
    chance = random.Random(7)
    for q in hard_postures(arm, kind, chance):
        pose = arm.fk(Joints(q))
        near = Joints(tuple(bounds.clamp(chance.uniform(-2.0, 2.0)) for bounds in arm.limits))
        solved = arm.solve(pose, near)
        assert solved is not None or arm.violations(Joints(q))
        offered = [branch.joints for branch in arm.branches(pose, near)]
        if math.hypot(pose.x_mm, pose.y_mm) > AXIS_MM:
            offered += [] if solved is None else [solved]
        elif solved is not None:  # a pitch and its mirror image are the same elevation there
            assert math.sin(arm.fk(solved).pitch_rad) == pytest.approx(
                math.sin(pose.pitch_rad), abs=1e-5
            )
        for joints in offered:
            assert same_pose(arm.fk(joints), pose, mm=1e-4, rad=1e-5)


# A tool in the fingers: its point is where it is said to be, and the inverse finds it again.


def test_up_is_up_and_side_is_to_the_right_of_a_level_hand() -> None:
    level = BARE.ik(Pose.of(x_mm=250, y_mm=0, z_mm=150, pitch_deg=0))
    pose = BARE.with_tool(Tool(along_mm=5, up_mm=20, side_mm=30)).fk(level)
    assert pose.position_mm == pytest.approx((255.0, -30.0, 170.0))
    up, side, along = zip(*BARE.hand_axes(level), strict=True)
    assert cross(up, side) == pytest.approx(along)


def test_a_point_nearer_to_the_axis_than_the_tool_is_refused_with_one_in_reach() -> None:
    arm, seed = BARE.with_tool(Tool(side_mm=50)), Joints.of(70, 120, -60, -60, 0)
    for z_mm, near in ((300, None), (470, Pose.of(x_mm=0, y_mm=-50, z_mm=470, pitch_deg=0))):
        with pytest.raises(Unreachable, match="beside the arm's plane") as refusal:
            arm.ik(Pose.of(x_mm=0, y_mm=-20, z_mm=z_mm, pitch_deg=0), seed)
        near = near or refusal.value.nearest
        assert same_pose(refusal.value.nearest, near)
        assert same_pose(arm.fk(arm.ik(near)), near, mm=1e-3)


@every_row("turned_deg", [-90, -30, 0, 60])
@every_row("seed_deg", [-90, 0, 40, 90])
def test_fingers_over_the_base_axis_turn_the_base_to_where_the_tool_has_to_be(
    seed_deg: float, turned_deg: float
) -> None:
    arm, seed = BARE.with_tool(Tool(along_mm=50)), Joints.of(seed_deg, 120, -60, -60, 0)
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
    arm, seed = BARE.with_tool(Tool(along_mm=50)), Joints.of(base_deg, 90, -40, 40, 0)
    pose = Pose.of(x_mm=0, y_mm=0, z_mm=z_mm, pitch_deg=pitch_deg)
    found = arm.ik(pose, seed)
    assert found.deg["base"] == pytest.approx(base_deg)
    assert math.dist(arm.points(found)[-1], pose.position_mm) < 1e-6


def test_a_tool_is_taken_in_the_place_of_another_and_is_no_kilometre_long() -> None:
    assert BARE.with_tool(Tool(1.0)).with_tool(Tool(2.0)) == BARE.with_tool(Tool(2.0))
    with pytest.raises(KinematicsError, match="within 1000 mm"):
        Tool(along_mm=1e6)
