"""Dense lines: the answers of one point after another, and times under every limit."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from kinematics_cases import ARMS, TEACHMOVER, arm_and_posture

from kinematics import Joints, KinematicsError, MotionLimits, PathBroken, Pose, preset, timed
from kinematics.five_axis.batch_line import LinePlanner

SPEEDS = (0.5, 0.4, 0.5, 0.8, 0.8)
HARD = (2.0, 1.0, 2.0, 4.0, 4.0)
MOTORS = preset("teachmover").transmission.without_gripper().matrix
LIMITS = MotionLimits(SPEEDS, HARD, 0.0, MOTORS, 150.0)

START = Pose.of(x_mm=150, y_mm=-150, z_mm=150, pitch_deg=-60)
GOAL = Pose.of(x_mm=250, y_mm=180, z_mm=60, pitch_deg=-80, roll_deg=30)

ways = st.builds(
    lambda x, y, z, pitch, roll: (x, y, z, pitch, roll),
    *[st.floats(-150, 150)] * 3,
    st.sampled_from((0.0,)) | st.floats(-0.7, 0.7),
    st.sampled_from((0.0,)) | st.floats(-0.7, 0.7),
)


def away(pose, way):
    """The pose a way off."""
    x, y, z, pitch, roll = way
    return Pose(
        pose.x_mm + x, pose.y_mm + y, pose.z_mm + z, pose.pitch_rad + pitch, pose.roll_rad + roll
    )


def one_by_one(arm, start, goal, points):
    """The line as line.py solves it, or the refusal."""
    line, before, found = arm.line(start, goal), start, []
    for share in np.linspace(0.0, 1.0, points).tolist():
        try:
            reached = line.solve(share, before)
        except PathBroken as broken:
            return broken
        if (reason := line.leap(before, reached)) is not None:
            return PathBroken(share, line.pose(share), reason)
        before = reached
        found.append(before.angles_rad)
    return np.array(found)


@given(arm_and_posture, ways, st.sampled_from((3, 20, 57)))
def test_it_answers_as_the_line_does_point_by_point(chosen, way, points):
    arm, start = chosen
    goal = away(arm.fk(start), way)
    expected = one_by_one(arm, start, goal, points)
    planner = LinePlanner(arm, LIMITS, points)
    if isinstance(expected, PathBroken):
        with pytest.raises(PathBroken) as refusal:
            planner.plan(start, goal)
        assert refusal.value.fraction == expected.fraction
        assert str(refusal.value) == str(expected)
    else:
        assert planner.plan(start, goal).joints == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("arm", ARMS, ids=["teachmover", "uneven"])
def test_most_lines_are_solved_at_once(arm, monkeypatch):
    """Random ways from random postures, from behind as well: the slow way is for a few."""
    slow = []
    solve = LinePlanner._one_by_one
    monkeypatch.setattr(LinePlanner, "_one_by_one", lambda *args: (slow.append(1), solve(*args))[1])
    generator = np.random.default_rng(2)
    planner, whole, behind = LinePlanner(arm, LIMITS, 20), 0, 0
    low, high = ([getattr(one, name) for one in arm.limits] for name in ("low_rad", "high_rad"))
    for _ in range(200):
        start = Joints(tuple(generator.uniform(low, high).tolist()))
        goal = away(arm.fk(start), (*generator.uniform(-60, 60, 3), 0.1, 0.2))
        if isinstance(one_by_one(arm, start, goal, 20), PathBroken):
            continue
        before = len(slow)
        planner.plan(start, goal)
        whole += 1
        tip = arm.points(start)[-1]
        front = math.cos(start[0]) * tip[0] + math.sin(start[0]) * tip[1] > 0.0
        behind += not front and len(slow) == before
    assert whole > 50
    assert len(slow) < 0.15 * whole
    assert behind > 3


def test_a_joint_on_its_limit_stays_there():
    limits = TEACHMOVER.limits
    start = Joints((0.2, 0.7, -1.2, limits[3].low_rad, 0.4))
    found = LinePlanner(TEACHMOVER, LIMITS, 50).plan(start, TEACHMOVER.fk(start)).joints
    assert found == pytest.approx(np.tile(start.angles_rad, (50, 1)), abs=1e-9)
    assert found[:, 3].min() == limits[3].low_rad


@pytest.mark.parametrize("past_mm", [0.0, 1e-9, 0.5])
def test_a_line_that_meets_the_base_axis_is_refused_where_it_does(past_mm):
    arm = ARMS[1]
    start = arm.ik(Pose.of(x_mm=80, y_mm=past_mm, z_mm=300, pitch_deg=20))
    with pytest.raises(PathBroken, match="meets the base axis") as refusal:
        LinePlanner(arm, LIMITS, 101).plan(
            start, Pose.of(x_mm=-80, y_mm=past_mm, z_mm=300, pitch_deg=20)
        )
    assert 0.45 < refusal.value.fraction < 0.55


def plan(limits=LIMITS, points=1000, speed=1.0):
    return LinePlanner(TEACHMOVER, limits, points).plan(TEACHMOVER.ik(START), GOAL, speed)


@given(
    arm_and_posture,
    ways,
    st.tuples(*[st.floats(0.2, 5.0)] * 5),
    st.tuples(*[st.floats(0.2, 20.0)] * 5),
    st.floats(20, 400),
    st.floats(0.1, 1.0),
)
def test_no_limit_is_passed(chosen, way, speeds, accelerations, motor_hz, speed):
    """Accelerations are differences of the mean speeds between points, over those times' mean.

    From one of a thousand points to the next a joint's rate changes a little; so much, 2 %, the
    difference may be beyond the limit that holds where the rate is taken.
    """
    arm, start = chosen
    limits = MotionLimits(speeds, accelerations, 0.0, MOTORS, motor_hz)
    try:
        joints, times_s = LinePlanner(arm, limits, 1000).plan(
            start, away(arm.fk(start), way), speed
        )
    except PathBroken:
        return
    assume(times_s[-1] > 0.01)
    took_s = np.diff(times_s)
    rates = np.diff(joints, axis=0) / took_s[:, None]
    assert np.all(took_s > 0.0)
    assert np.all(np.abs(rates) <= speed * np.array(speeds) * (1 + 1e-6))
    assert np.all(np.abs(rates @ np.array(MOTORS).T) <= speed * motor_hz * (1 + 1e-6))
    harder = np.diff(rates, axis=0) / ((took_s[1:] + took_s[:-1]) / 2)[:, None]
    assert np.all(np.abs(harder) <= np.array(accelerations) * 1.02)


def test_it_starts_and_ends_at_rest():
    joints, times_s = plan(points=2000)
    rates = np.abs(np.diff(joints, axis=0)) / np.diff(times_s)[:, None]
    assert rates[0].max() < 0.2 * rates.max()
    assert rates[-1].max() < 0.2 * rates.max()


def test_without_accelerations_each_part_takes_its_least_time():
    limits = MotionLimits(SPEEDS, (), 0.0, MOTORS, 150.0)
    joints, times_s = plan(limits, 200, 0.5)
    expected = [limits.least_s(change) / 0.5 for change in np.diff(joints, axis=0).tolist()]
    assert np.diff(times_s) == pytest.approx(expected)


@pytest.mark.parametrize("hard", [HARD, (0.5,) * 5, (20.0,) * 5, (2.0, math.inf, 2.0, 4.0, 4.0)])
def test_it_takes_little_longer_than_the_path_that_is_timed_joint_by_joint(hard):
    limits = MotionLimits(SPEEDS, hard, 0.0, MOTORS, 150.0)
    joints, times_s = plan(limits, 400)
    joint_by_joint = timed(joints.tolist(), limits).duration_s
    assert 0.999 * joint_by_joint <= times_s[-1] <= 1.1 * joint_by_joint


def test_a_gripper_that_rests_changes_nothing():
    model = preset("teachmover")
    speeds = (*model.joint_speeds_rad_s, model.gripper_speed_mm_s)
    fingers = MotionLimits(speeds, (*HARD, 50.0), 0.0, model.transmission.matrix, 150.0)
    bare = MotionLimits(speeds[:5], HARD, 0.0, MOTORS, 150.0)
    assert plan(fingers).times_s == pytest.approx(plan(bare).times_s)


def test_a_plan_is_not_disturbed_by_the_next():
    planner = LinePlanner(TEACHMOVER, LIMITS, 100)
    start = TEACHMOVER.ik(START)
    first = planner.plan(start, GOAL)
    kept = first.joints.copy(), first.times_s.copy()
    planner.plan(start, away(START, (20, 0, 0, 0, 0)))
    again = planner.plan(start, GOAL)
    for one in (first, again):
        assert np.array_equal(one.joints, kept[0])
        assert np.array_equal(one.times_s, kept[1])


def test_no_way_takes_no_time():
    start = TEACHMOVER.ik(START)
    line = LinePlanner(TEACHMOVER, LIMITS, 10).plan(start, TEACHMOVER.fk(start))
    assert line.times_s.tolist() == [0.0] * 10


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: LinePlanner(TEACHMOVER, LIMITS, 2), "at least 3 points"),
        (lambda: LinePlanner(TEACHMOVER, MotionLimits((1.0,)), 9), "limits of 5 joints"),
        (lambda: LinePlanner(TEACHMOVER, MotionLimits(SPEEDS, HARD, 0.1), 9), "build-up"),
        (lambda: plan(speed=0.0), "fraction of the limits"),
        (lambda: plan(speed=1.1), "fraction of the limits"),
    ],
)
def test_what_cannot_be_planned_is_refused_by_name(call, words):
    with pytest.raises(KinematicsError, match=words):
        call()
