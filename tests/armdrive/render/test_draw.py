"""Lines, clipping, postures as rows of characters, and the choice of characters."""

import math
from itertools import pairwise

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st
from space_cases import CAMERAS, guarded, six_axes

from armdrive.render.camera import Camera, Dome, projection
from armdrive.render.canvas import Ink, Raster, can_braille, clip
from armdrive.render.figure import dome, stance
from armdrive.render.scene import (
    LEAP,
    MOST_POINTS,
    Moment,
    PostureDrawing,
    Trail,
    key_of,
    outline,
)
from kinematics import Joints, preset
from kinematics.five_axis.workspace import section
from kinematics.frames.rotations import from_columns, multiply, rot_y, rot_z, rotate, transpose
from kinematics.geometry import Tool
from kinematics.limits import sampled

MODEL = preset("teachmover")


def posture(base_deg=0.0, links_deg=(60.0, -80.0, -60.0)):
    return Joints.of(base_deg, *links_deg, 0.0)


def drawn(joints, view, size=(60, 20), *, braille=True, opening_mm=30.0, blocks=()):
    drawing = PostureDrawing(MODEL, braille=braille)
    draw = (drawing.side, drawing.top)[view]
    return draw(Moment(joints, opening_mm), *size, blocks)


SIDE, TOP = 0, 1


def marks(rows):
    """Cells that are not blank, as (column, row)."""
    return {(x, y) for y, row in enumerate(rows) for x, cell in enumerate(row) if cell != " "}


def lines(width, height, *points, braille, ink=Ink.BASE):
    """Draw a line through points, given in dots, on an empty raster."""
    canvas = Raster(width, height, braille=braille)
    canvas.line(points, ink)
    return canvas.painted().rows()


@every_row("above, below", [(Ink.BASE, Ink.TABLE), (Ink.JOINT, Ink.ARM)])
@every_row("flipped", [False, True])
def test_the_greater_ink_is_seen_whichever_was_drawn_first(above, below, flipped):
    canvas = Raster(3, 1, braille=False)
    for ink in (below, above) if flipped else (above, below):
        canvas.line([(0, 0), (2, 0)], ink)
    assert canvas.painted().inks == bytes([above] * 3)


@every_row("end, stroke", [((4, 0), "-"), ((0, 4), "|"), ((4, 4), "\\"), ((4, -4), "/")])
def test_ascii_lines_take_the_stroke_of_their_slope(end, stroke):
    down = 0 if end[1] >= 0 else 4
    rows = lines(5, 5, (0, down), (end[0], down + end[1]), braille=False)
    assert {rows[y][x] for x, y in marks(rows)} == {stroke}


anywhere = st.floats(-1e6, 1e6)


@given(anywhere, anywhere, anywhere, anywhere)
def test_a_clipped_line_ends_on_the_canvas(x0, y0, x1, y1):
    kept = clip((x0, y0, x1, y1), 30.0, 20.0)
    assert kept is None or all(
        0.0 <= value <= edge for value, edge in zip(kept, (30, 20) * 2, strict=True)
    )


# Postures, as a question shows them.


def test_the_side_view_is_the_arms_own_plane_whatever_the_base():
    """The letters of the table's axes alone go round."""
    straight, turned, lower = (
        drawn(joints, SIDE)[:17]  # without table and legend
        for joints in (posture(), posture(70.0), posture(links_deg=(20.0, -80.0, -60.0)))
    )
    assert straight == turned
    assert straight != lower


def test_fingers_that_hold_a_tool_are_at_the_hand_and_not_at_the_tool_s_point():
    arm = MODEL.arm.with_tool(Tool(along_mm=60.0))
    found = stance(arm, posture(), 30.0, 452.0)
    assert [found.points[index] for index in found.hand] == list(MODEL.arm.points(posture())[-2:])


def test_a_drawing_shows_one_posture_alone():
    """No trail of the postures before, which another drawing has never seen."""
    drawing, there = PostureDrawing(MODEL, braille=True), Moment(posture(30.0), 30.0)
    for base_deg in range(0, 30, 2):
        drawing.top(Moment(posture(float(base_deg)), 30.0), 60, 20)
    assert drawing.top(there, 60, 20) == PostureDrawing(MODEL, braille=True).top(there, 60, 20)


@every_row(
    "encoding, environ, legible",
    [
        ("utf-8", {"LANG": "en_GB.UTF-8", "TERM": "xterm-256color"}, True),
        ("UTF8", {}, True),
        ("utf-8", {"LANG": "C", "LC_ALL": "C.utf8"}, True),
        ("utf-8", {"LANG": "de_DE.UTF-8@euro"}, True),
        ("utf-8", {"LANG": "C.UTF-8", "TERM": "linux"}, False),
        ("utf-8", {"LANG": "C.UTF-8", "TERM": "dumb"}, False),
        ("utf-8", {"LANG": "en_US.UTF-8", "LC_ALL": "POSIX"}, False),
        ("cp1252", {}, False),
        ("ascii", {"LANG": "en_GB.UTF-8"}, False),
        (None, {"LANG": "en_GB.UTF-8"}, False),
    ],
)
def test_braille_only_where_it_is_legible(encoding, environ, legible):
    assert can_braille(encoding, environ) is legible


