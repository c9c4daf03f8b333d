"""One posture of an arm with a tool, kept along a line or any other curve of the tool's point.

Units: mm and rad. A hand is its pitch and roll, each of any turn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kinematics.arm_geometry import Hand, NotFollowed, Point
from kinematics.curves import Line, straight_between
from kinematics.errors import Unreachable
from kinematics.following import hand_near, in_proportion, refuse_leap
from kinematics.limits import widened_to
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
        return hand_near(pose, near)

    def between(self, a: Hand, b: Hand, share: float) -> Hand:
        """Return the hand at a share of the turn: pitch and roll in proportion."""
        return in_proportion(a, b, share)

    def pose(self, tip: Point, hand: Hand) -> Pose:
        """Return the pose of a tip and a hand."""
        return Pose(*tip, *hand)

    def solve(self, tip: Point, hand: Hand, before: Joints) -> Joints:
        """Return the posture near the one before; raises `NotFollowed`."""
        try:
            joints = self.arm.ik_near(self.pose(tip, hand), before)
        except Unreachable as refusal:
            raise NotFollowed(refusal.reason) from None
        refuse_leap(before, joints, LARGEST_TURN_RAD)
        return joints


def tool_line(arm: ToolArm, start: Joints, goal: Pose) -> Line:
    """Return the line from a posture to a pose, pitch and roll the shorter way round."""
    origin = arm.fk(start)
    wide = replace(arm, bare=replace(arm.bare, limits=widened_to(arm.limits, start)))
    follower = ToolFollower(wide, (origin.pitch_rad, origin.roll_rad))
    tip = origin.x_mm, origin.y_mm, origin.z_mm
    return straight_between(follower, tip, follower.first, goal)
