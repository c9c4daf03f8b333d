"""Circular arcs through three points: where they lead, how exactly, and what is refused."""

import dataclasses
import math
from itertools import pairwise

import pytest
from amounts import amount, every_row
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from kinematics_cases import PUMA, TEACHMOVER, UNEVEN, same_pose
from kinematics_cases import START as PUMA_START
from route_cases import START, at, point, pose, poses, sharpest_deg, tip, turn_deg

from kinematics import (
    ArcPart,
    JointPart,
    Joints,
    LinePart,
    NoArc,
    PathBroken,
    PosePart,
    Route,
    route_sections,
)
from kinematics.frames.vectors import cross, dot, subtract, unit
from kinematics.paths.chords import corners, cut, posture_at
from kinematics.paths.curves import round_through
from kinematics.paths.routes import blend, lay

POINTS = st.tuples(*[st.floats(-400.0, 400.0)] * 3)
SHARES = st.floats(0.0, 1.0)


def arc_path(arm, start, via, goal, tolerance_mm=0.5, *, sweep_rad=None):
    """The corners of a route of one arc."""
    route = Route(start, (ArcPart(via, goal, sweep_rad=sweep_rad),))
    (section,) = route_sections(arm, route, tolerance_mm)
    return section.corners


def off_circle(arc, place):
    """How far a point is from a circle in space, in mm."""
    normal = unit(cross(arc.out, arc.ahead))
    off = subtract(place, arc.centre)
    height = dot(off, normal)
    flat = math.sqrt(max(dot(off, off) - height * height, 0.0))
    return math.hypot(height, flat - arc.radius_mm)


def swept(arc, place):
    off = subtract(place, arc.centre)
    return math.atan2(dot(off, arc.ahead), dot(off, arc.out)) % math.tau


def sampled(arm, corners, parts=5):
    return [
        tip(arm, at(a, b, index / parts))
        for a, b in pairwise(corners)
        for index in range(parts + 1)
    ]


@given(POINTS, POINTS, POINTS, SHARES)
def test_every_point_of_an_arc_has_its_radius(start, via, goal, share):
    try:
        arc = round_through(start, via, goal)
    except NoArc:
        return
    assume(arc.radius_mm < 1e5)
    rounding_mm = 1e-12 * arc.radius_mm**2 + 1e-9
    assert off_circle(arc, arc.at(share)) <= rounding_mm
    assert math.dist(arc.at(0.0), start) <= rounding_mm
    assert arc.at(1.0) == goal
    assert off_circle(arc, via) <= rounding_mm
    assert 0.0 < swept(arc, via) < arc.sweep_rad < math.tau + 1e-9
    back = round_through(goal, via, start)
    assert math.dist(back.at(1.0 - share), arc.at(share)) <= 1e3 * rounding_mm


@given(poses, poses, poses, st.sampled_from((0.05, 0.5, 2.0)))
def test_the_tip_stays_within_the_tolerance_of_the_circle(first, via, goal, tolerance):
    start = TEACHMOVER.solve(first)
    assume(start is not None)
    try:
        corners = arc_path(TEACHMOVER, start, via, goal, tolerance)
    except (NoArc, PathBroken):
        return
    assert corners[0] == start
    assert same_pose(TEACHMOVER.fk(corners[-1]), goal, mm=1e-4)
    arc = round_through(point(TEACHMOVER.fk(start)), point(via), point(goal))
    ways = sampled(TEACHMOVER, corners)
    assert max(off_circle(arc, place) for place in ways) <= tolerance
    assert sharpest_deg(corners) <= 15.0


def test_an_arc_passes_its_via_point_and_turns_the_hand_in_proportion_to_the_sweep():
    via, goal = pose(300, 0, 150, 40, 77), pose(250, 100, 120, -30, 60)
    corners = arc_path(TEACHMOVER, START, via, goal, 0.2)
    assert min(math.dist(place, point(via)) for place in sampled(TEACHMOVER, corners, 50)) < 0.5
    arc = round_through(point(TEACHMOVER.fk(START)), point(via), point(goal))
    for joints in corners[1:]:
        here = TEACHMOVER.fk(joints)
        share = swept(arc, point(here)) / arc.sweep_rad
        assert here.pitch_deg == pytest.approx(-90 + 60 * share, abs=1e-6)
        assert here.roll_deg == pytest.approx(60 * share, abs=1e-6)


