"""Timed paths: what is known in closed form, and the ways a driver reads them."""

import math
from bisect import bisect_right
from itertools import pairwise

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st
from kinematics_cases import TEACHMOVER

from kinematics import KinematicsError, Pose, line_path, preset
from kinematics.paths.profiles import averaged, trapezoid
from kinematics.paths.timing import MotionLimits, timed
from kinematics.transmission import times


def line_corners(tolerance_mm=0.1):
    start = TEACHMOVER.ik(Pose.of(x_mm=150, y_mm=-150, z_mm=150, pitch_deg=-60))
    goal = Pose.of(x_mm=250, y_mm=180, z_mm=60, pitch_deg=-80)
    return [tuple(each) for each in line_path(TEACHMOVER, start, goal, tolerance_mm)]


@every_row("jerk_s", [0.0, 0.1])
@every_row("goal", [(1.0, 0.0), (0.3, -1.0), (0.01, 0.02)])
def test_two_corners_are_the_exact_profile_of_the_most_limited_coordinate(goal, jerk_s):
    limits = MotionLimits((0.5, 1.0), (2.0, 1.0), jerk_s)
    path = timed([(0.0, 0.0), goal], limits)
    hardest, fastest = (
        min(limit / abs(way) for limit, way in zip(each, goal, strict=True) if way)
        for each in ((2.0, 1.0), (0.5, 1.0))
    )
    assert path.duration_s == pytest.approx(trapezoid(1, fastest, hardest).duration_s + jerk_s)


def test_without_acceleration_limits_each_chord_takes_its_least_time():
    """As the driver has timed its legs: joints, gripper and motors each at their own top speed."""
    model = preset("teachmover")
    transmission = model.transmission
    speeds = (*model.joint_speeds_rad_s, model.gripper_speed_mm_s)
    limits = MotionLimits(speeds, jerk_s=0.2, motors=transmission.matrix, motor_hz=100.0)
    corners = [(*joints, 10.0 + index) for index, joints in enumerate(line_corners())]
    path = timed(corners, limits, speed=0.5)
    for (a, b), (before_s, behind_s) in zip(pairwise(corners), pairwise(path.times_s), strict=True):
        rates = times(transmission.matrix, [y - x for x, y in zip(a, b, strict=True)])
        busiest_s = max(abs(rate) for rate in rates) / 100.0
        slowest_s = max(abs(y - x) / speed for x, y, speed in zip(a, b, speeds, strict=True))
        assert behind_s - before_s == pytest.approx(max(busiest_s, slowest_s) / 0.5, rel=1e-9)
    assert len(path.pieces(0.05)) == len(corners) - 1


def test_a_motor_that_two_joints_drive_is_held_to_its_rate():
    limits = MotionLimits((1.0, 1.0), motors=((100.0, 0.0), (100.0, 100.0)), motor_hz=100.0)
    assert timed([(0.0, 0.0), (1.0, 1.0)], limits).duration_s == pytest.approx(2.0)
    assert timed([(0.0, 0.0), (1.0, -1.0)], limits).duration_s == pytest.approx(1.0)


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


