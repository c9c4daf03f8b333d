"""Axes that each go their own way: trapezoids, a grid of chances, stops and new goals."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armdrive.sim.mechanics.motors import MotorDrive
from armdrive.sim.mechanics.profiles import UncoordinatedRack
from armdrive.sim.world import World

SLOPE = 700.0
GRID_S = 0.008
FIRST_S = 0.08
"""A motion is so much shorter than a trapezoid: its first step comes at once."""
goals = st.integers(-3000, 3000)
rates = st.floats(1.0, 500.0)
moments = st.floats(0.0, 30.0)
grids = st.sampled_from([0.0, GRID_S])


def rack(grid_s=0.0, axes=1):
    return UncoordinatedRack((0,) * axes, acceleration_hz_s=SLOPE, grid_s=grid_s, stagger_s=0.001)


def pauses_s(one, until_s):
    """Return how long one axis waited before each step but the first."""
    times = [look * 0.0005 for look in range(round(until_s / 0.0005))]
    counts = [one.positions(at_s)[0] for at_s in times]
    made = [
        at_s for at_s, (a, b) in zip(times[1:], itertools.pairwise(counts), strict=True) if a != b
    ]
    return [b - a for a, b in itertools.pairwise(made)]


def test_steps_come_when_they_came_on_the_firmware():
    """Seen in AVR cycles: 50 steps at a commanded 100 with 700 steps/s^2."""
    one = UncoordinatedRack((0,), acceleration_hz_s=SLOPE, grid_s=0.00804)
    one.move_at(0, 50, 100.0, 0.0)
    seen_s = [0.0241, 0.0241, *[0.0161] * 44, 0.0241, 0.0241, 0.0402]
    assert pauses_s(one, 1.0) == pytest.approx(seen_s, abs=0.0011)


def test_a_trapezoid_lasts_as_long_as_its_speed_and_ramps_say():
    one = rack()
    one.move_at(0, 1000, 200.0, 5.0)
    ramp_s = 200 / SLOPE
    assert one.done_s == pytest.approx(5.0 + 1000 / 200 + ramp_s, abs=FIRST_S)
    assert one.speeds(5.0 + ramp_s / 2) == (pytest.approx(100.0, rel=0.4),)
    assert one.positions(5.0 + ramp_s + 1.0)[0] == pytest.approx(
        200 * ramp_s / 2 + 200, abs=200 * FIRST_S
    )
    assert one.positions(one.done_s) == (1000,)


def test_each_axis_finishes_when_it_finishes():
    one = rack(axes=3)
    for axis, goal in enumerate((40, -400, 0)):
        one.move_at(axis, goal, 100.0, 0.0)
    assert one.mask(0.1) == 0b011
    assert one.mask(1.0) == 0b010
    assert one.positions(1.0)[0] == 40
    assert one.done_s == pytest.approx(4.0 + 100 / SLOPE, abs=FIRST_S)
    one.settle(one.done_s)
    assert (one.moving, one.done_s) == (False, math.inf)


@pytest.mark.parametrize(("commanded_hz", "actual_hz"), [(100.0, 62.5), (400.0, 125.0)])
def test_on_the_grid_a_step_waits_for_its_chance(commanded_hz, actual_hz):
    one = rack(GRID_S)
    one.move_at(0, 2000, commanded_hz, 0.0)
    made = one.positions(11.0)[0] - one.positions(1.0)[0]
    assert made == pytest.approx(10 * actual_hz, abs=2)


def test_an_open_ended_run_goes_on_until_it_is_told_otherwise():
    one = rack(GRID_S)
    one.run(0, -50.0, 0.0)
    assert math.isinf(one.done_s)
    assert one.positions(600.0)[0] < -20_000
    one.run(0, 0.0, 600.0)
    assert one.done_s <= 600.0
    assert one.positions(1000.0) == one.positions(600.0)


@given(goals, rates, moments, st.floats(0.0, 0.5), grids)
def test_it_never_turns_back_nor_exceeds_its_rate_and_ends_at_its_goal(goal, rate, at, pause, grid):
    one = rack(grid)
    one.move_at(0, goal, rate, 0.0)
    here, there = one.positions(at)[0], one.positions(at + pause)[0]
    way = 1 if goal > 0 else -1
    assert 0 <= here * way <= there * way <= abs(goal)
    assert abs(there - here) <= rate * pause + 1 + (grid > 0)
    assert one.positions(one.done_s) == (goal,)


@given(goals, goals, rates, st.floats(0.0, 5.0), grids)
def test_a_new_goal_in_mid_motion_is_reached_without_a_jump(goal, other, rate, at, grid):
    one = rack(grid)
    one.move_at(0, goal, rate, 0.0)
    before = one.positions(at)
    one.move_at(0, other, rate, at)
    assert one.positions(at) == before
    assert abs(one.positions(at + 0.001)[0] - before[0]) <= 1
    assert one.positions(one.done_s) == (other,)


@given(goals, rates, st.floats(0.0, 5.0))
def test_a_ramped_stop_needs_what_the_acceleration_says(goal, rate, at):
    one = rack()
    one.move_at(0, goal, rate, 0.0)
    before, speed = one.positions(at)[0], one.speeds(at)[0]
    one.ramp_down(at)
    end = one.positions(at + 10.0)[0]
    assert abs(end - before) <= speed**2 / (2 * SLOPE) + 1
    if speed:
        assert one.done_s <= at + abs(speed) / SLOPE + 1 / abs(speed) + FIRST_S
        assert one.positions(at + 100.0) == (end,)


@given(goals, rates, st.floats(0.0, 5.0), grids)
def test_a_dead_stop_stays_where_it_was_and_counts_on(goal, rate, at, grid):
    one = rack(grid)
    one.move_at(0, goal, rate, 0.0)
    before = one.positions(at)[0]
    one.stop(at)
    assert one.positions(at + 9.0) == (before,)
    one.count((5,))
    assert one.positions(at + 9.0) == (before + 5,)
    one.zero()
    assert one.positions(at + 9.0) == (0,)


class Watched(World):
    """A world that remembers when it was turned."""

    def __init__(self):
        self.times = []
        super().__init__()

    def force(self, steps, time_s=0.0):
        self.times.append(time_s)
        super().force(steps, time_s)


@pytest.mark.parametrize("looks", [1, 200])
def test_the_arm_goes_the_crooked_way_however_seldom_somebody_looks(looks):
    world = Watched()
    drive = MotorDrive(world, rack(axes=len(world.motors)))
    start = world.motors
    drive.follow(100.0)
    drive.rack.move_at(0, 100, 100.0, 100.0)
    drive.rack.move_at(1, -300, 100.0, 100.0)
    for look in range(1, looks + 1):
        drive.follow(100.0 + 5.0 * look / looks)
    assert world.motors - start == (100, -300, 0, 0, 0, 0)
    assert len(world.times) > 20
    assert max(b - a for a, b in itertools.pairwise(world.times)) < 0.15
