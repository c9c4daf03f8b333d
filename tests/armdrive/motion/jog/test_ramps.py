"""Laws of a jog's arithmetic: ramps, and braking before a bound."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armdrive.motion.jog.course import braking_share, ramped, shares_to_stop
from kinematics.presets import preset

BOUNDS = tuple((one.low_rad, one.high_rad) for one in preset("teachmover").arm.limits)
SHARES = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
POSTURES = st.tuples(*[st.floats(low, high) for low, high in BOUNDS])


@given(SHARES, SHARES, st.floats(0.05, 2.0), st.floats(0.01, 1.0))
def test_a_ramp_never_changes_faster_than_its_slope_and_arrives(now, wish, ramp_s, time_s):
    slope = 1.0 / ramp_s
    mean, end = ramped(now, wish, ramp_s, time_s)
    for a, middle, b, there in zip(now, mean, wish, end, strict=True):
        assert abs(there - a) <= slope * time_s + 1e-9
        assert min(a, b) - 1e-9 <= there <= max(a, b) + 1e-9
        assert min(a, there) - 1e-9 <= middle <= max(a, there) + 1e-9
    for _ in range(int(2.0 / (slope * time_s)) + 2):
        _, now = ramped(now, wish, ramp_s, time_s)
    assert now == pytest.approx(wish, abs=1e-9)


@given(SHARES, st.floats(0.0, 2.0), st.floats(0.01, 1.0))
def test_a_ramp_from_rest_goes_in_the_direction_of_the_wish_from_the_first_moment(
    wish, ramp_s, time_s
):
    mean, end = ramped((0.0, 0.0, 0.0), wish, ramp_s, time_s)
    for made in (mean, end):
        assert all(
            abs(a * d - b * c) <= 1e-9
            for a, b, c, d in ((made[i], made[j], wish[i], wish[j]) for i, j in ((0, 1), (1, 2)))
        )


@given(st.floats(0.0, 5.0), st.floats(0.01, 0.5), st.floats(0.0, 2.0))
def test_braking_ends_at_the_bound_and_is_never_beyond_it(way_s, time_s, ramp_s):
    speed, left = 1.0, way_s
    for _ in range(400):
        share = braking_share(left / speed, time_s, ramp_s * speed) if speed else 0.0
        speed *= share
        left -= speed * time_s
        assert left >= -1e-9
        assert speed * speed * ramp_s <= 2.0 * left + 1e-9
    assert left <= 1e-6


def test_braking_from_afar_keeps_the_speed():
    assert braking_share(10.0, 0.05, 0.2) == 1.0
    assert braking_share(0.15, 0.05, 0.2) == pytest.approx(1.0)
    assert braking_share(0.0, 0.05, 0.2) == braking_share(-1.0, 0.05, 0.2) == 0.0
    assert braking_share(0.02, 0.05, 0.0) == pytest.approx(0.4)


@given(POSTURES, st.tuples(*[st.floats(-2.0, 2.0)] * 5))
def test_joints_that_are_slowed_to_stop_end_within_their_limits(angles, rates):
    for _ in range(60):
        ramps_s = [abs(rate) / 5.0 for rate in rates]
        left = [(low - a, high - a) for a, (low, high) in zip(angles, BOUNDS, strict=True)]
        shares = shares_to_stop(left, rates, 0.05, ramps_s)
        rates = tuple(rate * share for rate, share in zip(rates, shares, strict=True))
        angles = tuple(a + rate * 0.05 for a, rate in zip(angles, rates, strict=True))
        for angle, (low, high) in zip(angles, BOUNDS, strict=True):
            assert low - 1e-9 <= angle <= high + 1e-9
