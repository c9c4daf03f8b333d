"""Circular arcs through three points: where they lead, how exactly, and what is refused."""

import dataclasses
import math
from dataclasses import replace
from itertools import pairwise

import pytest
from amounts import amount
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from kinematics_cases import PUMA, TEACHMOVER, UNEVEN, same_pose
from kinematics_cases import START as PUMA_START
from route_cases import START, at, point, pose, poses, sharpest_deg, tip

from kinematics import (
    KinematicsError,
    NoArc,
    PathBroken,
    arc_path,
    line_path,
)
from kinematics.five_axis.tool_arm import ToolArm
from kinematics.frames.vectors import cross, dot, subtract, unit
from kinematics.geometry import Tool
from kinematics.paths.curves import round_through

POINTS = st.tuples(*[st.floats(-400.0, 400.0)] * 3)
SHARES = st.floats(0.0, 1.0)


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


def test_an_arc_backwards_has_the_same_corners():
    via, goal = pose(310, 0, 100), pose(250, 100, 160, -60, 40)
    there = arc_path(TEACHMOVER, START, via, goal)
    back = arc_path(TEACHMOVER, there[-1], via, TEACHMOVER.fk(START))
    assert len(there) == len(back)
    for one, two in zip(there, reversed(back), strict=True):
        assert one.angles_rad == pytest.approx(two.angles_rad, abs=1e-7)


def test_a_full_circle_returns_with_the_hand_as_it_was():
    through = replace(TEACHMOVER.fk(START), x_mm=250.0, y_mm=-40.0, z_mm=120.0)
    corners = arc_path(TEACHMOVER, START, pose(280, -70, 120), through, sweep_rad=math.tau)
    assert corners[-1].angles_rad == pytest.approx(START.angles_rad)
    ways = sampled(TEACHMOVER, corners)
    assert max(x for x, _, _ in ways) == pytest.approx(280, abs=1)
    assert min(x for x, _, _ in ways) == pytest.approx(220, abs=1)
    assert all(TEACHMOVER.fk(joints).pitch_deg == pytest.approx(-90) for joints in corners)


@pytest.mark.parametrize(("sweep_deg", "x_mm", "y_mm"), [(90, 280, -70), (270, 220, -70)])
def test_a_sweep_ends_an_arc_before_or_beyond_its_third_point(sweep_deg, x_mm, y_mm):
    goal = pose(250, -40, 120, -50)
    corners = arc_path(
        TEACHMOVER, START, pose(280, -70, 120), goal, sweep_rad=math.radians(sweep_deg)
    )
    assert same_pose(TEACHMOVER.fk(corners[-1]), pose(x_mm, y_mm, 120, -50), mm=1e-6)


def test_several_turns_are_not_taken_for_none():
    corners = arc_path(
        TEACHMOVER, START, pose(280, -70, 120), pose(250, -40, 120), sweep_rad=4 * math.tau
    )
    assert len(corners) > 4 * 8


@pytest.mark.parametrize(
    ("via", "goal", "words"),
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


def test_a_sweep_must_be_an_angle_forward():
    with pytest.raises(KinematicsError, match="sweep_rad must be more than 0"):
        arc_path(TEACHMOVER, START, pose(280, -70, 120), pose(250, -40, 120), sweep_rad=-1.0)


def test_an_arc_that_leaves_the_reach_says_where():
    with pytest.raises(PathBroken, match=r"arc breaks at .* an arc that keeps clear") as broken:
        arc_path(TEACHMOVER, START, pose(440, 0, 120), pose(250, 100, 120))
    assert broken.value.shape == "arc"
    assert 0.0 < broken.value.fraction < 1.0
    place = point(broken.value.point)
    arc = round_through(point(TEACHMOVER.fk(START)), (440, 0, 120), (250, 100, 120))
    assert math.dist(place, arc.at(broken.value.fraction)) < 1e-6
    assert TEACHMOVER.solve(broken.value.point) is None


def test_an_arc_through_the_base_axis_is_broken_there():
    start = UNEVEN.ik(pose(100, 0, 350, 30))
    with pytest.raises(PathBroken, match="because the arc meets the base axis"):
        arc_path(UNEVEN, start, pose(0, 0, 370, 30), pose(-100, 0, 350, 30))


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


def test_an_arc_of_a_tool_is_that_of_its_point():
    arm = ToolArm(TEACHMOVER, Tool(along_mm=30, up_mm=10, side_mm=15))
    start = arm.ik(pose(240, -60, 140, -60, 30))
    via, goal = pose(270, 0, 140, -60), pose(240, 70, 130, -70, -10)
    arc = round_through(point(arm.fk(start)), point(via), point(goal))
    corners = arc_path(arm, start, via, goal, 0.2)
    assert max(off_circle(arc, place) for place in sampled(arm, corners)) <= 0.2


def test_ordinary_arcs_and_lines_have_some_tens_of_corners():
    goal = pose(250, 100, 120)
    assert len(line_path(TEACHMOVER, START, goal)) == 9
    assert len(line_path(TEACHMOVER, START, pose(300, 80, 220, 0, 170))) == 17
    assert len(arc_path(TEACHMOVER, START, pose(300, 0, 120), goal)) <= 20
    assert len(arc_path(TEACHMOVER, START, pose(300, 0, 120), goal, 0.05)) <= 60
