"""Frames on the bench: what is laid out there is found there, and found again."""

from __future__ import annotations

import math

import pytest
from chain_cases import gap
from hypothesis import given
from hypothesis import strategies as st

from kinematics import KinematicsError, Pose
from kinematics.frames.user_frame import UserFrame

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


@pytest.mark.parametrize(
    "points",
    [
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 50.0, 0.0)),
        ((0.0, 0.0, 0.0), (50.0, 0.0, 0.0), (100.0, 0.0, 0.0)),
    ],
)
def test_points_that_lay_out_no_frame_are_refused(
    points: tuple[tuple[float, float, float], ...],
) -> None:
    with pytest.raises(KinematicsError, match="three points"):
        UserFrame.through(*points)
