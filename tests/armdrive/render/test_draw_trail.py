"""The driven way and the outline of the reach: bounded, honest about gaps, worked out seldom."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from space_cases import HERE, guarded, six_axes

from armdrive.render.figure import dome
from armdrive.render.scene import (
    LEAP,
    MOST_OUTLINES,
    MOST_PIECES,
    PIECE,
    ArmDrawing,
    Moment,
    Trail,
    key_of,
    outline,
)
from kinematics import Joints
from kinematics.five_axis.workspace import section

REACH_MM = 452.0


def strokes(trail):
    return [stroke for layer in (*trail.full, trail.latest) for stroke in layer.strokes]


@given(st.lists(st.none() | st.floats(-400.0, 400.0), max_size=900))
def test_the_way_is_bounded_and_holds_no_leap(xs):
    trail = Trail(REACH_MM)
    for x in xs:
        trail.add(None if x is None else (x, 0.0, 0.0))
    assert len(trail.full) <= MOST_PIECES
    for stroke in strokes(trail):
        assert 2 <= len(stroke.points) <= PIECE
        for one, other in pairwise(stroke.points):
            assert math.dist(one, other) <= LEAP * REACH_MM


def test_a_way_goes_on_from_piece_to_piece():
    trail = Trail(REACH_MM)
    for step in range(3 * PIECE):
        trail.add((step * 5.0, 0.0, 0.0))
    pieces = strokes(trail)
    assert len(pieces) > 2
    for one, following in pairwise(pieces):
        assert one.points[-1] == following.points[0]


def test_full_pieces_are_the_same_ones_until_they_are_forgotten():
    trail = Trail(REACH_MM)
    for step in range(PIECE):
        trail.add((step * 5.0, 0.0, 0.0))
    first = trail.full[0]
    for step in range(PIECE):
        trail.add((1000.0 - step * 5.0, 0.0, 0.0))
    assert trail.full[0] is first


def test_a_lost_position_ends_the_way_and_clearing_forgets_it():
    trail = Trail(REACH_MM)
    for x in (0.0, 20.0, None, 40.0, 60.0):
        trail.add(None if x is None else (x, 0.0, 0.0))
    assert [len(stroke.points) for stroke in strokes(trail)] == [2, 2]
    trail.clear()
    assert strokes(trail) == []
    trail.add((80.0, 0.0, 0.0))
    assert [len(stroke.points) for stroke in strokes(trail)] == [2]


def test_an_arm_that_stands_leaves_no_way():
    scene = ArmDrawing(guarded())
    for _ in range(50):
        scene.space(Moment(HERE))
    assert strokes(scene.trail) == []


@pytest.mark.parametrize("pitch_deg", [-90, -35, 0])
def test_the_outline_of_the_mini_movers_build_is_that_of_kinematics(pitch_deg):
    arm = guarded().arm
    key = key_of(arm, math.radians(pitch_deg + 1.0), math.radians(3.0))
    assert key == (pitch_deg, 0)
    found = outline(arm, key)
    cut = section(arm, math.radians(pitch_deg), 0.0)
    box = [point for curve in found.curves for point in curve]
    low_x, high_x, low_z, high_z = cut.box_mm
    assert min(x for x, _ in box) == pytest.approx(low_x, abs=2.0)
    assert max(x for x, _ in box) == pytest.approx(high_x, abs=2.0)
    assert min(z for _, z in box) == pytest.approx(low_z, abs=2.0)
    assert max(z for _, z in box) == pytest.approx(high_z, abs=2.0)
    assert found.words == f"reach at pitch {pitch_deg}"


def test_the_outline_of_any_other_arm_is_within_its_dome_and_not_far_from_it():
    arm = six_axes().arm
    assert key_of(arm, 1.0, 2.0) == (0, 0)
    (curve,) = outline(arm, (0, 0)).curves
    whole = dome(arm)
    reached = [math.hypot(r, z - whole.centre[2]) for r, z in curve]
    assert 0.75 * whole.reach_mm < max(reached) <= whole.reach_mm
    heights = [z for _, z in curve]
    assert heights == sorted(heights)


def test_the_last_outline_stays_until_the_next_one_is_there():
    scene = ArmDrawing(guarded())
    assert not reach(scene.space(Moment(HERE)))
    key = scene.missing
    scene.keep(key, scene.work_out(key))
    first = scene.space(Moment(HERE))
    assert scene.missing is None
    assert first.reach == "reach at pitch -80"
    turned = scene.space(Moment(Joints.of(20.0, 60.0, -80.0, 0.0, 15.0)))
    assert scene.missing == (-20, 15)
    assert turned.reach == first.reach


def reach(space):
    return [layer for layer in space.sheets[-2] if layer.strokes]


def test_no_more_outlines_are_kept_than_there_is_room_for():
    scene = ArmDrawing(guarded())
    scene.space(Moment(HERE))
    found = scene.work_out(scene.missing)
    for pitch in range(MOST_OUTLINES + 40):
        scene.keep((pitch, 0), found)
    assert len(scene._outlines) == MOST_OUTLINES