@every_row("sweep_deg, x_mm, y_mm", [(90, 280, -70), (270, 220, -70)])
def test_a_sweep_ends_an_arc_before_or_beyond_its_third_point(sweep_deg, x_mm, y_mm):
    goal = pose(250, -40, 120, -50)
    corners = arc_path(
        TEACHMOVER, START, pose(280, -70, 120), goal, sweep_rad=math.radians(sweep_deg)
    )
    assert same_pose(TEACHMOVER.fk(corners[-1]), pose(x_mm, y_mm, 120, -50), mm=1e-6)


@every_row(
    "via, goal, words",
    [
        (pose(250, -100, 120), pose(250, 0, 120), "start and via point are the same point"),
        (pose(250, 0, 120), pose(250, 0, 120), "via point and goal are the same point"),
        (pose(280, -70, 120), pose(250, -100, 120), "for a full circle another point of it"),
        (
            pose(250, 0, 120),
            pose(250, 50, 120),
            "lie in a line, to within 0.000 mm; use a straight",
        ),
        (pose(250, 90, 120), pose(250, 50, 120), "lie in a line"),
    ],
)
def test_points_that_draw_no_circle_are_refused(via, goal, words):
    with pytest.raises(NoArc, match=words) as refused:
        arc_path(TEACHMOVER, START, via, goal)
    assert refused.value.off_mm < 0.01


def test_an_arc_that_leaves_the_reach_says_where():
    words = r"arc of part 1 of the route breaks at .* an arc that keeps clear"
    with pytest.raises(PathBroken, match=words) as broken:
        arc_path(TEACHMOVER, START, pose(440, 0, 120), pose(250, 100, 120))
    assert broken.value.shape == "arc"
    assert 0.0 < broken.value.fraction < 1.0
    place = point(broken.value.point)
    arc = round_through(point(TEACHMOVER.fk(START)), (440, 0, 120), (250, 100, 120))
    assert math.dist(place, arc.at(broken.value.fraction)) < 1e-6
    assert TEACHMOVER.solve(broken.value.point) is None


@settings(max_examples=amount(3, 30))
@given(st.floats(20.0, 60.0), st.floats(-0.4, 0.4))
def test_an_arc_of_six_joints_is_round_and_turns_the_hand_evenly(wide, yaw):
    here = PUMA.fk(PUMA_START)
    via = dataclasses.replace(here, x_mm=here.x_mm - wide, y_mm=here.y_mm - wide)
    goal = dataclasses.replace(here, x_mm=here.x_mm - 2 * wide, yaw_rad=here.yaw_rad + yaw)
    corners = arc_path(PUMA, PUMA_START, via, goal)
    arc = round_through(point(here), point(via), point(goal))
    assert max(off_circle(arc, place) for place in sampled(PUMA, corners, 3)) <= 0.5
    end = PUMA.fk(corners[-1])
    assert math.dist(point(end), point(goal)) < 1e-3
    assert end.yaw_rad == pytest.approx(goal.yaw_rad, abs=1e-4)
    assert sharpest_deg(corners) <= 15.0


# Blends past the point between two parts: how near, how smooth, and where there is none.


RADII = st.floats(1.0, 60.0)
VIA = pose(290, 20, 100)
NEXT = {
    "line": LinePart(pose(200, 90, 160, -70, 30)),
    "arc": ArcPart(pose(250, 80, 110), pose(200, 90, 160, -70, 30)),
    "joint": JointPart(Joints.of(40, 60, -90, -20, 30)),
    "pose": PosePart(pose(200, 90, 160, -70, 30)),
}
FIRST = {
    "line": LinePart(VIA),
    "arc": ArcPart(pose(290, -60, 130), VIA),
    "joint": JointPart(TEACHMOVER.ik(VIA)),
    "pose": PosePart(VIA),
}
PAIRS = [(first, after) for first in FIRST for after in NEXT]


def laid(start, *moves):
    """The chords of parts that can be followed, or nothing."""
    try:
        return [part.chords for part in lay(TEACHMOVER, start, moves, 0.5)]
    except (PathBroken, NoArc):
        return None


