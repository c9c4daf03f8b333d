"""What a planned motion leads to, in the words of the public calls, and the plan of each kind.

One piece of code plans what `move_*` carries out and what `preview` shows.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.motion.plan import MotionPlan, named_joints, plan_joints, plan_line, posture_for
from armdrive.motion.segments import SpeedLimits
from armdrive.moves import BASE_FRAME
from armdrive.runtime.position import ArmCoordinates
from kinematics.frames.rotations import IDENTITY, Matrix3, columns
from kinematics.frames.user_frame import UserFrame, moved_along
from kinematics.frames.vectors import Vector
from kinematics.spaces import Joints, Pose

# The frames in which goals and jogs are meant: the base, the tool, and those of the arm file.

BASE, TOOL = BASE_FRAME, "tool"
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


ALIKE_RAD = math.radians(0.5)
"""A posture whose joints are all as near as this is the one that a point was taught in."""

OTHER_POSTURE = "the point's pose, but not its posture: a straight line keeps the one it begins in"


@dataclass(frozen=True, slots=True)
class Ground:
    """What a plan is made on: the arm, its limits of speed, and where it stands."""

    config: ArmConfig
    speeds: SpeedLimits
    here: ArmCoordinates

    def to_joints(self, joints: Joints, fraction: float) -> MotionPlan:
        """Plan a motion straight in joint space; the fingers stay as they are."""
        end = ArmCoordinates(joints, self.here.opening_mm)
        return plan_joints(self.config, self.speeds, self.here, end, fraction)

    def in_base(self, pose: Pose, frame: str) -> Pose:
        """Return a pose of a frame as the base sees it."""
        return goal_in_base(self.config, self.here.joints, pose, frame)


class ResolvedGoal(Protocol):
    """Somewhere to go. All that it raises says why it is refused."""

    @property
    def cartesian(self) -> bool:
        """Whether it means nothing before the arm's lengths are known."""
        ...

    def plan(self, ground: Ground, fraction: float) -> MotionPlan:
        """Return the audited plan that leads there."""
        ...

    def pose(self, ground: Ground) -> Pose | None:
        """Return the pose that is asked for, in the base; None where joint angles are."""
        ...


@dataclass(frozen=True, slots=True)
class JointGoal:
    """Angles of the joints that are named, `shoulder_deg`; the others stay."""

    named_deg: Mapping[str, float]
    cartesian = False

    def __post_init__(self) -> None:
        if not self.named_deg:
            raise BadRequest("name at least one joint, for example shoulder_deg=40")

    def joints(self, ground: Ground) -> Joints:
        """Return the angles of all joints."""
        return named_joints(ground.here.joints, self.named_deg)

    def plan(self, ground: Ground, fraction: float) -> MotionPlan:
        """Return the joint motion there."""
        return ground.to_joints(self.joints(ground), fraction)

    def pose(self, ground: Ground) -> Pose | None:  # noqa: ARG002 - as every goal
        """Ask for no pose."""
        return None


@dataclass(frozen=True, slots=True)
class PostureGoal:
    """A posture of all joints, such as a named point's."""

    posture: Joints
    cartesian = False

    def joints(self, ground: Ground) -> Joints:  # noqa: ARG002 - as every goal of joints
        """Return the angles of all joints."""
        return self.posture

    def plan(self, ground: Ground, fraction: float) -> MotionPlan:
        """Return the joint motion there."""
        return ground.to_joints(self.posture, fraction)

    def pose(self, ground: Ground) -> Pose | None:  # noqa: ARG002 - as every goal
        """Ask for no pose."""
        return None


@dataclass(frozen=True, slots=True)
class PoseGoal:
    """A pose of a frame, by a joint motion to the nearest posture."""

    asked: Pose
    frame: str = BASE
    cartesian = True

    def plan(self, ground: Ground, fraction: float) -> MotionPlan:
        """Return the joint motion to the posture nearest to the present one."""
        goal = self.pose(ground)
        return ground.to_joints(posture_for(ground.config, goal, ground.here.joints), fraction)

    def pose(self, ground: Ground) -> Pose:
        """Return the pose in the base."""
        return ground.in_base(self.asked, self.frame)


@dataclass(frozen=True, slots=True)
class LineGoal:
    """A pose of a frame, along a straight line of the tip in the posture that the arm has.

    `posture` is a point's: the note of the plan says so where the line ends in another one.
    """

    asked: Pose
    frame: str = BASE
    posture: Joints | None = None
    cartesian = True

    def plan(self, ground: Ground, fraction: float) -> MotionPlan:
        """Return the straight line there."""
        made = plan_line(ground.config, ground.speeds, ground.here, self.pose(ground), fraction)
        if self.posture is None or _alike(made.end.joints, self.posture):
            return made
        return replace(made, note=OTHER_POSTURE)

    def pose(self, ground: Ground) -> Pose:
        """Return the pose in the base."""
        return ground.in_base(self.asked, self.frame)


def _alike(a: Joints, b: Joints) -> bool:
    return all(abs(x - y) <= ALIKE_RAD for x, y in zip(a, b, strict=True))
