"""Arms driven by their link tables: the five-axis arm's answers, and laws of six joints."""

import dataclasses
import math

import pytest
from amounts import every_row
from chain_cases import gap
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from kinematics_cases import (
    MINI,
    PUMA,
    START,
    TABLE,
    deviation_mm,
    distance_mm,
    limited,
    same_pose,
    turn_between,
)
from named_arms import calibrated

from kinematics import (
    Chain,
    Constraint,
    Convention,
    DHLink,
    JointLimit,
    JointRange,
    Joints,
    KinematicsError,
    PathBroken,
    Pose,
    Unreachable,
    first_violation,
    line_path,
    nearest_allowed,
    preset,
)
from kinematics.chains.arm import ChainArm
from kinematics.chains.goals import HandTask, Part, goal_of, pose_of
from kinematics.five_axis.tool_arm import Tool, holding
from kinematics.frames.rotations import multiply, transpose
from kinematics.frames.transforms import position_of, rotation_of
from kinematics.limits import refuse_worst
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


def frame_gap(arm, a, b):
    first, second = (arm.chain.fk(one.angles_rad) for one in (a, b))
    turn = multiply(transpose(rotation_of(first)), rotation_of(second))
    return math.dist(position_of(first), position_of(second)), max(
        abs(turn[i][j] - (i == j)) for i in range(3) for j in range(3)
    )


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


def test_stretched_out_the_levers_are_the_five_axis_arms():
    assert MINI.levers_mm(None) == pytest.approx(FIVE.levers_mm(None))


@given(postures(PUMA))
@settings(max_examples=25, deadline=None)
def test_what_ik_finds_for_six_joints_holds_the_hand_there(joints):
    pose = PUMA.fk(joints)
    found = PUMA.ik(pose)
    gap_mm, gap = frame_gap(PUMA, joints, found)
    assert gap_mm < 1e-3
    assert gap < 1e-5
    assert not PUMA.violations(found)


@given(postures(PUMA))
def test_a_pose_and_its_frame_are_one(joints):
    frame = PUMA.chain.fk(joints.angles_rad)
    pose = pose_of(frame, HandTask.WHOLE, (0.0, 0.0, 660.0))
    again = goal_of(pose, HandTask.WHOLE, (0.0, 0.0, 660.0)).frame
    assert gap(again, frame) < 1e-9


def test_a_posture_is_its_own_answer():
    found = PUMA.ik(PUMA.fk(START), START)
    assert list(found) == pytest.approx(list(START), abs=1e-9)


@every_row("pitch_deg, z_mm", [(-90.0, 500), (90.0, 1250), (-100.0, 500)])
def test_a_vertical_hand_and_one_beyond_it_are_held(pitch_deg, z_mm):
    pose = Pose.of(x_mm=450, y_mm=150, z_mm=z_mm, pitch_deg=pitch_deg, roll_deg=20, yaw_deg=30)
    found = PUMA.ik(pose)
    frame = PUMA.chain.fk(found.angles_rad)
    assert math.isclose(frame[2][2], math.sin(math.radians(pitch_deg)), abs_tol=1e-6)
    assert frame_gap(PUMA, found, PUMA.ik(PUMA.fk(found), found))[1] < 1e-6


@pytest.mark.parametrize("arm", [MINI, PUMA], ids=["five", "six"])
@given(
    x=st.floats(-1600, 1600),
    y=st.floats(-1600, 1600),
    z=st.floats(-300, 1600),
    pitch=st.floats(-90, 90),
    data=st.data(),
)
@settings(max_examples=2, deadline=None)
def test_the_pose_that_a_refusal_names_can_be_taken(arm, x, y, z, pitch, data):
    yaw = data.draw(st.floats(-180, 180)) if arm.has_yaw else None
    goal = Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=pitch, yaw_deg=yaw)
    nearest = arm.nearest_pose(goal)
    if nearest == goal:
        assert not arm.violations(arm.ik(goal))
        return
    with pytest.raises(Unreachable) as refusal:
        arm.ik(goal)
    assert refusal.value.nearest == nearest
    assert refusal.value.excess > 0.0
    assert not arm.violations(arm.ik(nearest))


