"""One posture of an arm with a tool, kept along a line or any other curve of the tool's point.

Units: mm and rad. A hand is its pitch and roll, each of any turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kinematics.arm_geometry import Hand, NotFollowed, Point
from kinematics.curves import Line, straight_between
from kinematics.errors import Unreachable
from kinematics.limits import JointRange, wrap
from kinematics.spaces import Joints, Pose

if TYPE_CHECKING:
    from kinematics.tool_arm import ToolArm

LARGEST_TURN_RAD = 0.5
"""The furthest that a joint may turn between two waypoints: further is another posture."""


@dataclass(frozen=True, slots=True)
class ToolFollower:
    """The posture near the one before; `arm` has limits widened to a start beyond them."""

    arm: ToolArm
    first: Hand
    posture = ""

    def hand(self, pose: Pose, near: Hand) -> Hand:
        """Return how a pose holds the hand, pitch and roll the shorter way round."""
        return (
            near[0] + wrap(pose.pitch_rad - near[0]),
            near[1] + wrap(pose.roll_rad - near[1]),
        )

    def between(self, a: Hand, b: Hand, share: float) -> Hand:
        """Return the hand at a share of the turn: pitch and roll in proportion."""
        if share >= 1.0:
            return b
        return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])

    def pose(self, tip: Point, hand: Hand) -> Pose:
        """Return the pose of a tip and a hand."""
        return Pose(*tip, *hand)

    def solve(self, tip: Point, hand: Hand, before: Joints) -> Joints:
        """Return the posture near the one before; raises `NotFollowed`."""
        try:
            joints = self.arm.ik_near(self.pose(tip, hand), before)
        except Unreachable as refusal:
            raise NotFollowed(refusal.reason) from None
        turns = [abs(b - a) for a, b in zip(before, joints, strict=True)]
        if max(turns) > LARGEST_TURN_RAD:
            name = joints.names[turns.index(max(turns))].replace("_", " ")
            raise NotFollowed(
                f"the {name} would have to turn by {math.degrees(max(turns)):.0f}° at once, "
                "because the posture is singular there"
            )
        return joints


def tool_line(arm: ToolArm, start: Joints, goal: Pose) -> Line:
    """Return the line from a posture to a pose, pitch and roll the shorter way round."""
    origin = arm.fk(start)
    ranges = tuple(
        JointRange(min(bounds.low_rad, angle), max(bounds.high_rad, angle))
        for bounds, angle in zip(arm.limits, start, strict=True)
    )
    wide = replace(arm, bare=replace(arm.bare, limits=ranges))
    follower = ToolFollower(wide, (origin.pitch_rad, origin.roll_rad))
    tip = origin.x_mm, origin.y_mm, origin.z_mm
    return straight_between(follower, tip, follower.first, goal)
