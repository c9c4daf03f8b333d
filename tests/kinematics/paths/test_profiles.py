"""Laws of profiles: no limit passed, exact ends, symmetry, and never slower for a wider limit."""

import math
from itertools import pairwise

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from kinematics import KinematicsError
from kinematics.paths.profiles import jerk_limited, trapezoid

sizes = st.floats(1e-3, 1e3)
limits = sizes | st.just(math.inf)
SHARES = [index / 64 for index in range(65)]


@st.composite
def profiles(draw):
    """A profile of any shape, and its distance and limits."""
    distance, speed, acceleration, jerk = draw(sizes), draw(limits), draw(limits), draw(limits)
    if math.inf == speed == acceleration == jerk:
        speed = 1.0
    return jerk_limited(distance, speed, acceleration, jerk), distance, speed, acceleration, jerk


def moments(profile):
    """Times all over a profile, both sides of every change of jerk included."""
    times = [share * profile.duration_s for share in SHARES]
    for end_s in profile.ends_s:
        times += [end_s * (1 - 1e-12), end_s, end_s * (1 + 1e-12)]
    return sorted(times)


@given(profiles())
def test_no_limit_is_passed(made):
    profile, _, speed, acceleration, jerk = made
    for t_s in moments(profile):
        _, fast, hard = profile.at(t_s)
        assert 0.0 <= fast <= speed * (1 + 1e-9)
        assert abs(hard) <= acceleration * (1 + 1e-9)
    assert all(abs(phase.jerk) <= jerk * (1 + 1e-9) for phase in profile.phases)


@given(profiles())
def test_it_runs_from_rest_to_rest_and_never_back(made):
    profile, distance, *_ = made
    assert profile.at(0.0) == (0.0, 0.0, 0.0)
    assert profile.at(profile.duration_s) == (distance, 0.0, 0.0)
    places = [profile.at(t_s)[0] for t_s in moments(profile)]
    assert all(b >= a - 1e-12 * distance for a, b in pairwise(places))
    last = profile.phases[-1]
    assert last.state(last.duration_s)[0] == pytest.approx(distance, rel=1e-9)


@given(profiles())
def test_speed_and_acceleration_join_from_phase_to_phase(made):
    profile, *_, jerk = made
    top = max(phase.speed for phase in profile.phases)
    for before, after in pairwise(profile.phases):
        place, fast, hard = before.state(before.duration_s)
        assert after.distance == pytest.approx(place, rel=1e-9)
        assert after.speed == pytest.approx(fast, rel=1e-9, abs=1e-9 * top)
        if jerk < math.inf:
            assert after.acceleration == pytest.approx(hard, rel=1e-9, abs=1e-9 * abs(hard) + 1e-12)


@given(profiles(), st.floats(0, 1))
def test_it_is_symmetric(made, share):
    profile, distance, *_ = made
    t_s = share * profile.duration_s
    there, back = profile.at(t_s)[0], profile.at(profile.duration_s - t_s)[0]
    assert there + back == pytest.approx(distance, rel=1e-9)


@given(profiles(), st.sampled_from((1, 2, 3)), st.floats(1, 100))
def test_a_wider_limit_never_takes_longer(made, which, wider):
    profile, distance, *given_limits = made
    given_limits[which - 1] *= wider
    assert jerk_limited(distance, *given_limits).duration_s <= profile.duration_s * (1 + 1e-9)


@given(profiles(), st.floats(1, 100))
def test_a_longer_way_never_takes_less(made, longer):
    profile, distance, *given_limits = made
    assert jerk_limited(distance * longer, *given_limits).duration_s >= profile.duration_s * (
        1 - 1e-9
    )


@given(profiles(), st.floats(0.001, 0.999))
def test_speed_and_acceleration_are_those_of_the_distance(made, share):
    profile, *_ = made
    for phase in profile.phases:
        middle_s, aside_s = share * phase.duration_s, 1e-4 * phase.duration_s
        low, here, high = (phase.state(middle_s + side * aside_s) for side in (-1, 0, 1))
        bend = abs(phase.jerk) * aside_s**2 / 6  # what a cubic's difference misses
        for derivative in (1, 2):
            slope = (high[derivative - 1] - low[derivative - 1]) / (2 * aside_s)
            rounding = abs(here[derivative - 1]) / aside_s * 1e-14
            assert slope == pytest.approx(here[derivative], rel=1e-9, abs=1.01 * bend + rounding)


@given(profiles(), st.floats(0, 1))
def test_when_is_the_inverse_of_at(made, share):
    profile, distance, *_ = made
    t_s = profile.when(share * distance)
    assert 0.0 <= t_s <= profile.duration_s
    assert profile.at(t_s)[0] == pytest.approx(share * distance, rel=1e-9, abs=1e-12 * distance)


@given(profiles())
def test_nothing_quicker_keeps_the_limits(made):
    """Some limit is reached in the middle: of the speed, or else of what lies below it."""
    profile, _, speed, acceleration, jerk = made
    fastest = max(phase.state(phase.duration_s)[1] for phase in profile.phases)
    hardest = max(abs(phase.acceleration) for phase in profile.phases)
    swiftest = max(abs(phase.jerk) for phase in profile.phases)
    assert (
        fastest >= speed * (1 - 1e-9)
        or hardest >= acceleration * (1 - 1e-9)
        or swiftest >= jerk * (1 - 1e-9)
    )


@every_row(
    "limits, duration_s, phases",
    [
        ((10.0, 2.0, math.inf, math.inf), 5.0, 1),
        ((10.0, 2.0, 4.0, math.inf), 5.5, 3),  # distance / speed + speed / acceleration
        ((4.0, 100.0, 4.0, math.inf), 2.0, 2),  # 2 sqrt(distance / acceleration)
        ((10.0, 2.0, 4.0, 40.0), 5.6, 7),  # and the time that the acceleration builds up
        ((2.0, 100.0, 100.0, 1.0), 4.0, 4),  # cbrt(32 distance / jerk)
        ((10.0, 1.0, 100.0, 4.0), 11.0, 5),  # the acceleration is not reached, the speed is
        ((6.0, 100.0, 1.0, 1.0), 6.0, 6),  # the speed is not reached, the acceleration is
        ((2.0, 100.0, math.inf, 1.0), 4.0, 4),
        ((0.0, 1.0, 1.0, 1.0), 0.0, 0),
    ],
)
def test_each_shape_takes_the_time_of_its_formula(limits, duration_s, phases):
    profile = jerk_limited(*limits)
    assert profile.duration_s == pytest.approx(duration_s, rel=1e-12)
    assert len(profile.phases) == phases


def test_a_trapezoid_is_the_profile_of_infinite_jerk():
    assert trapezoid(3.0, 2.0, 5.0) == jerk_limited(3.0, 2.0, 5.0, math.inf)


@every_row(
    "given_limits, named",
    [
        ((-1.0, 1.0, 1.0, 1.0), "distance"),
        ((math.nan, 1.0, 1.0, 1.0), "distance"),
        ((1.0, 0.0, 1.0, 1.0), "speed"),
        ((1.0, 1.0, -1.0, 1.0), "acceleration"),
        ((1.0, 1.0, 1.0, math.nan), "jerk"),
        ((1.0, math.inf, math.inf, math.inf), "all be infinite"),
    ],
)
def test_what_makes_no_profile_is_refused_by_name(given_limits, named):
    with pytest.raises(KinematicsError, match=named):
        jerk_limited(*given_limits)
