"""Motors in proportion, known at every moment without ticking."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armdrive.errors import BadRequest
from armdrive.sim.mechanics.motors import DEFAULT_RATES, MotorRack, MotorSpeed, rate_hz

steps = st.tuples(*[st.integers(-2000, 2000)] * 6)


def test_the_busiest_motor_turns_at_the_rate_and_the_others_in_proportion():
    rack = MotorRack((0, 0))
    rack.start((100, -50), 1 / 50.0, 10.0)
    assert rack.done_s == 12.0
    assert rack.positions(10.5) == (25, -12)
    assert rack.positions(11.0) == (50, -25)
    assert rack.positions(99.0) == (100, -50)


def test_a_stopped_motion_stays_where_it_was():
    rack = MotorRack((7, 0))
    rack.start((100, -50), 1 / 50.0, 0.0)
    rack.stop(0.5)
    assert rack.positions(9.0) == (32, -12)
    assert not rack.moving
    assert math.isinf(rack.done_s)


def test_a_motion_without_steps_is_over_at_once():
    rack = MotorRack((0, 0))
    rack.start((0, 0), 1 / 470.0, 3.0)
    assert rack.done_s == 3.0


@given(steps, st.floats(1, 1000), st.floats(0, 10))
def test_no_motor_overshoots_turns_back_or_leaves_the_straight_way(deltas, rate, at):
    rack = MotorRack((0,) * 6)
    rack.start(deltas, 1 / rate, 0.0)
    now, later = rack.positions(at), rack.positions(at + 0.1)
    busiest = max(map(abs, deltas))
    share = max(map(abs, now)) / busiest if busiest else 0.0
    for delta, a, b in zip(deltas, now, later, strict=True):
        assert abs(a) <= abs(b) <= abs(delta)
        assert a * delta >= 0
        assert abs(abs(a) - abs(delta) * share) <= 1.0
    assert rack.positions(rack.done_s) == deltas


@pytest.mark.parametrize(
    ("speed", "hz"),
    [(0, 30), (70, 90), (140, 150), (165, 200), (190, 250), (215, 360), (240, 470), (245, 470)],
)
def test_speeds_lie_on_straight_lines_between_the_known_ones(speed, hz):
    assert rate_hz(DEFAULT_RATES, speed, 0.0) == pytest.approx(hz)
    assert rate_hz(DEFAULT_RATES, speed, 0.2) == pytest.approx(hz / 1.2)
    assert rate_hz(DEFAULT_RATES, speed, -0.2) == pytest.approx(hz / 0.8)


@pytest.mark.parametrize("error", [-1.0, math.nan, math.inf, 1000.0])
def test_a_speed_error_that_no_arm_has_is_refused(error):
    with pytest.raises(BadRequest):
        MotorSpeed(0.0).set(error)
