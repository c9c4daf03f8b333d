"""Frames in frames, and frames on the bench."""

import math

import numpy as np
import pytest
from chain_cases import gap
from frame_cases import any_angle, transforms, vectors
from hypothesis import given
from hypothesis import strategies as st

from kinematics import Pose
from kinematics.frames.rotations import (
    columns,
    rot_z,
    rotate,
)
from kinematics.frames.transforms import (
    IN_PLACE,
    compose,
    position_of,
    rotation_of,
    transform,
    transform_point,
    translation,
)
from kinematics.frames.user_frame import UserFrame
from kinematics.frames.vectors import (
    add,
    scale,
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


# Frames on the bench: what is laid out there is found there, and found again.


MM = st.floats(-500.0, 500.0)
TURN = st.floats(-math.pi, math.pi)


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