# Laws of the camera: it is a rotation and a scale, and shows all that an arm can reach.


DOME = Dome((0.0, 0.0, 195.0), 452.0)
FRONT = from_columns((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
"""Right, up and towards the watcher, for one who stands on the x axis."""

POINTS = st.tuples(*(st.floats(-600.0, 600.0) for _ in "xyz"))


def flat(camera):
    return Camera(camera.azimuth_deg, camera.elevation_deg)


@given(CAMERAS)
def test_the_camera_is_the_rotation_that_kinematics_makes_of_its_angles(camera):
    azimuth, elevation = math.radians(camera.azimuth_deg), math.radians(camera.elevation_deg)
    watcher = multiply(rot_z(azimuth), rot_y(-elevation), FRONT)
    for row, expected in zip(camera.rotation, transpose(watcher), strict=True):
        assert row == pytest.approx(expected, abs=1e-9)


@given(CAMERAS, POINTS, POINTS, st.sampled_from((1.0, 2.0)))
def test_dots_are_the_rotated_points_at_one_scale(camera, one, other, aspect):
    seen = projection(camera, DOME, 200, 120, aspect)
    scale = math.hypot(*seen.right[:3])
    (x0, y0), (x1, y1) = seen.dots(one), seen.dots(other)
    way = tuple(b - a for a, b in zip(one, other, strict=True))
    right, up, _ = rotate(camera.rotation, way)
    assert x1 - x0 == pytest.approx(right * scale, abs=1e-6)
    assert y1 - y0 == pytest.approx(-up * scale / aspect, abs=1e-6)


@given(CAMERAS, st.floats(0.0, math.tau), st.floats(0.0, 1.0), st.integers(9, 300))
def test_all_that_the_arm_can_reach_above_the_table_is_in_the_picture(camera, turn, height, size):
    camera = flat(camera)
    z = height * (DOME.centre[2] + DOME.reach_mm)
    out = math.sqrt(max(DOME.reach_mm**2 - (z - DOME.centre[2]) ** 2, 0.0))
    x, y = projection(camera, DOME, size, size).dots(
        (out * math.cos(turn), out * math.sin(turn), z)
    )
    assert -1e-6 <= x <= size - 1 + 1e-6
    if camera.elevation_deg >= 0:
        assert -1e-6 <= y <= size - 1 + 1e-6


@given(CAMERAS, st.integers(-6, 6), POINTS)
def test_while_coming_nearer_the_point_stays_where_it_is_on_the_screen(camera, steps, about):
    nearer = camera.zoomed(steps, about, DOME)
    if nearer.zoom > 0:
        before = projection(camera, DOME, 200, 120).dots(about)
        after = projection(nearer, DOME, 200, 120).dots(about)
        assert after == pytest.approx(before, abs=1e-4)
    else:
        assert nearer.centre_mm is None


@given(CAMERAS, st.integers(-400, 400))
def test_going_round_and_back_leads_to_the_same_camera(camera, by):
    assert camera.orbited(by).orbited(-by) == camera
    assert camera.orbited(by).orbited(360 - by) == camera


@pytest.mark.parametrize("model", [guarded(), six_axes()])
def test_the_dome_of_an_arm_holds_every_point_that_it_comes_to(model):
    whole = dome(model.arm)
    for share in (0.0, 0.2, 0.5, 0.9, 1.0):
        angles = tuple(
            one.low_rad + share * (one.high_rad - one.low_rad) for one in model.arm.limits
        )
        joints = Joints(angles, model.arm.joint_names)
        for point in model.arm.points(joints)[-len(model.arm.moving_points) :]:
            assert math.dist(point, whole.centre) <= whole.reach_mm + 1e-6


# The driven way and the outline of the reach: bounded, honest about gaps, worked out seldom.


REACH_MM = 452.0


def strokes(trail):
    return trail.layer.strokes


@given(st.lists(st.none() | st.floats(-400.0, 400.0), max_size=900))
def test_the_way_is_bounded_and_holds_no_leap(xs):
    trail = Trail(REACH_MM)
    for x in xs:
        trail.add(None if x is None else (x, 0.0, 0.0))
    assert sum(len(stroke.points) for stroke in strokes(trail)) <= MOST_POINTS
    for stroke in strokes(trail):
        for one, other in pairwise(stroke.points):
            assert math.dist(one, other) <= LEAP * REACH_MM


def test_a_lost_position_ends_the_way_and_clearing_forgets_it():
    trail = Trail(REACH_MM)
    for x in (0.0, 20.0, None, 40.0, 60.0):
        trail.add(None if x is None else (x, 0.0, 0.0))
    assert [len(stroke.points) for stroke in strokes(trail)] == [2, 2]
    trail.clear()
    assert strokes(trail) == ()
    trail.add((80.0, 0.0, 0.0))
    assert [len(stroke.points) for stroke in strokes(trail)] == [2]


@pytest.mark.parametrize("pitch_deg", [-35])
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
    for angles in sampled([(one.low_rad, one.high_rad) for one in arm.limits], 200):
        x, y, z = arm.points(Joints(angles, arm.joint_names))[-1]
        beside = min(curve, key=lambda point: abs(point[1] - z))
        assert math.hypot(x, y) <= beside[0] + 0.15 * whole.reach_mm
