"""The coordinate frames of goals and jogs: the base, the tool, and those of the arm file."""

from __future__ import annotations

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.moves import BASE_FRAME, TOOL_FRAME
from kinematics.frames.rotations import IDENTITY, Matrix3, columns
from kinematics.frames.user_frame import UserFrame, moved_along
from kinematics.frames.vectors import Vector
from kinematics.spaces import Joints, Pose


def frame_names(config: ArmConfig) -> tuple[str, ...]:
    """Return the names of an arm's frames, in the order in which the desk cycles through them."""
    return (BASE_FRAME, TOOL_FRAME, *config.frames)


def axes_of(config: ArmConfig, joints: Joints, frame: str) -> tuple[Vector, Vector, Vector]:
    """Return the unit vectors of a frame's x, y and z axes in the base, in a posture.

    Raises `BadRequest` for an unknown frame.
    """
    x, y, z = columns(_rotation(config, joints, frame))
    return x, y, z


def goal_in_base(config: ArmConfig, joints: Joints, goal: Pose, frame: str) -> Pose:
    """Convert a goal to the base frame. A goal in the tool's frame is relative to the tool.

    So `Pose.of(x_mm=0, y_mm=0, z_mm=20, pitch_deg=0)` moves 20 mm forward along the hand.
    """
    if frame == BASE_FRAME:
        return goal
    if frame == TOOL_FRAME:
        return moved_along(config.model.arm.fk(joints), _rotation(config, joints, TOOL_FRAME), goal)
    return _known(config, frame).to_base(goal)


def pose_in_frame(config: ArmConfig, pose: Pose, frame: str) -> Pose:
    """Convert a pose from the base frame to a frame of the arm file."""
    if frame == BASE_FRAME:
        return pose
    if frame == TOOL_FRAME:
        raise BadRequest("a pose in the tool's own frame is always 0: name another frame")
    return _known(config, frame).from_base(pose)


def _rotation(config: ArmConfig, joints: Joints, frame: str) -> Matrix3:
    if frame == BASE_FRAME:
        return IDENTITY
    if frame == TOOL_FRAME:
        return config.model.arm.hand_axes(joints)
    return _known(config, frame).rotation


def require_frame(config: ArmConfig, name: str) -> None:
    """Raise `BadRequest` with the known names unless the arm has a frame of this name."""
    known = frame_names(config)
    if name not in known:
        raise BadRequest(
            f"no frame is called {name!r}; known are {', '.join(known)}. Define frames of your own "
            "in the arm file, under [frames.NAME]"
        )


def _known(config: ArmConfig, name: str) -> UserFrame:
    require_frame(config, name)
    return config.frames[name]
