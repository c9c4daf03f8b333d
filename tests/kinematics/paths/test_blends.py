"""Blends past the point between two parts: how near, how smooth, and where there is none."""

import math

import pytest
from amounts import amount
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from kinematics_cases import TEACHMOVER, UNEVEN
from route_cases import START, at, point, pose, poses, tip, turn_deg

from kinematics import (
    ArcPart,
    JointPart,
    Joints,
    KinematicsError,
    LinePart,
    NoArc,
    PathBroken,
    PosePart,
    Route,
    route_sections,
)
from kinematics.paths.chords import corners, cut, posture_at
from kinematics.paths.routes import blend, lay

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


def test_a_blend_of_lines_turns_the_hand_from_the_one_to_the_other():
    before, behind = laid(START, LinePart(pose(250, 0, 120, -60, 40)), LinePart(pose(150, 0, 120)))
    found = blend(TEACHMOVER, before, behind, 20.0)
    middle = found.curve.pose(0.5)
    leaves, enters = found.curve.pose(0.0), found.curve.pose(1.0)
    assert middle.pitch_deg == pytest.approx((leaves.pitch_deg - 120 + enters.pitch_deg) / 4)
    assert middle.roll_deg == pytest.approx((leaves.roll_deg + 80 + enters.roll_deg) / 4)


def test_a_point_on_a_straight_line_is_passed_on_it():
    before, behind = laid(START, LinePart(pose(250, 0, 120)), LinePart(pose(250, 100, 120)))
    found = blend(TEACHMOVER, before, behind, 30.0)
    for share in (0.1, 0.5, 0.8):
        x, y, z = found.curve.tip(share)
        assert (x, z) == pytest.approx((250, 120))
        assert -30 < y < 30


def test_a_tip_that_stands_still_along_a_line_is_not_blended():
    turn = LinePart(pose(250, -100, 120, -60), blend_mm=20)
    sections = route_sections(TEACHMOVER, Route(START, (turn, LinePart(pose(250, 0, 120)))))
    assert [section.parts for section in sections] == [(1,), (2,)]
    assert [section.blends_mm for section in sections] == [(0.0,), (0.0,)]


def test_an_arc_is_left_at_most_a_quarter_of_a_turn_before_its_end():
    circle = ArcPart(pose(280, -70, 120), pose(250, -40, 120), sweep_rad=math.tau)
    before, behind = laid(START, circle, LinePart(pose(250, 0, 120)))
    found = blend(TEACHMOVER, before, behind, 100.0)
    assert found.leave == pytest.approx(0.75)
    assert found.radius_mm == pytest.approx(30 * math.sqrt(2))


def test_a_joint_blend_keeps_every_joint_within_its_range():
    high = TEACHMOVER.limits[2].high_rad
    start, via = Joints.of(0, 60, -40, -60, 0), Joints.of(20, 40, math.degrees(high), -60, 0)
    line = LinePart(TEACHMOVER.fk(Joints.of(40, 45, -30, -50, 0)))
    before, behind = laid(start, JointPart(via), line)
    found = blend(TEACHMOVER, before, behind, 50.0)
    for joints in corners(cut(TEACHMOVER, found.curve, posture_at(before, found.leave), 0.5)):
        assert not TEACHMOVER.violations(joints)


def test_a_wrist_that_only_rolls_is_blended_in_the_joints():
    roll = JointPart(START.replace(wrist_roll=1.0), blend_mm=5.0)
    away = JointPart(START.replace(wrist_roll=1.0, base=START["base"] + 0.5))
    (section,) = route_sections(TEACHMOVER, Route(START, (roll, away)))
    assert section.parts == (1, 2)
    assert section.corners[-1] == away.goal


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


def test_a_blend_radius_is_a_length():
    for move in (LinePart, PosePart):
        with pytest.raises(KinematicsError, match="blend_mm must not be less than 0"):
            move(VIA, blend_mm=-1.0)
    with pytest.raises(KinematicsError, match="blend_mm"):
        ArcPart(VIA, VIA, blend_mm=math.nan)
