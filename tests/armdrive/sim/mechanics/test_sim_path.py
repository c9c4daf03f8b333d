"""Queued lines with lookahead: along the path, within the limits, and exactly to the end."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from armdrive.sim.mechanics.planner import PathLimits, PathRack

LIMITS = PathLimits((80.0, 80.0, 20.0), (50.0, 50.0, 20.0), (500.0, 500.0, 200.0))
LONGEST_S = 1e3
deltas = st.tuples(*[st.integers(-2000, 2000)] * 3).filter(any)
ways = st.lists(st.tuples(deltas, st.floats(0.5, 100.0)), min_size=1, max_size=6)


def laid(way, pauses=()):
    rack, now = PathRack((0, 0, 0), LIMITS), 0.0
    for (steps, rate), pause in itertools.zip_longest(way, pauses[: len(way)], fillvalue=0.0):
        now += pause
        rack.settle(now)
        assert rack.queue(steps, rate, now)
    return rack, now


def straight(steps, rate=25.0):
    return laid([(steps, rate)])[0]


def test_one_line_is_a_trapezoid():
    rack = straight((8000, 0, 0))
    assert rack.done_s == pytest.approx(100 / 25 + 25 / 500)
    assert rack.speed(1.0) == pytest.approx(25.0)
    assert rack.positions(1.0)[0] == pytest.approx(80 * (25 - 25 * 25 / 1000), abs=1)
    assert rack.positions(rack.done_s) == (8000, 0, 0)


def test_a_line_without_steps_is_none():
    rack = PathRack((0, 0, 0), LIMITS)
    assert not rack.queue((0, 0, 0), 10.0, 0.0)
    assert not rack.moving


def test_a_rapid_goes_as_fast_as_its_axes_allow():
    rack = PathRack((0, 0, 0), LIMITS)
    rack.queue((8000, 8000, 0), 0.0, 0.0, rapid=True)
    assert rack.speed(1.0) == pytest.approx(50 * math.sqrt(2))


def test_lines_in_one_direction_are_followed_as_one():
    whole = straight((8000, 0, 0))
    cut, _ = laid([((1000, 0, 0), 25.0)] * 8)
    assert cut.done_s == pytest.approx(whole.done_s)
    assert cut.speed(1.0) == pytest.approx(25.0)


def test_a_path_that_turns_round_stands_for_a_moment():
    rack, _ = laid([((800, 0, 0), 25.0), ((-800, 0, 0), 25.0)])
    assert rack.speed(rack.done_s / 2) == pytest.approx(0.0, abs=1e-6)


def test_a_square_corner_is_passed_at_the_speed_of_the_junction_deviation():
    rack, _ = laid([((8000, 0, 0), 25.0), ((0, 8000, 0), 25.0)])
    half = math.sqrt(0.5)
    along = 500.0 / half  # both axes share the turn
    at_corner = rack.speed(rack.next_line_s)
    assert at_corner == pytest.approx(math.sqrt(along * 0.01 * half / (1 - half)))


def test_a_line_that_ends_makes_room_for_another():
    rack, _ = laid([((800, 0, 0), 25.0)] * 3)
    assert rack.waiting == 3
    first_s, second_s = rack.bends(0.0, rack.done_s)
    assert first_s == rack.next_line_s < second_s < rack.done_s
    rack.settle(rack.next_line_s)
    assert rack.waiting == 2
    assert rack.goal == (2400, 0, 0)


@given(ways, st.lists(st.floats(0.0, 2.0), max_size=6), st.floats(0.0, 1.0))
def test_every_axis_keeps_its_limits_and_the_path_ends_exactly(way, pauses, share):
    rack, now = laid(way, pauses)
    end = tuple(map(sum, zip(*(steps for steps, _ in way), strict=True)))
    assert rack.positions(rack.done_s) == end == rack.goal
    at = now + share * (rack.done_s - now)
    pause = 0.01
    here, there = rack.positions(at), rack.positions(at + pause)
    for a, b, rate, per in zip(here, there, LIMITS.most_rate, LIMITS.steps_per_unit, strict=True):
        assert abs(b - a) <= rate * per * pause * (1 + 1e-9) + 1
    assert rack.speed(at) <= max(rate for _, rate in way) * (1 + 1e-9)
    change = abs(rack.speed(at + 1e-4) - rack.speed(at))
    assert change <= 1e-4 * math.hypot(*LIMITS.acceleration) * (1 + 1e-6)
    rack.settle(rack.done_s)
    assert (rack.moving, rack.waiting) == (False, 0)


@given(deltas, st.floats(0.5, 100.0), st.floats(0, 1), st.floats(0, 1))
def test_along_a_line_no_motor_turns_back(steps, rate, first, second):
    rack = straight(steps, rate)
    low, high = (share * rack.done_s for share in sorted((first, second)))
    for goal, a, b in zip(steps, rack.positions(low), rack.positions(high), strict=True):
        assert 0 <= a * goal <= b * goal <= goal * goal


@given(ways, st.floats(0.0, 1.0), st.floats(0.0, 3.0))
def test_a_hold_stands_still_soon_and_what_is_left_is_finished_later(way, share, pause):
    rack, now = laid(way)
    end, now = rack.goal, share * rack.done_s
    speed, before = rack.speed(now), rack.positions(now)
    rack.hold(now)
    assert rack.positions(now) == before
    assert rack.speed(now) == pytest.approx(speed, abs=1e-9)
    least = min(LIMITS.acceleration)
    still = min(rack.done_s, now + speed / least)
    after = rack.positions(still + 1.0)
    gone = [(b - a) / per for a, b, per in zip(before, after, LIMITS.steps_per_unit, strict=True)]
    slack = 2 * math.hypot(*(1 / per for per in LIMITS.steps_per_unit))
    assert math.hypot(*gone) <= speed**2 / (2 * least) + slack
    assert rack.positions(still + 2.0) == after
    rack.settle(still)
    assert not rack.moving
    rack.resume(still + pause)
    assert rack.positions(still + pause) == after
    if rack.moving:
        assert rack.positions(rack.done_s) == end


@given(ways, st.floats(0.0, 1.0), st.floats(0.1, 2.0))
def test_an_override_changes_the_time_and_never_the_way(way, share, scale):
    rack, _ = laid(way)
    now = share * rack.done_s
    assume(now < rack.done_s)
    speed, end = rack.speed(now), rack.goal
    rack.override(scale, 1.0, now)
    assert rack.speed(now) == pytest.approx(speed, abs=1e-9)
    if rack.moving:
        assert rack.done_s < LONGEST_S * 100
        assert rack.positions(rack.done_s) == end


def test_a_dead_stop_drops_every_line():
    rack, _ = laid([((8000, 0, 0), 25.0)] * 3)
    before = rack.positions(1.0)
    rack.stop(1.0)
    assert rack.positions(9.0) == before == rack.goal
    assert (rack.moving, rack.waiting, rack.held) == (False, 0, False)
    rack.count((5, 0, 0))
    rack.queue((10, 0, 0), 25.0, 2.0)
    assert rack.positions(rack.done_s)[0] == before[0] + 15
    rack.stop(9.0)
    rack.zero()
    assert rack.positions(9.0) == (0, 0, 0)
