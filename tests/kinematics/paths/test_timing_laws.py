"""Laws of timed paths along any corners: no limit is passed, as sampled differences tell.

Speeds are those between two moments on the chords, accelerations those of the direction that turns
evenly from the middle of each chord to that of the next, times the speed along the path. Both
are bounded exactly; the tolerance of 1e-6 is the rounding of differences over short times.
"""

import math
from bisect import bisect_right
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinematics.paths.timing import MotionLimits, timed

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


@given(any_corners, motion_limits(jerks=(0.02, 0.3)))
def test_what_changes_an_acceleration_along_the_path_takes_its_time(corners, limits):
    path = timed(corners, limits)
    if not limits.ramps or not path.duration_s:
        return
    direction = directions(path)
    for phase in path.profile.phases:
        for part, limit in zip(direction(phase.distance), limits.accelerations, strict=True):
            if part:
                assert abs(part * phase.jerk) <= 2 * limit / limits.jerk_s * (1 + 1e-6)


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


@given(any_corners, motion_limits())
def test_the_way_back_takes_as_long(corners, limits):
    there, back = timed(corners, limits), timed(corners[::-1], limits)
    assert back.duration_s == pytest.approx(there.duration_s, rel=1e-6)


@given(any_corners, motion_limits(), st.floats(1, 20))
def test_wider_limits_never_take_longer(corners, limits, wider):
    path = timed(corners, limits)
    eased = MotionLimits(
        limits.speeds,
        tuple(limit * wider for limit in limits.accelerations),
        limits.jerk_s,
        limits.motors,
        limits.motor_hz,
    )
    assert timed(corners, eased).duration_s <= path.duration_s * (1 + 1e-9)
    assert path.duration_s >= path.marks[-1] * (1 - 1e-9)  # never less than at full speed
