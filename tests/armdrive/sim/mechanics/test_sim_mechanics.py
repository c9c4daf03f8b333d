"""The mechanics of simulated devices: motors, coordinated paths, uncoordinated axes."""

import itertools
import math

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from armdrive.sim.mechanics.accelstepper import UncoordinatedRack
from armdrive.sim.mechanics.motors import MotorDrive, MotorRack
from armdrive.sim.mechanics.planner import PathLimits, PathRack
from armdrive.sim.mechanics.profiles import to_goal
from armdrive.sim.mechanics.shafts import ShaftPoint
from armdrive.sim.teachmover import rate_hz
from armdrive.sim.world import World

# -- Motors ----------------------------------------------------------------------------------------

steps = st.tuples(*[st.integers(-2000, 2000)] * 6)


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


@every_row(
    "speed, hz",
    [(0, 30), (70, 90), (140, 150), (165, 200), (190, 250), (215, 360), (240, 470), (245, 470)],
)
def test_speeds_lie_on_straight_lines_between_the_known_ones(speed, hz):
    assert rate_hz(speed, 0.0) == pytest.approx(hz)
    assert rate_hz(speed, 0.2) == pytest.approx(hz / 1.2)
    assert rate_hz(speed, -0.2) == pytest.approx(hz / 0.8)


@given(st.floats(-900, 900), st.floats(-5000, 5000), st.floats(10, 900), st.floats(0, 1))
def test_an_axis_goes_to_its_goal_from_any_speed_without_a_jump(speed, goal, rate, share):
    profile = to_goal(0.0, speed, goal, rate, 500.0, 0.0, 800.0)
    assert profile.at(profile.end_s) == goal
    assert profile.speed_at(0.0) == pytest.approx(speed)
    at, soon = share * profile.end_s, 1e-4
    here, there = profile.at(at), profile.at(at + soon)
    assert abs(there - here) <= max(abs(speed), rate) * soon + 1e-6
    change = profile.speed_at(at + soon) - profile.speed_at(at)
    assert abs(change) <= 800.0 * soon + 1e-6 or at + soon >= profile.end_s


@every_row("way", [1, -1])
def test_a_shaft_gains_speed_from_its_first_moment_on_and_brakes_before_its_goal(way):
    point = ShaftPoint(0)
    point.go_to(way * 1000, 100.0, 50.0, 1.0)
    assert [point.gain(at_s) for at_s in (1.0, 2.0, 5.0, point.end_s - 1.0)] == [50, 50, 0, -50]
    point = ShaftPoint(0)
    point.go_at(way * 100.0, 50.0, 1.0)
    assert point.gain(1.0) == 50


# -- Coordinated paths -----------------------------------------------------------------------------

LIMITS = PathLimits((80.0, 80.0, 20.0), (50.0, 50.0, 20.0), (500.0, 500.0, 200.0))
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


def test_a_dead_stop_drops_every_line():
    rack, _ = laid([((8000, 0, 0), 25.0)] * 3)
    before = rack.positions(1.0)
    rack.stop(1.0)
    assert rack.positions(9.0) == before == rack.goal
    assert (rack.moving, rack.waiting) == (False, 0)
    rack.count((5, 0, 0))
    rack.queue((10, 0, 0), 25.0, 2.0)
    assert rack.positions(rack.done_s)[0] == before[0] + 15
    rack.stop(9.0)
    rack.zero()
    assert rack.positions(9.0) == (0, 0, 0)


# -- Uncoordinated axes ----------------------------------------------------------------------------

SLOPE = 700.0
GRID_S = 0.008
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
