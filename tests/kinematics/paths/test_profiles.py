"""Laws of profiles: no limit passed, exact ends, symmetry, and never slower for a wider limit."""

import math
from itertools import pairwise

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from kinematics import KinematicsError
from kinematics.paths.profiles import averaged, trapezoid

sizes = st.floats(1e-3, 1e3)
limits = sizes | st.just(math.inf)
windows = st.just(0.0) | st.floats(0.05, 2.0)
SHARES = [index / 64 for index in range(65)]


@st.composite
def profiles(draw):
    """A profile of any shape, its distance and limits, and the build-up of its acceleration."""
    distance, speed, acceleration = draw(sizes), draw(limits), draw(limits)
    if math.inf == speed == acceleration:
        speed = 1.0
    plain, share = trapezoid(distance, speed, acceleration), draw(windows)
    window_s = share * plain.duration_s if acceleration < math.inf else 0.0
    profile = averaged(plain, window_s) if window_s else plain
    return profile, distance, speed, acceleration, window_s


def moments(profile):
    """Times all over a profile, both sides of every change of phase included."""
    times = [share * profile.duration_s for share in SHARES]
    for end_s in profile.ends_s:
        times += [end_s * (1 - 1e-12), end_s, end_s * (1 + 1e-12)]
    return sorted(times)


@given(profiles())
def test_no_limit_is_passed_from_rest_to_rest_and_it_never_runs_back(made):
    profile, distance, speed, acceleration, window_s = made
    states = [profile.at(t_s) for t_s in moments(profile)]
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


@given(profiles(), st.floats(1, 100))
def test_a_wider_limit_never_takes_longer_and_a_longer_way_never_less(made, wider):
    _, distance, speed, acceleration, _ = made
    took_s = trapezoid(distance, speed, acceleration).duration_s
    assert trapezoid(distance, wider * speed, acceleration).duration_s <= took_s * (1 + 1e-9)
    assert trapezoid(distance, speed, wider * acceleration).duration_s <= took_s * (1 + 1e-9)
    assert trapezoid(wider * distance, speed, acceleration).duration_s >= took_s * (1 - 1e-9)


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
