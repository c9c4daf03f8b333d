"""Frames in frames, bases of either hand, graphs of named frames, and loops with one unknown."""

import math

import numpy as np
import pytest
from chain_cases import gap
from frame_cases import any_angle, directed, rotations, transforms, vectors
from hypothesis import assume, given
from hypothesis import strategies as st

from kinematics import (
    FlatBasis,
    FrameGraph,
    FramesDisagree,
    FramesNotConnected,
    Handedness,
    Pose,
    UnknownFrame,
    ZeroVector,
    change_of_basis,
    handedness,
    is_rotation,
    solve_loop,
    third_axis,
)
from kinematics.frames.rotations import (
    IDENTITY,
    columns,
    determinant,
    multiply,
    rot_x,
    rot_z,
    rotate,
    transpose,
)
from kinematics.frames.transforms import (
    IN_PLACE,
    compose,
    inverse,
    invert,
    position_of,
    rotation_of,
    transform,
    transform_point,
    transform_vector,
    translation,
)
from kinematics.frames.user_frame import UserFrame
from kinematics.frames.vectors import (
    X_AXIS,
    Y_AXIS,
    Z_AXIS,
    add,
    cross,
    norm,
    scale,
    subtract,
    unit,
)


@given(transforms, vectors)
def test_a_point_is_seen_from_outside_as_the_notes_say(frame, point):
    expected = add(position_of(frame), rotate(rotation_of(frame), point))  # (2.27)
    assert transform_point(frame, point) == expected
    assert transform(rotation_of(frame), position_of(frame)) == frame


@given(transforms, transforms, vectors)
def test_frames_compose_like_4_by_4_matrices(a, b, point):
    assert np.allclose(compose(a, b), np.array(a) @ np.array(b), atol=1e-9)
    assert (
        gap(transform_point(compose(a, b), point), transform_point(a, transform_point(b, point)))
        < 1e-8
    )
    assert compose() == IN_PLACE
    assert compose(a) == a


@given(transforms, vectors)
def test_the_inverse_leads_back(frame, point):
    assert gap(compose(frame, invert(frame)), IN_PLACE) < 1e-9
    assert gap(compose(invert(frame), frame), IN_PLACE) < 1e-9
    assert gap(transform_point(invert(frame), transform_point(frame, point)), point) < 1e-9


@given(transforms, vectors, vectors)
def test_a_free_vector_is_turned_and_not_moved(frame, p, q):
    moved = subtract(transform_point(frame, p), transform_point(frame, q))
    assert gap(transform_vector(frame, subtract(p, q)), moved) < 1e-9
    assert transform_vector(translation(1.0, 2.0, 3.0), p) == p


@given(transforms, any_angle)
def test_a_frame_moves_along_its_own_axes_or_those_of_its_reference(frame, angle):
    step = translation(0.0, 0.0, 5.0)
    x, y, z = position_of(frame)
    along = scale(5.0, columns(rotation_of(frame))[2])
    own = compose(frame, step)
    assert gap(position_of(own), add((x, y, z), along)) < 1e-9
    assert gap(position_of(compose(step, frame)), (x, y, z + 5.0)) < 1e-9
    turn = transform(rot_z(angle), (0.0, 0.0, 0.0))
    assert gap(position_of(compose(frame, turn)), (x, y, z)) < 1e-12
    around = position_of(compose(turn, frame))
    assert gap(around, rotate(rot_z(angle), (x, y, z))) < 1e-9


@given(directed, directed)
def test_a_third_axis_completes_either_hand(x, y):
    assume(norm(cross(unit(x), unit(y))) > 1e-3)
    for hand in Handedness:
        z = third_axis(x, y, hand)
        assert math.isclose(norm(z), 1.0)
        assert handedness(x, y, z) is hand
        assert handedness(y, x, z) is not hand


def test_axes_in_one_plane_are_no_basis():
    with pytest.raises(FlatBasis):
        handedness(X_AXIS, Y_AXIS, add(X_AXIS, Y_AXIS))
    with pytest.raises(FlatBasis):
        inverse((X_AXIS, X_AXIS, Z_AXIS))
    with pytest.raises(FlatBasis):
        change_of_basis((X_AXIS, X_AXIS, Z_AXIS), IDENTITY)
    with pytest.raises(ZeroVector):
        third_axis(X_AXIS, scale(-2.0, X_AXIS))


skew = st.tuples(*[st.tuples(*[st.integers(-5, 5).map(float)] * 3)] * 3).filter(
    lambda m: abs(determinant(m)) > 0.5
)


@given(skew)
def test_the_inverse_by_cofactors_undoes_any_basis(matrix):
    assert gap(multiply(matrix, inverse(matrix)), IDENTITY) < 1e-10


@given(skew, skew, vectors)
def test_a_vector_keeps_its_place_when_its_basis_changes(old, new, seen):
    there = rotate(change_of_basis(old, new), seen)
    assert gap(rotate(new, there), rotate(old, seen)) < 1e-6


@given(rotations, rotations)
def test_between_frames_of_one_hand_it_is_a_rotation_and_else_a_mirror(old, new):
    assert gap(change_of_basis(old, new), multiply(transpose(new), old)) < 1e-13
    x, y, z = columns(new)
    mirrored = columns((x, y, scale(-1.0, z)))
    assert not is_rotation(change_of_basis(old, mirrored))
    assert math.isclose(determinant(change_of_basis(old, mirrored)), -1.0)


