"""Timed paths: what is known in closed form, and the ways a driver reads them."""

import math
import subprocess
import sys
from itertools import pairwise

import pytest
from kinematics_cases import TEACHMOVER

from kinematics import KinematicsError, Pose, line_path, preset
from kinematics.paths.profiles import jerk_limited
from kinematics.paths.timing import MotionLimits, timed

SPEEDS = (0.5, 0.4, 0.5, 0.8, 0.8)
HARD = (2.0, 1.0, 2.0, 4.0, 4.0)


def line_corners(tolerance_mm=0.1):
    start = TEACHMOVER.ik(Pose.of(x_mm=150, y_mm=-150, z_mm=150, pitch_deg=-60))
    goal = Pose.of(x_mm=250, y_mm=180, z_mm=60, pitch_deg=-80)
    return [tuple(each) for each in line_path(TEACHMOVER, start, goal, tolerance_mm)]


@pytest.mark.parametrize("jerk_s", [0.0, 0.1])
@pytest.mark.parametrize("goal", [(1.0, 0.0), (0.3, -1.0), (0.01, 0.02)])
def test_two_corners_are_the_exact_profile_of_the_most_limited_coordinate(goal, jerk_s):
    limits = MotionLimits((0.5, 1.0), (2.0, 1.0), jerk_s)
    path = timed([(0.0, 0.0), goal], limits)
    hardest, fastest = (
        min(limit / abs(way) for limit, way in zip(each, goal, strict=True) if way)
        for each in ((2.0, 1.0), (0.5, 1.0))
    )
    jerk = hardest / jerk_s if jerk_s else math.inf
    assert path.duration_s == pytest.approx(jerk_limited(1, fastest, hardest, jerk).duration_s)


def test_without_acceleration_limits_each_chord_takes_its_least_time():
    """As the driver has timed its legs: joints, gripper and motors each at their own top speed."""
    model = preset("teachmover")
    transmission = model.transmission
    speeds = (*model.joint_speeds_rad_s, model.gripper_speed_mm_s)
    limits = MotionLimits(speeds, jerk_s=0.2, motors=transmission.matrix, motor_hz=100.0)
    corners = [(*joints, 10.0 + index) for index, joints in enumerate(line_corners())]
    path = timed(corners, limits, speed=0.5)
    for (a, b), (before_s, behind_s) in zip(pairwise(corners), pairwise(path.times_s), strict=True):
        rates = transmission.motor_rates(
            [y - x for x, y in zip(a[:5], b[:5], strict=True)], b[5] - a[5]
        )
        busiest_s = max(abs(rate) for rate in rates) / 100.0
        slowest_s = max(abs(y - x) / speed for x, y, speed in zip(a, b, speeds, strict=True))
        assert behind_s - before_s == pytest.approx(max(busiest_s, slowest_s) / 0.5, rel=1e-9)
    assert len(path.pieces(0.05)) == len(corners) - 1


def test_a_motor_that_two_joints_drive_is_held_to_its_rate():
    limits = MotionLimits((1.0, 1.0), motors=((100.0, 0.0), (100.0, 100.0)), motor_hz=100.0)
    assert timed([(0.0, 0.0), (1.0, 1.0)], limits).duration_s == pytest.approx(2.0)
    assert timed([(0.0, 0.0), (1.0, -1.0)], limits).duration_s == pytest.approx(1.0)


@pytest.mark.parametrize("jerk_s", [0.0, 0.1])
def test_corners_on_one_straight_way_cost_nothing(jerk_s):
    limits = MotionLimits(SPEEDS, HARD, jerk_s)
    ends = (0.0, 0.0, 0.0, 0.0, 0.0), (1.0, 0.4, -0.7, 0.2, 1.0)
    between = [tuple(share * end for end in ends[1]) for share in (0.1, 0.15, 0.5, 0.52, 0.9)]
    cut = timed([ends[0], *between, ends[1]], limits)
    assert cut.duration_s == pytest.approx(timed(ends, limits).duration_s, rel=1e-9)


def test_it_is_at_its_corners_when_it_says():
    path = timed(line_corners(), MotionLimits(SPEEDS, HARD, 0.1))
    assert path.at(-1.0) == path.corners[0]
    assert path.at(path.duration_s + 1.0) == path.corners[-1]
    for corner, t_s in zip(path.corners, path.times_s, strict=True):
        assert path.at(t_s) == pytest.approx(corner, abs=1e-9)