@every_row(
    "call, words",
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


# Laws of timed paths along any corners: no limit is passed, as sampled differences tell.
#
# Speeds are those between two moments on the chords, accelerations those of the direction that
# turns evenly from the middle of each chord to that of the next, times the speed along the path.
# Both are bounded exactly; the tolerance of 1e-6 is the rounding of differences over short times.


AXES = 3
SAMPLES = 60
SKIPPED = 1e-6
"""Chords that take less than a nanosecond are passed at once: forty of them, at 10 a second."""

limits = st.floats(0.1, 10.0)
accelerations = limits | st.just(math.inf)


@st.composite
def motion_limits(draw, jerks=(0.0, 0.02, 0.3)):
    motors = st.lists(st.tuples(*[st.floats(-300, 300)] * AXES), min_size=AXES, max_size=AXES)
    return MotionLimits(
        draw(st.tuples(*[limits] * AXES)),
        draw(st.tuples(*[accelerations] * AXES)),
        draw(st.sampled_from(jerks)),
        tuple(draw(motors)),
        draw(st.floats(50, 500)),
    )


@st.composite
def smooth_corners(draw):
    """Chords of a curve, cut evenly or more and more finely."""
    count = draw(st.integers(2, 40))
    waves = [
        (draw(st.floats(-2, 2)), draw(st.floats(0, 6)), draw(st.floats(0, 6))) for _ in range(AXES)
    ]
    power = draw(st.sampled_from((1.0, 1.7)))
    places = [(index / count) ** power for index in range(count + 1)]
    return [tuple(a * math.sin(b * u + c) for a, b, c in waves) for u in places]


rough_corners = st.lists(st.tuples(*[st.floats(-2, 2)] * AXES), min_size=2, max_size=8)
any_corners = smooth_corners() | rough_corners


def moments(path):
    return [path.duration_s * index / SAMPLES for index in range(SAMPLES + 1)]


def directions(path):
    """Return the direction of the path at a place of its parameter, turning evenly."""
    chords = [
        ((low + high) / 2, [(y - x) / (high - low) for x, y in zip(a, b, strict=True)])
        for (a, b), (low, high) in zip(pairwise(path.corners), pairwise(path.marks), strict=True)
        if high > low
    ]
    middles = [middle for middle, _ in chords]

    def at(place):
        index = bisect_right(middles, place)
        if index in {0, len(chords)}:
            return chords[min(index, len(chords) - 1)][1]
        (low, before), (high, behind) = chords[index - 1 : index + 1]
        share = (place - low) / (high - low)
        return [a + share * (b - a) for a, b in zip(before, behind, strict=True)]

    return at


def velocity(path, direction, t_s):
    place, speed, _ = path.profile.at(t_s)
    return [speed * part for part in direction(place)]


@given(any_corners, motion_limits(), st.floats(0.05, 1.0))
def test_no_coordinate_and_no_motor_is_too_fast(corners, limits, speed):
    path = timed(corners, limits, speed)
    apart_s = path.duration_s / SAMPLES
    for a, b in pairwise(map(path.at, moments(path))):
        change = [y - x for x, y in zip(a, b, strict=True)]
        for part, limit in zip(change, limits.speeds, strict=True):
            assert abs(part) <= limit * speed * apart_s * (1 + 1e-6) + SKIPPED
        for row in limits.motors:
            steps = sum(share * part for share, part in zip(row, change, strict=True))
            assert abs(steps) <= limits.motor_hz * speed * apart_s * (1 + 1e-6) + 300 * SKIPPED


@given(any_corners, motion_limits())
def test_no_acceleration_is_passed(corners, limits):
    path = timed(corners, limits)
    direction = directions(path) if path.duration_s else None
    found = [velocity(path, direction, t_s) for t_s in moments(path)[1:-1]] if direction else []
    apart_s = path.duration_s / SAMPLES
    for before, behind in pairwise(found):
        for a, b, limit in zip(before, behind, limits.accelerations, strict=True):
            assert abs(b - a) <= limit * apart_s * (1 + 1e-6) + 1e-9


def hardest(path, moments=400):
    """The greatest rate at which a coordinate's speed changes."""
    direction, apart_s = directions(path), path.duration_s / moments
    found = [velocity(path, direction, index * apart_s) for index in range(1, moments)]
    return max(abs(b - a) / apart_s for pair in pairwise(found) for a, b in zip(*pair, strict=True))


def test_a_tight_half_circle_of_few_chords_keeps_to_the_accelerations():
    turns = [math.pi * index / 8 for index in range(9)]
    corners = [(0.05 * math.sin(turn), 0.05 * (1 - math.cos(turn))) for turn in turns]
    assert hardest(timed(corners, MotionLimits((1.0, 1.0), (2.0, 2.0)))) <= 2.0 * (1 + 1e-6)


def test_a_build_up_brakes_before_the_bend_that_it_must_be_slow_in():
    straight = [index / 20 for index in range(20)]
    bend = [1.57 * index / 20 for index in range(21)]
    corners = [
        *((x, 0.0) for x in straight),
        *((1 + 0.05 * math.sin(turn), 0.05 * (1 - math.cos(turn))) for turn in bend),
        *((1.05, 0.05 + y) for y in straight[1:]),
    ]
    path = timed(corners, MotionLimits((1.0, 1.0), (2.0, 2.0), jerk_s=0.3))
    assert hardest(path, 1000) <= 2.02


@given(any_corners, motion_limits())
def test_it_passes_every_corner_in_order_and_stays_on_its_chords(corners, limits):
    path = timed(corners, limits)
    assert list(path.times_s) == sorted(path.times_s)
    assert path.times_s[0] == 0.0
    assert path.times_s[-1] == path.duration_s
    for (a, b), (begin_s, end_s) in zip(
        pairwise(path.corners), pairwise(path.times_s), strict=True
    ):
        point = path.at((begin_s + end_s) / 2)
        way, done = math.dist(a, b), math.dist(a, point)
        assert done + math.dist(point, b) == pytest.approx(way, abs=SKIPPED)


@given(any_corners, motion_limits(), st.floats(0.01, 0.5))
def test_pieces_are_the_whole_motion_and_no_faster_than_the_limits(corners, limits, longest_s):
    path = timed(corners, limits)
    pieces = path.pieces(longest_s)
    total_s = math.fsum(piece.duration_s for piece in pieces)
    assert total_s == pytest.approx(path.duration_s, rel=1e-9)
    before = path.corners[0]
    for piece in pieces:
        for a, b, limit in zip(before, piece.point, limits.speeds, strict=True):
            assert abs(b - a) <= limit * piece.duration_s * (1 + 1e-6) + SKIPPED
        before = piece.point
    assert before == path.corners[-1] or not pieces


# Laws of profiles: no limit passed, exact ends, symmetry, and never slower for a wider limit.

sizes = st.floats(1e-3, 1e3)
profile_limits = sizes | st.just(math.inf)
windows = st.just(0.0) | st.floats(0.05, 2.0)
SHARES = [index / 64 for index in range(65)]


@st.composite
def profiles(draw):
    """A profile of any shape, its distance and limits, and the build-up of its acceleration."""
    distance, speed, acceleration = draw(sizes), draw(profile_limits), draw(profile_limits)
    if math.inf == speed == acceleration:
        speed = 1.0
    plain, share = trapezoid(distance, speed, acceleration), draw(windows)
    window_s = share * plain.duration_s if acceleration < math.inf else 0.0
    profile = averaged(plain, window_s) if window_s else plain
    return profile, distance, speed, acceleration, window_s


def profile_moments(profile):
    """Times all over a profile, both sides of every change of phase included."""
    times = [share * profile.duration_s for share in SHARES]
    for end_s in profile.ends_s:
        times += [end_s * (1 - 1e-12), end_s, end_s * (1 + 1e-12)]
    return sorted(times)


@given(profiles())
def test_no_limit_is_passed_from_rest_to_rest_and_it_never_runs_back(made):
    profile, distance, speed, acceleration, window_s = made
    states = [profile.at(t_s) for t_s in profile_moments(profile)]
    for _, fast, hard in states:
        assert 0.0 <= fast <= speed * (1 + 1e-9)
        assert abs(hard) <= acceleration * (1 + 1e-9)
    assert all(b[0] >= a[0] - 1e-12 * distance for a, b in pairwise(states))
    for phase in profile.phases:
        assert abs(phase.jerk) * window_s <= 2.0 * acceleration * (1 + 1e-9)
    assert profile.at(0.0) == (0.0, 0.0, 0.0)
    assert profile.at(profile.duration_s) == (distance, 0.0, 0.0)
    last = profile.phases[-1]
    assert last.state(last.duration_s)[0] == pytest.approx(distance, rel=1e-9)


@given(profiles())
def test_speed_and_acceleration_join_from_phase_to_phase(made):
    profile, _, _, acceleration, window_s = made
    top = max(phase.speed for phase in profile.phases)
    for before, after in pairwise(profile.phases):
        place, fast, hard = before.state(before.duration_s)
        assert after.distance == pytest.approx(place, rel=1e-9)
        assert after.speed == pytest.approx(fast, rel=1e-9, abs=1e-9 * top)
        if window_s:
            assert after.acceleration == pytest.approx(hard, abs=1e-6 * acceleration)


@given(profiles(), st.floats(0, 1))
def test_it_is_symmetric_and_when_is_the_inverse_of_at(made, share):
    profile, distance, *_ = made
    t_s = share * profile.duration_s
    there, back = profile.at(t_s)[0], profile.at(profile.duration_s - t_s)[0]
    assert there + back == pytest.approx(distance, rel=1e-9)
    when_s = profile.when(share * distance)
    assert 0.0 <= when_s <= profile.duration_s
    assert profile.at(when_s)[0] == pytest.approx(share * distance, rel=1e-9, abs=1e-9 * distance)


@every_row(
    "limits, duration_s, phases",
    [
        ((10.0, 2.0, math.inf), 5.0, 1),
        ((10.0, 2.0, 4.0), 5.5, 3),  # distance / speed + speed / acceleration
        ((4.0, 100.0, 4.0), 2.0, 2),  # 2 sqrt(distance / acceleration)
        ((0.0, 1.0, 1.0), 0.0, 0),
    ],
)
def test_each_shape_takes_the_time_of_its_formula(limits, duration_s, phases):
    profile = trapezoid(*limits)
    assert profile.duration_s == pytest.approx(duration_s, rel=1e-12)
    assert len(profile.phases) == phases


def test_a_build_up_adds_its_time_and_seven_phases_are_the_double_s():
    profile = averaged(trapezoid(10.0, 2.0, 4.0), 0.1)
    assert profile.duration_s == pytest.approx(5.6, rel=1e-12)
    assert [round(phase.jerk) for phase in profile.phases] == [40, 0, -40, 0, -40, 0, 40]


@every_row(
    "given_limits, named",
    [
        ((-1.0, 1.0, 1.0), "distance"),
        ((math.nan, 1.0, 1.0), "distance"),
        ((1.0, 0.0, 1.0), "speed"),
        ((1.0, 1.0, -1.0), "acceleration"),
        ((1.0, math.inf, math.inf), "both be infinite"),
    ],
)
def test_what_makes_no_profile_is_refused_by_name(given_limits, named):
    with pytest.raises(KinematicsError, match=named):
        trapezoid(*given_limits)
