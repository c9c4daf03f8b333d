"""Guards on postures, and the nearest pose outside them."""

import math
from dataclasses import replace

import pytest
from amounts import amount, every_row
from hypothesis import given, settings
from hypothesis import strategies as st
from kinematics_cases import (
    LAMP,
    LOOSE,
    TEACHMOVER,
    UNEVEN,
    VICE,
    distance_mm,
    postures,
    same_pose,
)

from kinematics import Guards, JointPath, Joints, Pose, first_violation, line_path, nearest_allowed
from kinematics.guards import AngleSum
from kinematics.guards.shapes import Box, Column, point_distance_mm, segment_distance_mm

GUARDS = Guards()


def at(x_mm, z_mm, pitch_deg, elbow="up", arm=LOOSE):
    pose = Pose.of(x_mm=x_mm, y_mm=0, z_mm=z_mm, pitch_deg=pitch_deg)
    for branch in arm.branches(pose):
        if branch.name == f"base front, elbow {elbow}":
            return branch.joints
    raise AssertionError("not in reach")


@every_row("z_mm, broken", [(0.0, False), (-0.9, False), (-1.1, True)])
def test_the_table_has_a_tolerance(z_mm, broken):
    violation = GUARDS.violation(LOOSE, at(250, z_mm, -90))
    assert (violation is not None) == broken


def test_below_the_table_says_which_point_and_how_deep():
    violation = GUARDS.violation(LOOSE, at(250, -12, -90))
    assert (violation.guard, violation.quantity) == ("table", "tip z")
    assert (violation.value, violation.bound) == (pytest.approx(-12), 0.0)
    assert violation.excess_mm == pytest.approx(12)
    assert violation.sentence == "the tip would be 12.0 mm below the table"


@every_row(
    "x_mm, z_mm, broken",
    [(56, 300, True), (58, 300, False), (57, 300, False), (40, 380, True), (40, 382, False)],
)
def test_the_body_is_kept_clear(x_mm, z_mm, broken):
    violation = GUARDS.violation(LOOSE, at(x_mm, z_mm, 0))
    assert (violation is not None) == broken
    if broken:
        assert violation.guard == "inner radius"
        assert violation.excess_mm == pytest.approx(min(57 - x_mm, 381 - z_mm))


def test_the_outer_radius_is_kept():
    arm = replace(LOOSE, hand_mm=120.0)
    violation = GUARDS.violation(arm, at(460, 193.7, 0, arm=arm))
    assert violation.guard == "outer radius"
    assert violation.excess_mm == pytest.approx(7)
    assert Guards(outer_radius_mm=None).violation(arm, at(460, 193.7, 0, arm=arm)) is None


def test_a_hand_that_points_backwards_into_the_base_is_refused():
    only_hand = Guards(inner_radius_mm=None)
    violation = only_hand.violation(LOOSE, at(40, 20, -110))
    assert violation.guard == "hand against base"
    assert "points backwards" in violation.sentence
    assert only_hand.violation(LOOSE, at(40, 20, -90)) is None
    assert only_hand.violation(LOOSE, at(40, 40, -110)) is None
    assert only_hand.violation(LOOSE, at(60, 20, -110)) is None
    assert only_hand.violation(LOOSE, at(50, 20, -150)) is None  # the wrist is far enough out


# Guards on the links as capsules, and on sums of joints: what each says and what it leaves out.


OPEN = Guards(inner_radius_mm=None, outer_radius_mm=None, hand_wrist_radius_mm=None, table=False)
"""No guard at all, so that the one of a test stands alone."""

THICK = replace(OPEN, radii_mm=(35.0, 30.0, 25.0))
BASED = replace(THICK, base_radius_mm=60.0, base_top_mm=150.0)
BOXED = replace(THICK, boxes=(VICE,))
FOREARM = AngleSum(
    "forearm elevation",
    (("shoulder", 1.0), ("elbow", 1.0)),
    math.radians(-100.0),
    math.radians(45.0),
)
DOWN = -math.pi / 2


def broken(guards, joints, arm=LOOSE):
    return {(one.guard, one.quantity): one for one in guards.violations(arm, joints)}


def over(x_mm, z_mm, y_mm=0.0):
    return TEACHMOVER.ik(Pose(x_mm, y_mm, z_mm, DOWN))