def test_too_far_says_by_how_much():
    with pytest.raises(Unreachable) as refusal:
        PUMA.ik(Pose.of(x_mm=3000, y_mm=0, z_mm=660, pitch_deg=0, yaw_deg=0))
    assert refusal.value.constraint is Constraint.TOO_FAR
    assert refusal.value.nearest.x_mm < 1000
    assert "with this pitch" in str(refusal.value)


def test_the_nearest_pose_behind_the_base_axis_is_told_as_it_is_there():
    goal = Pose.of(x_mm=-1309.9, y_mm=990.9, z_mm=1017.5, pitch_deg=-82.5)
    with pytest.raises(Unreachable) as refusal:
        MINI.ik(goal)
    nearest = refusal.value.nearest
    assert nearest.x_mm > 0.0
    assert nearest.pitch_deg == pytest.approx(-97.5, abs=1e-3)
    assert not MINI.violations(MINI.ik(nearest))


def test_a_limit_is_named():
    tight = limited(MINI, (JointRange.of(-30, 30), *MINI.limits[1:]))
    with pytest.raises(Unreachable, match="base would have to be at 90") as refusal:
        tight.ik(Pose.of(x_mm=0, y_mm=250, z_mm=100, pitch_deg=-80))
    assert refusal.value.constraint is Constraint.JOINT_LIMIT
    assert refusal.value.joint == "base"
    with pytest.raises(JointLimit, match="base"):
        refuse_worst(tight.violations(Joints.of(40, 0, 0, 0, 0)))


def test_a_step_through_a_singular_wrist_is_refused_at_once():
    straight = PUMA.joints_of((0.0, -1.0, 1.8, 0.0, 0.0, 0.0))
    here = PUMA.fk(straight)
    with pytest.raises(Unreachable) as refusal:
        PUMA.ik_near(dataclasses.replace(here, yaw_rad=(here.yaw_rad or 0.0) + 0.01), straight)
    assert refusal.value.constraint in {Constraint.NO_POSTURE, Constraint.JOINT_LIMIT}


def test_a_small_step_stays_near():
    here = PUMA.fk(START)
    near = PUMA.ik_near(moved(here, (2.0, 0.0, 0.0)), START)
    assert max(abs(a - b) for a, b in zip(near, START, strict=True)) < 0.02


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


def test_a_line_that_leaves_the_reach_breaks_on_its_way():
    here = PUMA.fk(START)
    with pytest.raises(PathBroken) as broken:
        line_path(PUMA, START, moved(here, (900.0, 0.0, 0.0)))
    assert 0.0 < broken.value.fraction < 1.0


def test_a_start_beyond_a_limit_may_come_back_on_a_line():
    low = START["theta3"]
    ranges = list(PUMA.limits)
    ranges[2] = JointRange(ranges[2].low_rad, low - 0.02)
    arm = limited(PUMA, ranges)
    inside = START.replace(**{START.names[2]: low - 0.05})
    way = line_path(arm, START, arm.fk(inside))
    assert not arm.violations(way[-1])


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


def offset_shoulder(convention=Convention.STANDARD):
    """Five joints whose hand leaves the plane of base axis and tip by an offset."""
    rows = ((200, 0, 90), (60, 250, 0), (0, 200, 0), (0, 0, 90), (80, 0, 0))
    links = tuple(
        DHLink(
            0.0,
            d,
            a,
            math.radians(alpha),
            offset=math.pi / 2 if index == 3 else 0.0,
            low=-2.5,
            high=2.5,
        )
        for index, (d, a, alpha) in enumerate(rows)
    )
    return ChainArm(Chain(links, convention))