@pytest.mark.parametrize("jerk_s", [0.0, 0.15])
def test_pieces_follow_the_profile(jerk_s):
    path = timed(line_corners(), MotionLimits(SPEEDS, HARD, jerk_s))
    pieces = path.pieces(0.02)
    assert math.fsum(piece.duration_s for piece in pieces) == pytest.approx(path.duration_s)
    assert set(path.corners[1:]) <= {piece.point for piece in pieces}
    t_s = 0.0
    for piece in pieces:
        begin_s, t_s = t_s, t_s + piece.duration_s
        assert piece.duration_s > 0.0
        assert path.at(t_s) == pytest.approx(piece.point, abs=1e-9)
        before, behind = (path.profile.at(x)[1] for x in (begin_s + 1e-9, t_s - 1e-9))
        assert piece.duration_s <= 0.02 * (1 + 1e-6) or before == pytest.approx(behind, abs=1e-3)


def test_a_long_way_at_one_speed_is_one_piece():
    pieces = timed([(0.0,), (10.0,)], MotionLimits((1.0,), (4.0,))).pieces(0.05)
    assert [piece.duration_s for piece in pieces[:5]] == pytest.approx([0.05] * 5)
    assert pieces[5] == (pytest.approx((9.875,)), pytest.approx(9.75))
    assert len(pieces) == 11


def test_a_fraction_of_the_speed_leaves_the_accelerations():
    limits = MotionLimits((1.0,), (4.0,))
    assert timed([(0.0,), (10.0,)], limits, speed=0.5).duration_s == pytest.approx(20.125)


def test_where_a_joint_turns_fast_the_path_slows_and_keeps_its_limits():
    """Past the base axis at 4 mm: the base turns by half a circle, most of it within 20 mm."""
    start = TEACHMOVER.ik(Pose.of(x_mm=4, y_mm=-75, z_mm=442, pitch_deg=-17))
    goal = Pose.of(x_mm=4, y_mm=75, z_mm=442, pitch_deg=-17)
    corners = [tuple(each) for each in line_path(TEACHMOVER, start, goal, 0.05)]
    path = timed(corners, MotionLimits(SPEEDS, HARD, 0.05))
    for (a, b), (before_s, behind_s) in zip(pairwise(corners), pairwise(path.times_s), strict=True):
        for one, other, speed in zip(a, b, SPEEDS, strict=True):
            assert abs(other - one) <= speed * (behind_s - before_s) * (1 + 1e-9)


def test_timing_one_arm_loads_no_numpy():
    code = "import sys, kinematics as k; k.timed; k.MotionLimits; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_points_that_repeat_take_no_time():
    limits = MotionLimits((1.0,), (4.0,), 0.1)
    plain = timed([(0.0,), (1.0,), (3.0,)], limits)
    doubled = timed([(0.0,), (0.0,), (1.0,), (1.0,), (3.0,), (3.0,)], limits)
    assert doubled.duration_s == plain.duration_s
    assert doubled.at(0.3) == plain.at(0.3)
    assert list(doubled.pieces(0.05)) == list(plain.pieces(0.05))
    for still in ([(2.0,)], [(2.0,), (2.0,)]):
        assert timed(still, limits).duration_s == 0.0
        assert timed(still, limits).at(0.0) == (2.0,)
        assert timed(still, limits).pieces(0.05) == ()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: timed([], MotionLimits((1.0,))), "a point to begin at"),
        (lambda: timed([(0.0,), (1.0, 2.0)], MotionLimits((1.0,))), "each corner needs 1, not 2"),
        (lambda: timed([(0.0,), (math.nan,)], MotionLimits((1.0,))), "finite"),
        (lambda: timed([(0.0,)], MotionLimits((1.0,)), speed=0.0), "fraction of the limits"),
        (lambda: timed([(0.0,)], MotionLimits((1.0,)), speed=1.5), "fraction of the limits"),
        (lambda: timed([(0.0,)], MotionLimits((1.0,))).pieces(0.0), "longest_s"),
        (lambda: MotionLimits((0.0,)), "a speed limit"),
        (lambda: MotionLimits((math.inf,)), "finite"),
        (lambda: MotionLimits((1.0,), (-1.0,)), "an acceleration limit"),
        (lambda: MotionLimits((1.0,), motor_hz=0.0), "motor_hz"),
        (lambda: MotionLimits((1.0,), jerk_s=-0.1), "jerk_s"),
        (lambda: MotionLimits((1.0, 1.0), (1.0,)), "as many accelerations"),
        (lambda: MotionLimits((1.0,), motors=((1.0, 2.0),)), "each motor's row"),
    ],
)
def test_what_makes_no_motion_is_refused_by_name(call, words):
    with pytest.raises(KinematicsError, match=words):
        call()
