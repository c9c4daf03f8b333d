"""Lines, arcs, blends and routes: their shape, their laws, and what breaks them."""

import dataclasses
import math
from itertools import pairwise

import pytest
from amounts import amount, every_row
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from kinematics_cases import PUMA, TEACHMOVER, UNEVEN, same_pose, turn_between
from kinematics_cases import START as PUMA_START

from kinematics import (
    ArcPart,
    JointPart,
    Joints,
    LinePart,
    NoArc,
    PathBroken,
    Pose,
    PosePart,
    Route,
    line_path,
    route_sections,
)
from kinematics.frames.vectors import cross, dot, subtract, unit
from kinematics.paths.chords import TINY_RAD, posture_at
from kinematics.paths.curves import round_through
from kinematics.paths.routes import blend, lay


def pose(x_mm, y_mm, z_mm, pitch_deg=-90.0, roll_deg=0.0):
    return Pose.of(x_mm=x_mm, y_mm=y_mm, z_mm=z_mm, pitch_deg=pitch_deg, roll_deg=roll_deg)


START = TEACHMOVER.ik(pose(250, -100, 120))

poses = st.builds(
    lambda r, angle, z, pitch, roll: Pose(r * math.cos(angle), r * math.sin(angle), z, pitch, roll),
    st.floats(150, 330),
    st.floats(-1.2, 1.2),
    st.floats(30, 250),
    st.floats(-1.5, -0.2),
    st.floats(-1.5, 1.5),
)


def at(start, goal, share):
    """The posture at a share of a joint motion."""
    angles = (a + share * (b - a) for a, b in zip(start, goal, strict=True))
    return Joints(tuple(angles), start.names)


def tip(arm, joints):
    return arm.points(joints)[-1]


def point(pose):
    return pose.position_mm


def directions(corners):
    return [tuple(b - a for a, b in zip(one, two, strict=True)) for one, two in pairwise(corners)]


def turn_deg(one, two):
    """The angle between two directions in joint space."""
    a, b = (tuple(part / math.hypot(*way) for part in way) for way in (one, two))
    return math.degrees(
        2 * math.atan2(math.dist(a, b), math.hypot(*(x + y for x, y in zip(a, b, strict=True))))
    )


def sharpest_deg(corners):
    """The sharpest corner between chords that are not both tiny."""
    ways = directions(corners)
    return max(
        (
            turn_deg(one, two)
            for one, two in pairwise(ways)
            if max(math.hypot(*one), math.hypot(*two)) > TINY_RAD
        ),
        default=0.0,
    )


# Joint motions, straight lines, and guards along them.


def test_pitch_and_roll_change_in_proportion_to_the_way():
    goal = pose(300, 80, 220, 0, 170)
    waypoints = line_path(TEACHMOVER, START, goal)
    origin = TEACHMOVER.fk(START)
    for joints in waypoints[1:]:
        here = TEACHMOVER.fk(joints)
        share = (here.x_mm - origin.x_mm) / (goal.x_mm - origin.x_mm)
        assert here.pitch_deg == pytest.approx(-90 + 90 * share, abs=1e-6)
        assert here.roll_deg == pytest.approx(170 * share, abs=1e-6)


@every_row(
    "goal, reason",
    [
        (pose(600, 100, 300, -20), "355.6 mm that the arm spans"),
        (pose(60, 0, 120), "elbow would pass its limit of -149"),
    ],
)
def test_a_line_that_leaves_the_reach_says_where_and_why(goal, reason):
    with pytest.raises(PathBroken, match=reason) as caught:
        line_path(TEACHMOVER, START, goal)
    broken = caught.value
    assert 0.0 < broken.fraction < 1.0
    origin = TEACHMOVER.fk(START)
    assert broken.point.x_mm == pytest.approx(
        origin.x_mm + broken.fraction * (goal.x_mm - origin.x_mm)
    )
    before = Pose(
        *(
            a + 0.999 * broken.fraction * (b - a)
            for a, b in (
                (origin.x_mm, goal.x_mm),
                (origin.y_mm, goal.y_mm),
                (origin.z_mm, goal.z_mm),
                (origin.pitch_rad, goal.pitch_rad),
            )
        )
    )
    assert same_pose(TEACHMOVER.fk(line_path(TEACHMOVER, START, before)[-1]), before, mm=1e-4)
    assert TEACHMOVER.solve(broken.point, START) is None