def test_a_hand_keeps_its_radius_above_a_box():
    assert broken(BOXED, over(190, 90)) == {}
    assert broken(BOXED, over(190, 85)) == {}
    assert broken(BOXED, over(190, 84.1)) == {}
    found = broken(BOXED, over(190, 80))
    assert set(found) == {("box vice", "hand")}
    one = found["box vice", "hand"]
    assert (one.value, one.bound) == (pytest.approx(-5.0), 0.0)
    assert one.excess_mm == pytest.approx(5.0)
    assert one.sentence == "the hand would be 5.0 mm inside the box 'vice'"


def test_a_forearm_folded_onto_the_base_is_refused():
    folded = Joints.of(0, 30, -160, 90, 0)
    found = broken(BASED, folded)
    assert ("base column", "forearm") in found
    one = found["base column", "forearm"]
    assert "inside the base column (radius 60 mm, up to z 150 mm)" in one.sentence
    elbow, wrist = LOOSE.points(folded)[2:4]
    assert one.excess_mm == pytest.approx(30.0 - COLUMN.distance_mm(elbow, wrist))
    assert broken(BASED, Joints.of(0, 60, -95, -35, 0)) == {}


def test_a_hand_folded_onto_the_upper_arm_is_refused():
    found = broken(THICK, Joints.of(0, 60, -150, -150, 0))
    one = found["arm against itself", "hand against the upper arm"]
    _, shoulder, elbow, wrist, tip = LOOSE.points(Joints.of(0, 60, -150, -150, 0))
    apart = segment_distance_mm(wrist, tip, shoulder, elbow)
    assert one.excess_mm == pytest.approx(35.0 + 25.0 - apart, abs=SEARCHED_MM)
    assert one.sentence.startswith("the hand would be ")
    assert broken(THICK, Joints.of(0, 60, -95, -35, 0)) == {}


@every_row("elbow_deg, value_deg", [(-141.0, -101.0), (6.0, 46.0)])
def test_a_forearm_beyond_its_elevation_is_refused_in_degrees(elbow_deg, value_deg):
    guards = replace(OPEN, sums=(FOREARM,))
    found = guards.violation(LOOSE, Joints.of(0, 40, elbow_deg, 0, 0))
    bound_deg = -100.0 if value_deg < 0 else 45.0
    assert found.guard == "range of the forearm elevation"
    assert math.degrees(found.value) == pytest.approx(value_deg)
    assert math.degrees(found.bound) == pytest.approx(bound_deg)
    assert found.excess_mm == pytest.approx(math.radians(1.0) * 452.1)
    assert f"would be {value_deg:.1f}°, 1.0° beyond its bound of {bound_deg:.1f}°" in found.sentence


# The nearest pose outside guards on links, boxes, and sums of joints.


BOXED_IN = Guards(radii_mm=(35.0, 30.0, 25.0), boxes=(VICE, LAMP))
ON_A_BASE = replace(BOXED_IN, boxes=(), base_radius_mm=60.0, base_top_mm=150.0)
LEVEL = AngleSum(
    "forearm elevation", (("shoulder", 1.0), ("elbow", 1.0)), math.radians(-95), math.radians(20)
)
SUMMED = Guards(sums=(LEVEL,))
AWAY = Joints.of(60, 60, -95, -35, 0)


def allowed(guards, pose, seed=None, arm=TEACHMOVER):
    joints = arm.solve(pose, seed)
    return joints is not None and not guards.violations(arm, joints)


@given(
    st.floats(100, 330),
    st.floats(-1.2, 1.2),
    st.floats(-20, 300),
    st.sampled_from((-1.57, -1.2, -0.6)),
    st.sampled_from((BOXED_IN, ON_A_BASE, SUMMED)),
)
def test_with_an_allowed_seed_there_is_always_an_answer_and_it_is_allowed(
    r, base, z, pitch, guards
):
    goal = Pose(r * math.cos(base), r * math.sin(base), z, pitch)
    assert not guards.violations(TEACHMOVER, AWAY)
    found = nearest_allowed(TEACHMOVER, guards, goal, AWAY)
    assert allowed(guards, found, AWAY)
    if allowed(guards, goal, AWAY):
        assert same_pose(found, goal, mm=1e-4)


def test_of_the_ways_up_and_back_the_shorter_is_taken():
    goal = Pose.of(x_mm=190, y_mm=0, z_mm=70, pitch_deg=-90)
    assert nearest_allowed(TEACHMOVER, BOXED_IN, goal).z_mm == pytest.approx(85, abs=0.01)
    back = nearest_allowed(TEACHMOVER, BOXED_IN, replace(goal, y_mm=70, z_mm=20), AWAY)
    assert distance_mm(back, goal) < 100.0


