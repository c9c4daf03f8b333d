"""The parts of a route: joint motions, straight lines and arcs.

Lengths in mm, angles in rad. `blend_mm` is how far from the end point of a part the path may leave
it for the next part; with 0 the arm stops there exactly, as it always does after the last part.
"""

from __future__ import annotations

from dataclasses import dataclass

from kinematics.errors import check_fields, finite, not_negative, require
from kinematics.spaces import JOINTS_EXAMPLE, POSE_EXAMPLE, Joints, Pose


@dataclass(frozen=True, slots=True)
class JointPart:
    """Every joint turns in proportion, to a posture."""

    goal: Joints
    blend_mm: float = 0.0

    def __post_init__(self) -> None:
        require("goal", self.goal, Joints, JOINTS_EXAMPLE)
        check_fields(self, not_negative, "blend_mm")


@dataclass(frozen=True, slots=True)
class _PartToPose:
    goal: Pose
    blend_mm: float = 0.0

    def __post_init__(self) -> None:
        require("goal", self.goal, Pose, POSE_EXAMPLE)
        check_fields(self, not_negative, "blend_mm")


class PosePart(_PartToPose):
    """Every joint turns in proportion, to the nearest posture for a pose."""

    __slots__ = ()


class LinePart(_PartToPose):
    """A straight line to a pose, in x, y, z and the turn of the hand."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class ArcPart:
    """A circular arc through a via point, of which only x, y and z count, to a pose.

    With `sweep_rad` the arc ends after that angle instead, and the goal only gives a third point of
    the circle and the final orientation of the hand; 2 pi is a full circle.
    """

    via: Pose
    goal: Pose
    blend_mm: float = 0.0
    sweep_rad: float | None = None

    def __post_init__(self) -> None:
        require("via", self.via, Pose, POSE_EXAMPLE)
        require("goal", self.goal, Pose, POSE_EXAMPLE)
        if self.sweep_rad is not None:
            check_fields(self, finite, "sweep_rad")
        check_fields(self, not_negative, "blend_mm")


PathPart = JointPart | PosePart | LinePart | ArcPart
"""One part of a route."""