def smooth_join(arm, before, after, found):
    """The angles in joint space between a blend and its neighbours where they meet, in degrees."""
    nudge = 1e-5
    start, end = posture_at(before, found.leave), posture_at(after, found.enter)
    pairs = (
        (posture_at(before, found.leave - nudge), start, found.curve.solve(nudge, start)),
        (found.curve.solve(1.0 - nudge, end), end, posture_at(after, found.enter + nudge)),
    )
    for one, middle, two in pairs:
        ways = [
            tuple(b - a for a, b in zip(x, y, strict=True))
            for x, y in ((one, middle), (middle, two))
        ]
        yield turn_deg(*ways)


@pytest.mark.parametrize(("first", "after"), PAIRS)
@settings(max_examples=amount(4, 200))
@given(radius=RADII, share=st.floats(0.0, 1.0))
def test_a_blend_stays_within_its_radius_and_has_no_corners(first, after, radius, share):
    before, behind = laid(START, FIRST[first], NEXT[after])
    found = blend(TEACHMOVER, before, behind, radius)
    via = tip(TEACHMOVER, before[-1].end)
    assert found.radius_mm <= radius + 1e-6
    assert math.dist(found.curve.tip(share), via) <= found.radius_mm + 0.05
    assert max(smooth_join(TEACHMOVER, before, behind, found)) < 1.0
    assert 0.5 <= found.leave < 1.0
    assert 0.0 < found.enter <= 0.5


@given(poses, poses, poses, RADII, st.floats(0.0, 1.0))
def test_a_blend_of_lines_is_begun_at_its_radius_or_half_way(first, via, goal, radius, share):
    start = TEACHMOVER.solve(first)
    assume(start is not None)
    chords = laid(start, LinePart(via), LinePart(goal))
    assume(chords is not None)
    halves = [
        math.dist(point(TEACHMOVER.fk(start)), point(via)),
        math.dist(point(via), point(goal)),
    ]
    expected = min(radius, *(half / 2.0 for half in halves))
    assume(expected > 1e-2)
    found = blend(TEACHMOVER, *chords, radius)
    assert found.radius_mm == pytest.approx(expected)
    for end in (0.0, 1.0):
        assert math.dist(found.curve.tip(end), point(via)) == pytest.approx(expected)
    assert math.dist(found.curve.tip(share), point(via)) <= expected + 1e-9
    try:
        path = cut(TEACHMOVER, found.curve, posture_at(chords[0], found.leave), 0.5)
    except PathBroken:
        return
    assert len(path) >= 8
    for chord in path:
        ideal = found.curve.tip(chord.low + share * (chord.high - chord.low))
        assert math.dist(tip(TEACHMOVER, at(chord.start, chord.end, share)), ideal) <= 0.5


def test_a_joint_blend_keeps_every_joint_within_its_range():
    high = TEACHMOVER.limits[2].high_rad
    start, via = Joints.of(0, 60, -40, -60, 0), Joints.of(20, 40, math.degrees(high), -60, 0)
    line = LinePart(TEACHMOVER.fk(Joints.of(40, 45, -30, -50, 0)))
    before, behind = laid(start, JointPart(via), line)
    found = blend(TEACHMOVER, before, behind, 50.0)
    for joints in corners(cut(TEACHMOVER, found.curve, posture_at(before, found.leave), 0.5)):
        assert not TEACHMOVER.violations(joints)


def test_a_blend_that_would_break_names_the_part_before_it():
    """Both lines pass the arm's foot at a distance that it reaches; the blend would not."""
    start = UNEVEN.ik(pose(-35, -236, 50))
    far = JointPart(UNEVEN.ik(pose(-35, -236, 60), start))
    near = LinePart(pose(-35, -236, 50))
    parts = (far, near, LinePart(pose(150, 0, 50), 200.0), LinePart(pose(-35, 236, 50)))
    words = r"the blend of part 3 of the route breaks at .* use a smaller blend radius, or none"
    with pytest.raises(PathBroken, match=words) as broken:
        route_sections(UNEVEN, Route(start, parts))
    assert broken.value.part == 3
    assert broken.value.shape == "blend"
    calm = (*parts[:2], LinePart(pose(150, 0, 50), 20.0), parts[-1])
    assert len(route_sections(UNEVEN, Route(start, calm))) == 3