@given(transforms, transforms, transforms)
def test_any_named_frame_is_found_in_any_other(base, camera, part):
    graph = FrameGraph(
        {("table", "base"): base, ("table", "camera"): camera, ("camera", "part"): part}
    )
    assert gap(graph.between("base", "part"), compose(invert(base), camera, part)) < 1e-9
    assert gap(graph.between("part", "base"), compose(invert(part), invert(camera), base)) < 1e-8
    assert graph.between("part", "part") == IN_PLACE
    assert graph.frames == ("table", "base", "camera", "part")


@given(transforms, transforms)
def test_a_relation_that_contradicts_its_loop_is_told_by_how_much(a, b):
    known, tip = {("table", "base"): a, ("base", "tip"): b}, ("table", "tip")
    true = compose(a, b)
    assert gap(FrameGraph({**known, tip: true}).between(*tip), true) < 1e-9
    off = compose(translation(3.0, 0.0, 4.0), true, transform(rot_x(0.1), (0.0, 0.0, 0.0)))
    with pytest.raises(FramesDisagree, match="5 mm") as refused:
        FrameGraph({**known, tip: off})
    assert refused.value.gap_mm == pytest.approx(5.0)
    assert refused.value.gap_rad == pytest.approx(0.1)
    measured = FrameGraph({**known, tip: off}, tolerance_mm=5.1, tolerance_rad=0.2)
    assert measured.between(*tip) == off


def test_a_frame_is_not_elsewhere_in_itself():
    with pytest.raises(FramesDisagree):
        FrameGraph({("table", "table"): translation(1.0, 0.0, 0.0)})
    with pytest.raises(FramesDisagree):
        FrameGraph({("a", "b"): translation(1.0, 0.0, 0.0), ("b", "a"): translation(1.0, 0.0, 0.0)})


def test_names_that_are_unknown_or_unconnected_are_told():
    graph = FrameGraph({("table", "base"): IN_PLACE, ("world", "camera"): IN_PLACE})
    with pytest.raises(UnknownFrame, match="did you mean 'camera'"):
        graph.between("table", "camra")
    with pytest.raises(FramesNotConnected, match="only table, base"):
        graph.between("table", "camera")


@given(transforms, transforms, transforms, transforms, st.integers(0, 4))
def test_one_unknown_of_a_loop_follows_from_the_rest(a, b, c, d, which):
    e = compose(invert(d), a, b, c)  # a b c = d e
    loop = [a, b, c, d, e]
    given_ones = [None if at == which else frame for at, frame in enumerate(loop)]
    assert gap(solve_loop(given_ones[:3], given_ones[3:]), loop[which]) < 1e-8


@given(any_angle)
def test_the_textbook_loop_of_a_hand_on_a_part(angle):
    """Where must the hand be in the base, to hold a part that the table carries (McKerrow)?"""
    base = translation(-200.0, 0.0, 0.0)
    part = transform(rot_z(angle), (100.0, 50.0, 0.0))
    grasp = transform(rot_x(math.pi), (0.0, 0.0, 10.0))
    hand = solve_loop([base, None], [part, grasp])
    assert gap(position_of(hand), (300.0, 50.0, 10.0)) < 1e-9
    assert gap(transform_vector(hand, Z_AXIS), (0.0, 0.0, -1.0)) < 1e-9


# Frames on the bench: what is laid out there is found there, and found again.


MM = st.floats(-500.0, 500.0)
TURN = st.floats(-math.pi, math.pi)
FRAMES = st.builds(UserFrame.turned, st.tuples(MM, MM, MM), TURN, TURN, TURN)
POSES = st.builds(Pose, MM, MM, MM, TURN, TURN)


@given(FRAMES, POSES)
def test_there_and_back_is_where_it_was(frame: UserFrame, pose: Pose) -> None:
    back = frame.from_base(frame.to_base(pose))
    assert back.position_mm == pytest.approx(pose.position_mm, abs=1e-9)
    assert (back.pitch_rad, back.roll_rad) == (pose.pitch_rad, pose.roll_rad)


@given(MM, MM, TURN, st.floats(10.0, 300.0), st.floats(10.0, 300.0))
def test_three_touched_points_lay_out_the_frame_they_were_taken_from(
    x: float, y: float, yaw: float, along: float, across: float
) -> None:
    wanted = UserFrame.turned((x, y, 20.0), yaw, 0.2, -0.1)

    def at(u: float, v: float) -> tuple[float, float, float]:
        pose = wanted.to_base(Pose(u, v, 0.0, 0.0))
        return pose.x_mm, pose.y_mm, pose.z_mm

    found = UserFrame.through(at(0.0, 0.0), at(along, 0.0), at(5.0, across))
    assert gap(found.rotation, wanted.rotation) < 1e-9


def test_a_yaw_counts_from_where_the_frames_x_points() -> None:
    frame = UserFrame.turned((100.0, 0.0, 0.0), math.pi / 2)
    pose = frame.to_base(Pose(10.0, 0.0, 0.0, 0.0, 0.0, 0.25))
    assert (pose.x_mm, pose.y_mm) == pytest.approx((100.0, 10.0))
    assert pose.yaw_rad == pytest.approx(math.pi / 2 + 0.25)
