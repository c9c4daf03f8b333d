"""Routes of several parts: their sections, their laws, and what breaks them."""

import dataclasses
import math

import pytest
from amounts import amount
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from kinematics_cases import PUMA, TEACHMOVER, UNEVEN, same_pose
from kinematics_cases import START as PUMA_START
from route_cases import START, point, pose, poses, sharpest_deg, tip

from kinematics import (
    ArcPart,
    JointPart,
    Joints,
    LinePart,
    NoArc,
    PathBroken,
    PosePart,
    Route,
    line_path,
    route_sections,
)

VIA, GOAL = pose(250, 100, 120), pose(150, 100, 150, -70, 40)
RADII = st.sampled_from((0.0, 5.0, 30.0, 1000.0))


def sections(start, *parts, arm=TEACHMOVER, tolerance_mm=0.5):
    return route_sections(arm, Route(start, parts), tolerance_mm)


@given(poses, poses)
def test_a_route_of_one_line_is_that_line(first, goal):
    start = TEACHMOVER.solve(first)
    assume(start is not None)
    try:
        expected = line_path(TEACHMOVER, start, goal)
    except PathBroken:
        return
    (section,) = sections(start, LinePart(goal, blend_mm=10.0))
    assert section.corners == expected
    assert section.parts == (1,)
    assert section.blends_mm == (0.0,)


def test_without_blends_every_part_is_a_section_that_ends_exactly():
    arc = ArcPart(pose(200, 150, 120), GOAL)
    joints = Joints.of(10, 40, -80, -30, 20)
    found = sections(START, LinePart(VIA), arc, JointPart(joints), PosePart(VIA))
    assert [section.parts for section in found] == [(1,), (2,), (3,), (4,)]
    ends = [section.corners[-1] for section in found]
    starts = [section.corners[0] for section in found]
    assert starts == [START, *ends[:-1]]
    assert same_pose(TEACHMOVER.fk(ends[0]), VIA)
    assert same_pose(TEACHMOVER.fk(ends[1]), GOAL)
    assert ends[2] == joints
    assert ends[3] == TEACHMOVER.ik(VIA, joints)
    assert found[2].corners == (ends[1], joints)


def test_a_blend_joins_parts_into_one_section_and_says_its_radius():
    found = sections(
        START, LinePart(VIA, 20.0), LinePart(GOAL, 400.0), JointPart(START), PosePart(VIA, 10.0)
    )
    assert [section.parts for section in found] == [(1, 2, 3), (4,)]
    used = found[0].blends_mm
    assert used[0] == 20.0
    assert used[1] == pytest.approx(math.dist(point(VIA), point(GOAL)) / 2.0, abs=30.0)
    assert used[1] <= math.dist(point(VIA), point(GOAL)) / 2.0 + 1e-6
    assert used[2] == 0.0
    near = min(math.dist(tip(TEACHMOVER, one), point(VIA)) for one in found[0].corners)
    assert 5.0 < near < 11.0  # the parabola passes a corner of this angle at about half the radius


@settings(max_examples=amount(40, 1000))
@given(poses, poses, poses, poses, RADII, RADII)
def test_a_route_has_no_sharp_corners_and_breaks_by_name(first, one, two, three, near, far):
    start = TEACHMOVER.solve(first)
    assume(start is not None)
    parts = (LinePart(one, near), ArcPart(two, three, far), PosePart(one, near), LinePart(two))
    refused = None
    try:
        found = sections(start, *parts)
    except (PathBroken, NoArc) as broken:
        refused = broken
    if refused is not None:
        assert refused.part == 2 if isinstance(refused, NoArc) else refused.part in {1, 2, 3, 4}
        assert f"of part {refused.part} of the route" in str(refused)
        return
    assert found[0].corners[0] == start
    assert same_pose(TEACHMOVER.fk(found[-1].corners[-1]), two, mm=1e-4)
    assert [number for section in found for number in section.parts] == [1, 2, 3, 4]
    for section in found:
        assert sharpest_deg(section.corners) <= 15.0 + 1e-6
        assert len(section.corners) < 100 * len(section.parts)


def test_a_broken_part_is_named_with_its_point():
    far = pose(600, 100, 120, -20)
    with pytest.raises(PathBroken, match="straight line of part 2 of the route breaks") as broken:
        sections(START, LinePart(VIA), LinePart(far, 10.0), LinePart(VIA))
    assert broken.value.part == 2
    share = broken.value.fraction
    assert broken.value.point.x_mm == pytest.approx(250 + share * 350)


def test_a_pose_out_of_reach_names_its_part_and_a_pose_in_reach():
    with pytest.raises(PathBroken, match="nearest pose that can be reached") as broken:
        sections(START, LinePart(VIA), PosePart(pose(600, 100, 120, -20)))
    assert broken.value.part == 2
    assert broken.value.shape == "joint motion"
    assert TEACHMOVER.ik(broken.value.__cause__.nearest, START)


def test_lines_of_one_route_are_in_one_posture():
    start, other = Joints.of(0, 50, -60, -20, 0), Joints.of(20, 10, 60, -90, 0)
    begin = UNEVEN.fk(start)
    goal = dataclasses.replace(begin, y_mm=30.0)
    words = r"part 3 of the route breaks at 0% .*\(base front, elbow down\) than in part 1"
    with pytest.raises(PathBroken, match=words) as broken:
        sections(start, LinePart(goal), JointPart(other), LinePart(begin), arm=UNEVEN)
    assert broken.value.part == 3
    assert same_pose(broken.value.point, UNEVEN.fk(other))


@settings(max_examples=amount(3, 30))
@given(st.floats(20.0, 60.0), st.floats(5.0, 40.0))
def test_six_joints_follow_a_route(wide, radius):
    here = PUMA.fk(PUMA_START)
    via = dataclasses.replace(here, x_mm=here.x_mm - wide, yaw_rad=here.yaw_rad + 0.3)
    goal = dataclasses.replace(via, y_mm=here.y_mm - wide, pitch_rad=here.pitch_rad - 0.3)
    end = PUMA_START.replace(theta1=0.0)
    (section,) = sections(
        PUMA_START, LinePart(via, radius), LinePart(goal, 10.0), JointPart(end), arm=PUMA
    )
    assert section.blends_mm[0] == pytest.approx(min(radius, wide / 2.0))
    assert section.corners[-1] == end
    assert sharpest_deg(section.corners) <= 15.0
    near = min(math.dist(tip(PUMA, joints), point(via)) for joints in section.corners)
    assert near == pytest.approx(section.blends_mm[0] / math.sqrt(8.0), rel=0.1, abs=0.5)
