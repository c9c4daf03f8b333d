"""Distances between segments, and from segments to boxes and to the base column."""

import math

import pytest
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st

from kinematics import KinematicsError
from kinematics.guards.shapes import Box, Column, point_distance_mm, segment_distance_mm

BOX = Box("vice", (-30.0, -50.0, 0.0), (40.0, 60.0, 80.0))
WALL = Box("wall", (-1.0, -200.0, -200.0), (1.0, 200.0, 200.0))
COLUMN = Column(0.0, 0.0, 60.0, 150.0)
SOLIDS = (BOX, WALL, COLUMN)

lengths = st.sampled_from((-60.0, 0.0, 40.0)) | st.floats(-250.0, 250.0)
points = st.tuples(lengths, lengths, lengths)
solids = st.sampled_from(SOLIDS)
shifts = st.tuples(*[st.floats(-15.0, 15.0)] * 3)


def along(a, b, count):
    for index in range(count + 1):
        yield tuple(p + (q - p) * index / count for p, q in zip(a, b, strict=True))


def moved(p, by):
    return tuple(one + other for one, other in zip(p, by, strict=True))


@given(points, points, points, points)
def test_no_two_points_of_two_segments_are_nearer_than_their_distance(a, b, c, d):
    exact = segment_distance_mm(a, b, c, d)
    nearest = min(point_distance_mm(p, c, d) for p in along(a, b, 60))
    assert exact <= nearest + 1e-9
    assert nearest - exact <= math.dist(a, b) / 120.0 + 1e-9
    assert segment_distance_mm(d, c, a, b) == pytest.approx(exact, abs=1e-6)


@pytest.mark.parametrize(
    ("second", "distance"),
    [
        (((50, -10, 7), (50, 10, 7)), 7.0),
        (((0, 4, 3), (100, 4, 3)), 5.0),
        (((130, 0, 40), (130, 0, 40)), 50.0),
        (((50, 30, 0), (50, 90, 0)), 30.0),
        (((20, 0, 0), (60, 0, 0)), 0.0),
        (((50, -10, 0), (50, 10, 0)), 0.0),
    ],
)
def test_crossing_parallel_and_shrunken_segments_have_their_distance(second, distance):
    assert segment_distance_mm((0, 0, 0), (100, 0, 0), *second) == pytest.approx(distance)


@given(points, points, st.sampled_from((BOX, WALL)))
def test_no_point_of_a_segment_outside_is_nearer_to_a_box_than_its_distance(a, b, box):
    distance = box.distance_mm(a, b)
    nearest = min(box.point_distance_mm(p) for p in along(a, b, 100))
    if distance > 0.0:
        assert distance <= nearest + 1e-9
        assert nearest - distance <= math.dist(a, b) / 200.0 + 1e-9
    if nearest == 0.0:
        assert distance <= 0.0


@given(points, points, st.sampled_from((BOX, WALL)), points)
def test_no_shorter_way_than_the_depth_leads_out_of_a_box(a, b, box, way):
    depth, length = -box.distance_mm(a, b), math.hypot(*way)
    if depth <= 1e-6 or length < 1.0:
        return
    by = tuple(one / length * depth * 0.99 for one in way)
    assert box.distance_mm(moved(a, by), moved(b, by)) < 1e-9


@given(points, points, st.sampled_from((BOX, WALL)), st.floats(0.0, 40.0))
def test_each_side_of_a_box_is_a_way_out_and_none_is_shorter_than_the_depth(a, b, box, radius):
    off = box.distance_mm(a, b) - radius
    if off >= 0.0:
        return
    for by in box.ways_out_mm(a, b, radius):
        assert box.distance_mm(moved(a, by), moved(b, by)) >= radius - 1e-6
        assert math.hypot(*by) >= -off - 1e-6


@given(points, points)
def test_a_segment_along_an_edge_is_measured_like_one_beside_it(a, b):
    straight = (a, (a[0], a[1], b[2]))
    tilted = (a, (a[0] + 1e-7, a[1], b[2]))
    assert BOX.distance_mm(*straight) == pytest.approx(BOX.distance_mm(*tilted), abs=1e-3)


@given(solids, points, points, shifts, shifts)
@settings(max_examples=amount(50, 1000))
def test_a_signed_distance_changes_by_no_more_than_the_ends_travel(solid, a, b, first, second):
    before = solid.distance_mm(a, b)
    after = solid.distance_mm(moved(a, first), moved(b, second))
    assert abs(after - before) <= max(math.hypot(*first), math.hypot(*second)) + 1e-5


@given(points, points)
def test_the_least_distance_from_the_column_is_found_along_a_segment(a, b):
    exact = COLUMN.distance_mm(a, b)
    nearest = min(COLUMN.distance_mm(p, p) for p in along(a, b, 100))
    assert exact <= nearest + 1e-6
    assert nearest - exact <= math.dist(a, b) / 200.0 + 1e-6


@pytest.mark.parametrize(
    ("point", "distance"),
    [
        ((100, 0, 20), 40.0),
        ((0, 30, 170), 20.0),
        ((63, 0, 154), 5.0),
        ((0, 40, 50), -20.0),
        ((10, 0, 140), -10.0),
        ((0, 0, -500), -60.0),
    ],
)
def test_the_column_stands_on_the_table_and_ends_at_its_top(point, distance):
    assert COLUMN.distance_mm(point, point) == pytest.approx(distance)


def test_a_thin_wall_that_is_pierced_further_is_deeper():
    depths = [-WALL.distance_mm((-100.0, 0.0, 0.0), (x, 0.0, 0.0)) for x in (5.0, 20.0, 60.0)]
    assert depths == pytest.approx([6.0, 21.0, 61.0])


def test_a_segment_that_cuts_a_corner_leaves_across_it():
    depth = -BOX.distance_mm((90.0, 0.0, 40.0), (0.0, 90.0, 40.0))
    assert depth == pytest.approx(10.0 / math.sqrt(2.0))


@pytest.mark.parametrize(
    ("name", "low", "high", "words"),
    [
        ("", (0, 0, 0), (1, 1, 1), "needs a name"),
        ("vice", (0, 0, 5), (1, 1, 5), "needs a z of min_mm below"),
        ("vice", (0, 0), (1, 1, 1), "needs x, y and z"),
        ("vice", (0, 0, math.nan), (1, 1, 1), "min_mm of 'vice'"),
    ],
)
def test_what_is_no_box_is_refused(name, low, high, words):
    with pytest.raises(KinematicsError, match=words):
        Box(name, low, high)