@given(st.tuples(*[st.floats(-2.0, 2.0)] * 5))
@settings(max_examples=15, deadline=None)
def test_five_joints_off_their_plane_hold_position_elevation_and_roll(values):
    arm = offset_shoulder()
    assert arm.task is HandTask.ELEVATION
    joints = arm.joints_of(values)
    pose = arm.fk(joints)
    assert pose.yaw_rad is None
    assert arm.goal(pose).parts == {Part.POSITION, Part.PITCH, Part.ROLL}
    again = arm.fk(arm.ik(pose, joints))
    assert distance_mm(pose, again) < 1e-3
    assert math.isclose(pose.pitch_rad, again.pitch_rad, abs_tol=1e-5)


@given(st.tuples(*[st.floats(-2.0, 2.0)] * 5), st.tuples(*[st.floats(-0.3, 0.3)] * 5))
@settings(max_examples=25)
@pytest.mark.parametrize("convention", list(Convention))
def test_no_point_travels_further_than_the_bound(convention, values, changes):
    arm = offset_shoulder(convention)
    start = arm.joints_of(values)
    end = arm.joints_of(a + b for a, b in zip(values, changes, strict=True))
    bound = arm.travel_bound_mm(changes)
    for a, b in zip(arm.points(start), arm.points(end), strict=True):
        assert math.dist(a, b) <= bound + 1e-9
    for lever, most in zip(arm.levers_mm(start), arm.levers_mm(None), strict=True):
        assert lever <= most + 1e-6


def test_a_pose_without_yaw_reads_as_it_always_did():
    pose = Pose(1.0, 2.0, 3.0, 0.5)
    assert repr(pose) == "Pose(x_mm=1.0, y_mm=2.0, z_mm=3.0, pitch_rad=0.5, roll_rad=0.0)"
    assert "yaw" not in str(pose)
    assert pose == Pose(1.0, 2.0, 3.0, 0.5, 0.0, None)
    headed = Pose.of(x_mm=1, y_mm=2, z_mm=3, pitch_deg=0, yaw_deg=90)
    assert repr(headed).endswith(f"yaw_rad={math.pi / 2!r})")
    assert str(headed).endswith("yaw 90.0°")
    assert headed.yaw_deg == 90.0
    assert headed != dataclasses.replace(headed, yaw_rad=None)


# The quick solver for jogs: it holds the pose, stays near and within the limits.


@settings(max_examples=40, deadline=None)
@given(st.sampled_from([MINI, PUMA, MEASURED]), st.data(), STEPS)
def test_a_small_step_is_met_exactly_and_within_the_limits_or_not_at_all(arm, data, step):
    seed = data.draw(postures(arm, 0.1))
    goal = moved(arm.fk(seed), step)
    found = arm.solve_near(goal, seed)
    if found is None:
        return
    made = arm.fk(found)
    assert distance_mm(made, goal) < 1e-5
    assert turn_between(made.pitch_rad, goal.pitch_rad) < 1e-6
    assert arm.violations(found) == ()


@settings(max_examples=40, deadline=None)
@given(postures(MINI, 0.1), STEPS)
def test_a_link_table_of_the_build_is_solved_as_its_closed_form(joints, step):
    assume(abs(math.sin(joints[2])) > 0.2)
    goal = moved(FIVE.fk(joints), step)
    assume(math.hypot(goal.x_mm, goal.y_mm) > 60.0)
    expected = FIVE.solve(goal, joints)
    assume(expected is not None and math.dist(expected, joints) < 0.3)
    found = MINI.solve_near(goal, joints)
    assert found is not None
    assert tuple(found) == pytest.approx(tuple(expected), abs=1e-6)


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


def test_a_pose_of_other_axes_is_none_of_this_arm():
    seed, pose = Joints((0.0,) * 6, PUMA.joint_names), FIVE.fk(Joints((0.0, 0.7, -1.4, -0.7, 0.0)))
    with pytest.raises(KinematicsError):
        PUMA.goal(pose)
    assert PUMA.solve_near(pose, seed) is None
