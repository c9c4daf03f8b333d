"""The frames in which goals and jogs are meant: the base, the tool, and those of the arm file."""

from __future__ import annotations

from collections.abc import Mapping

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.moves import BASE_FRAME, TOOL_FRAME
from kinematics.frames.rotations import IDENTITY, Matrix3, columns
from kinematics.frames.user_frame import UserFrame, moved_along
from kinematics.frames.vectors import Vector
from kinematics.spaces import Joints, Pose

BASE, TOOL = BASE_FRAME, TOOL_FRAME
"""Frames that every arm has. The tool's x is up from the hand's back, y its side, z along it."""


def frame_names(config: ArmConfig) -> tuple[str, ...]:
    """Return the frames that an arm knows, in the order in which a person goes through them."""
    return (BASE, TOOL, *config.frames)


def axes_of(config: ArmConfig, joints: Joints, frame: str) -> tuple[Vector, Vector, Vector]:
    """Return the unit vectors of a frame's x, y and z in the base, the arm in that posture.

    Raises `BadRequest` for a frame that nobody knows.
    """
    x, y, z = columns(_rotation(config, joints, frame))
    return x, y, z


def goal_in_base(config: ArmConfig, joints: Joints, goal: Pose, frame: str) -> Pose:
    """Return a goal as the base sees it. In the tool's frame a goal is a change from where it is.

    So `Pose.of(x_mm=0, y_mm=0, z_mm=20, pitch_deg=0)` goes 20 mm on in the hand's direction.
    """
    if frame == BASE:
        return goal
    if frame == TOOL:
        return moved_along(config.model.arm.fk(joints), _rotation(config, joints, TOOL), goal)
    return _known(config.frames, frame).to_base(goal)


def pose_in_frame(config: ArmConfig, pose: Pose, frame: str) -> Pose:
    """Return a pose of the base as the base or a frame of the arm file sees it."""
    if frame == BASE:
        return pose
    if frame == TOOL:
        raise BadRequest("where the tool is, seen from the tool itself, is always 0: name a frame")
    return _known(config.frames, frame).from_base(pose)


def _rotation(config: ArmConfig, joints: Joints, frame: str) -> Matrix3:
    if frame == BASE:
        return IDENTITY
    if frame == TOOL:
        return config.model.arm.hand_axes(joints)
    return _known(config.frames, frame).rotation


def _known(frames: Mapping[str, UserFrame], name: str) -> UserFrame:
    try:
        return frames[name]
    except KeyError:
        known = ", ".join((BASE, TOOL, *frames))
        raise BadRequest(
            f"no frame is called {name!r}; known are {known}. Frames of your own belong into the "
            "arm file, under [frames.NAME]"
        ) from None