# Distances between segments, and from segments to boxes and to the base column.


BOX = Box("vice", (-30.0, -50.0, 0.0), (40.0, 60.0, 80.0))
WALL = Box("wall", (-1.0, -200.0, -200.0), (1.0, 200.0, 200.0))
COLUMN = Column(0.0, 0.0, 60.0, 150.0)
SOLIDS = (BOX, WALL, COLUMN)

lengths = st.sampled_from((-60.0, 0.0, 40.0)) | st.floats(-250.0, 250.0)
points = st.tuples(lengths, lengths, lengths)
solids = st.sampled_from(SOLIDS)
SEARCHED_MM = 0.01
"""A distance along a segment is searched for: it may be this much too long."""
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
    assert exact <= nearest + SEARCHED_MM
    assert nearest - exact <= math.dist(a, b) / 120.0 + 1e-9
    assert segment_distance_mm(d, c, a, b) == pytest.approx(exact, abs=SEARCHED_MM)


@given(points, points, st.sampled_from((BOX, WALL)))
def test_no_point_of_a_segment_outside_is_nearer_to_a_box_than_its_distance(a, b, box):
    distance = box.distance_mm(a, b)
    nearest = min(box.point_distance_mm(p) for p in along(a, b, 100))
    if distance > 0.0:
        assert distance <= nearest + SEARCHED_MM
        assert nearest - distance <= math.dist(a, b) / 200.0 + 1e-9
    if nearest == 0.0:
        assert distance <= 0.0


@given(solids, points, points, shifts, shifts)
@settings(max_examples=amount(50, 1000))
def test_a_signed_distance_changes_by_no_more_than_the_ends_travel(solid, a, b, first, second):
    before = solid.distance_mm(a, b)
    after = solid.distance_mm(moved(a, first), moved(b, second))
    assert abs(after - before) <= max(math.hypot(*first), math.hypot(*second)) + SEARCHED_MM