def test_a_line_through_the_base_axis_is_broken_there():
    start = UNEVEN.ik(Pose(100, 0, 350, 0.5))
    with pytest.raises(PathBroken, match="the base would have to turn by 180° at once") as caught:
        line_path(UNEVEN, start, Pose(-100, 0, 350, 0.5))
    assert caught.value.fraction == pytest.approx(0.5, abs=1e-4)
    assert caught.value.point.x_mm == pytest.approx(0, abs=0.05)


def test_lines_on_to_and_along_the_base_axis_keep_the_base():
    start = TEACHMOVER.ik(Pose(100, 0, 470, 0))
    on_axis = line_path(TEACHMOVER, start, Pose(0, 0, 470, 0))
    assert {joints["base"] for joints in on_axis} == {0.0}
    up = line_path(TEACHMOVER, on_axis[-1], Pose(0, 0, 490, 0))
    assert same_pose(TEACHMOVER.fk(up[-1]), Pose(0, 0, 490, 0))
    back = line_path(TEACHMOVER, on_axis[-1], Pose(100, 0, 470, 0))
    assert back[-1].angles_rad == pytest.approx(start.angles_rad)
    with pytest.raises(PathBroken, match="meets the base axis") as caught:
        line_path(TEACHMOVER, on_axis[-1], Pose(0, 100, 470, 0))
    assert caught.value.fraction < 1e-4


@every_row("elbow_deg", [-70.0, 70.0])
def test_a_line_keeps_the_elbow_that_it_starts_with(elbow_deg):
    start = Joints.of(10, 20, elbow_deg, -15, 0)
    pose = UNEVEN.fk(start)
    goal = Pose(pose.x_mm - 20, pose.y_mm + 40, pose.z_mm + 10, pose.pitch_rad, pose.roll_rad)
    waypoints = line_path(UNEVEN, start, goal)
    assert same_pose(UNEVEN.fk(waypoints[-1]), goal, mm=1e-4)
    assert all(each["elbow"] * elbow_deg > 0.0 for each in waypoints)


def test_the_roll_takes_the_longer_way_where_its_range_forbids_the_shorter():
    start = Joints.of(10, 20, -70, -15, 150)
    goal = dataclasses.replace(UNEVEN.fk(start), roll_rad=math.radians(-150))
    waypoints = line_path(UNEVEN, start, goal)
    assert waypoints[-1].deg["wrist_roll"] == pytest.approx(-150)
    assert len(waypoints) > 1


def test_a_line_behind_the_base_axis_stays_behind():
    start = TEACHMOVER.ik(TEACHMOVER.fk(Joints.of(0, 130, -20, 0, 180)), Joints.of(0, 130, 0, 0, 0))
    origin = TEACHMOVER.fk(start)
    assert origin.x_mm < 0
    goal = Pose(origin.x_mm, origin.y_mm + 30, origin.z_mm - 5, origin.pitch_rad, origin.roll_rad)
    waypoints = line_path(TEACHMOVER, start, goal)
    assert same_pose(TEACHMOVER.fk(waypoints[-1]), goal, mm=1e-4)
    assert turn_between(waypoints[-1]["base"], start["base"]) < 0.5


def test_a_joint_that_starts_beyond_its_limit_may_only_come_back():
    start = Joints.of(90.5, 40, -80, -20, 0)
    pose = TEACHMOVER.fk(start)
    r = math.hypot(pose.x_mm, pose.y_mm)

    def turned(base_deg):
        base = math.radians(base_deg)
        return Pose(r * math.cos(base), r * math.sin(base), pose.z_mm, pose.pitch_rad)

    assert line_path(TEACHMOVER, start, turned(70))[-1].deg["base"] == pytest.approx(70)
    with pytest.raises(PathBroken, match=r"base would pass its limit of 90\.5"):
        line_path(TEACHMOVER, start, turned(92))


