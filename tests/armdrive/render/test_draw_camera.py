"""Laws of the camera: it is a rotation and a scale, and shows all that an arm can reach."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from space_cases import CAMERAS, guarded, six_axes

from armdrive.render.camera import VIEWS, Camera, Dome, next_view, projection
from armdrive.render.figure import dome
from kinematics import Joints
from kinematics.frames.rotations import from_columns, multiply, rot_y, rot_z, rotate, transpose

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


@given(st.floats(-400.0, 400.0), st.floats(-400.0, 400.0), st.floats(0.0, 400.0))
def test_from_above_x_runs_up_and_y_to_the_left_and_height_does_not_count(x, y, z):
    seen = projection(VIEWS["top"], DOME, 241, 161)
    middle = seen.dots((0.0, 0.0, 0.0))
    scale = math.hypot(*seen.right[:3])
    column, row = seen.dots((x, y, z))
    assert column - middle[0] == pytest.approx(-y * scale, abs=1e-6)
    assert row - middle[1] == pytest.approx(-x * scale, abs=1e-6)


def test_from_the_side_x_runs_right_and_z_up_and_from_the_front_y_runs_right():
    side, front = (projection(VIEWS[name], DOME, 241, 161) for name in ("side", "front"))
    x0, y0 = side.dots((0.0, 0.0, 0.0))
    x1, y1 = side.dots((100.0, 50.0, 80.0))
    assert x1 > x0
    assert y1 < y0
    assert side.dots((100.0, -70.0, 80.0)) == pytest.approx((x1, y1))
    assert front.dots((0.0, 100.0, 0.0))[0] > front.dots((0.0, 0.0, 0.0))[0]


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


@given(CAMERAS, st.integers(-400, 400))
def test_nobody_goes_over_the_top(camera, by):
    assert -90 <= camera.orbited(0, by).elevation_deg <= 90


def test_the_views_follow_one_another_and_fit_undoes_the_zoom():
    names, camera = ["iso"], VIEWS["iso"]
    for _ in range(4):
        camera = next_view(camera)
        names.append(camera.name)
    assert names == ["iso", "side", "top", "front", "iso"]
    assert next_view(Camera(33, 10)).name == "iso"
    near = VIEWS["top"].zoomed(3, (100.0, 0.0, 0.0), DOME)
    assert (near.name, near.fitted()) == ("top", VIEWS["top"])


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