@every_row(
    "point, distance",
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


# Guards over whole paths: proved free, found where they begin, and always a way out.

HIGH_WALL = Box("wall", (-500.0, 200.0, -10.0), (500.0, 204.0, 600.0))
TIGHT_FOREARM = AngleSum("forearm elevation", (("shoulder", 1.0), ("elbow", 1.0)), -1.8, 0.8)
EVERYTHING = Guards(
    radii_mm=(35.0, 30.0, 25.0),
    base_radius_mm=50.0,
    base_top_mm=140.0,
    boxes=(VICE, HIGH_WALL, LAMP),
    sums=(TIGHT_FOREARM,),
)
POINTS = Guards()
ONLY_BOXES = replace(
    EVERYTHING,
    inner_radius_mm=None,
    outer_radius_mm=None,
    hand_wrist_radius_mm=None,
    base_radius_mm=None,
    sums=(),
)
UNSEEN_MM = 1.0
"""Half of the least distance between looks: nothing deeper than that passes unseen."""

LOOKS = 150


def densely(path):
    for index in range(LOOKS + 1):
        yield path.at(index / LOOKS)


def beyond_mm(guards, arm, joints):
    """How deep a posture is inside the guards and their tolerance."""
    worst = 0.0
    for one in guards.violations(arm, joints):
        loose = one.guard in ("table", "base column", "arm against itself") or "box" in one.guard
        worst = max(worst, one.excess_mm - guards.tolerance_mm * loose)
    return worst


@given(
    st.sampled_from((TEACHMOVER, UNEVEN)).flatmap(
        lambda arm: st.tuples(st.just(arm), postures(arm), postures(arm))
    ),
    st.sampled_from((POINTS, EVERYTHING, ONLY_BOXES)),
    st.sampled_from((0.02, 0.1, 0.5)),
)
@settings(max_examples=amount(30, 1000))
def test_what_is_proved_free_is_free_wherever_one_looks(case, guards, share):
    arm, start, goal = case
    path = JointPath(start, JointPath(start, goal).at(share))
    if guards.violations(arm, start):
        return
    found = first_violation(arm, guards, (path.start, path.goal))
    deepest = [beyond_mm(guards, arm, joints) for joints in densely(path)]
    if found is None:
        assert max(deepest) <= UNSEEN_MM + 1e-5
        return
    fraction, violation = found
    there = guards.violation(arm, path.at(fraction))
    assert there is not None
    assert there.excess_mm == pytest.approx(violation.excess_mm, abs=1e-3)
    before = deepest[: int(fraction * LOOKS)]
    travel_mm = arm.travel_bound_mm(path.changes_rad)
    spared = int(2.0 / max(travel_mm, 1e-9) * LOOKS) + 1
    assert max(before[: len(before) - spared] or [0.0]) <= UNSEEN_MM + 1e-5


@every_row(
    "name, start, goal, share",
    [
        ("box wall", (230, 130, 120), (230, 190, 120), 0.7),
        ("box lamp", (230, -90, 180), (250, -150, 180), 0.5),
        ("box vice", (280, 0, 20), (240, 0, 20), 0.5),
        ("table", (250, 100, 20), (250, 100, -20), 0.5),
        ("table", (250, -100, 120), (250, -100, -80), 0.6),
    ],
)
def test_the_first_guard_on_a_straight_line_is_named_where_it_begins(name, start, goal, share):
    before, behind = (
        Pose.of(**dict(zip(("x_mm", "y_mm", "z_mm"), one, strict=True)), pitch_deg=-80)
        for one in (start, goal)
    )
    waypoints = line_path(TEACHMOVER, TEACHMOVER.ik(before), behind)
    fraction, violation = first_violation(TEACHMOVER, ONLY_BOXES, waypoints)
    assert violation.guard == name
    assert fraction == pytest.approx(share, abs=0.15)
    assert 1.0 < violation.excess_mm <= 1.0 + 2.0


def test_a_sheet_between_two_free_postures_is_found():
    guards = replace(ONLY_BOXES, boxes=(Box("sheet", (200.0, -1.0, 0.0), (300.0, 1.0, 400.0)),))
    start, goal = (Joints.of(base_deg, 40, -60, -20, 0) for base_deg in (-40, 60))
    assert not guards.violations(TEACHMOVER, start) + guards.violations(TEACHMOVER, goal)
    fraction, violation = first_violation(TEACHMOVER, guards, (start, goal))
    assert violation.guard == "box sheet"
    assert 0.2 < fraction < 0.4


@given(st.floats(-60.0, -2.0), st.floats(-1.0, 1.0), st.floats(-0.6, 0.6))
def test_an_arm_below_the_table_may_rise_and_may_not_sink(z_mm, direction, turn):
    pose = Pose(260 * math.cos(direction), 260 * math.sin(direction), z_mm, -math.pi / 2)
    low = TEACHMOVER.ik(pose)
    above, below = (TEACHMOVER.ik(replace(pose, z_mm=z_mm + by)) for by in (80.0, -8.0))
    up = (low, above.replace(base=low["base"] + turn * 0.5))
    assert first_violation(TEACHMOVER, POINTS, up) is None
    assert first_violation(TEACHMOVER, POINTS, (low, below)) is not None


def test_a_way_out_leads_into_no_other_guard():
    inside = TEACHMOVER.ik(Pose.of(x_mm=250, y_mm=0, z_mm=30, pitch_deg=-90))
    guards = replace(ONLY_BOXES, boxes=(VICE,))
    assert guards.violation(TEACHMOVER, inside).guard == "box vice"
    out = TEACHMOVER.ik(Pose.of(x_mm=290, y_mm=0, z_mm=30, pitch_deg=-90))
    down = TEACHMOVER.ik(Pose.of(x_mm=290, y_mm=0, z_mm=-3, pitch_deg=-90))
    fraction, violation = first_violation(TEACHMOVER, guards, (inside, out, down))
    assert violation.guard == "table"
    assert fraction > 0.5


def test_a_sum_of_joints_beyond_its_range_comes_back_and_goes_no_further():
    guards = Guards(sums=(TIGHT_FOREARM,), outer_radius_mm=None, inner_radius_mm=None)
    beyond = Joints.of(0, 60, -5, 0, 0)
    back, on = Joints.of(0, 60, -30, 0, 0), Joints.of(0, 61, -5, 0, 0)
    aside = Joints.of(20, 62, -7, 10, 50)
    for goal, free in ((back, True), (aside, True), (on, False)):
        found = first_violation(TEACHMOVER, guards, (beyond, goal))
        assert (found is None) == free