# Circular arcs through three points: where they lead, how exactly, and what is refused.

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


# Routes of several parts: their sections, their laws, and what breaks them.

BETWEEN, GOAL = pose(250, 100, 120), pose(150, 100, 150, -70, 40)
BLENDS = st.sampled_from((0.0, 5.0, 30.0, 1000.0))


def sections(start, *parts, arm=TEACHMOVER, tolerance_mm=0.5):
    return route_sections(arm, Route(start, parts), tolerance_mm)


def test_without_blends_every_part_is_a_section_that_ends_exactly():
    arc = ArcPart(pose(200, 150, 120), GOAL)
    joints = Joints.of(10, 40, -80, -30, 20)
    found = sections(START, LinePart(BETWEEN), arc, JointPart(joints), PosePart(BETWEEN))
    assert [section.parts for section in found] == [(1,), (2,), (3,), (4,)]
    ends = [section.corners[-1] for section in found]
    starts = [section.corners[0] for section in found]
    assert starts == [START, *ends[:-1]]
    assert same_pose(TEACHMOVER.fk(ends[0]), BETWEEN)
    assert same_pose(TEACHMOVER.fk(ends[1]), GOAL)
    assert ends[2] == joints
    assert ends[3] == TEACHMOVER.ik(BETWEEN, joints)
    assert found[2].corners == (ends[1], joints)


def test_a_blend_joins_parts_into_one_section_and_says_its_radius():
    found = sections(
        START,
        LinePart(BETWEEN, 20.0),
        LinePart(GOAL, 400.0),
        JointPart(START),
        PosePart(BETWEEN, 10.0),
    )
    assert [section.parts for section in found] == [(1, 2, 3), (4,)]
    used = found[0].blends_mm
    assert used[0] == 20.0
    assert used[1] == pytest.approx(math.dist(point(BETWEEN), point(GOAL)) / 2.0, abs=30.0)
    assert used[1] <= math.dist(point(BETWEEN), point(GOAL)) / 2.0 + 1e-6
    assert used[2] == 0.0
    near = min(math.dist(tip(TEACHMOVER, one), point(BETWEEN)) for one in found[0].corners)
    assert 5.0 < near < 11.0  # the parabola passes a corner of this angle at about half the radius


@settings(max_examples=amount(40, 1000))
@given(poses, poses, poses, poses, BLENDS, BLENDS)
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


def test_lines_of_a_route_are_followed_in_one_posture():
    up, down = (Joints.of(10, 20, elbow_deg, -15, 0) for elbow_deg in (-70, 70))

    def aside(joints):
        here = UNEVEN.fk(joints)
        return LinePart(dataclasses.replace(here, y_mm=here.y_mm + 10))

    with pytest.raises(PathBroken, match="the arm would stand in another posture") as broken:
        sections(up, aside(up), JointPart(down), aside(down), arm=UNEVEN)
    assert broken.value.part == 3
    assert len(sections(up, aside(up), JointPart(up), aside(up), arm=UNEVEN)) == 3


def test_a_pose_out_of_reach_names_its_part_and_a_pose_in_reach():
    with pytest.raises(PathBroken, match="nearest pose that can be reached") as broken:
        sections(START, LinePart(BETWEEN), PosePart(pose(600, 100, 120, -20)))
    assert broken.value.part == 2
    assert broken.value.shape == "joint motion"
    assert TEACHMOVER.ik(broken.value.__cause__.nearest, START)


def test_the_hand_of_six_joints_turns_the_shorter_way():
    follower = PUMA.follower(PUMA_START)
    for sign in (1.0, -1.0):  # two quaternions of one turn
        near = tuple(sign * part for part in follower.first)
        assert follower.hand(PUMA.fk(PUMA_START), near) == pytest.approx(near)


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
