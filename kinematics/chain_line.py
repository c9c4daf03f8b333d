"""A straight line of the tip of an arm given by its link table, solved point by point.

Units: mm and rad. Five joints take pitch and roll in proportion, each the shorter way round; six
turn the hand about one axis, the shorter way, which no angle's own degeneracy disturbs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kinematics.arm_geometry import Point
from kinematics.axis_angle import AxisAngle, rotation_vector
from kinematics.chain_task import Task, pose_of
from kinematics.chains import Chain
from kinematics.errors import PathBroken
from kinematics.frames import rotation_of, transform
from kinematics.limits import wrap
from kinematics.rotations import Matrix3, multiply, transpose
from kinematics.spaces import Joints, Pose
from kinematics.vectors import Vector, norm

if TYPE_CHECKING:
    from kinematics.chain_arm import ChainArm
    from kinematics.ik_account import Solution

LARGEST_TURN_RAD = 0.1
"""The furthest that a joint may turn between two waypoints, so that the hand's direction, which
is no sum of joint angles here, stays within some thousandths of a rad of the line's."""


@dataclass(frozen=True, slots=True)
class ChainLine:
    """A line from a posture to a pose; `chain` has limits widened to the start.

    `rotation` is that of the hand at the start, and `turn` the rotation vector, in the world,
    that leads to the goal's; only six joints use them.
    """

    arm: ChainArm
    origin: Pose
    end: Pose
    rotation: Matrix3
    turn: Vector
    chain: Chain

    def tip(self, fraction: float) -> Point:
        """Return the point of the line at a fraction of its length."""
        a, b = self.origin, self.end
        return (
            _between(a.x_mm, b.x_mm, fraction),
            _between(a.y_mm, b.y_mm, fraction),
            _between(a.z_mm, b.z_mm, fraction),
        )

    def pose(self, fraction: float) -> Pose:
        """Return the line's pose at a fraction (0 to 1) of its length."""
        if fraction >= 1.0:
            return self.end
        if self.arm.task is Task.WHOLE:
            angle = norm(self.turn)
            rotation = self.rotation
            if angle > 0.0:
                rotation = multiply(AxisAngle(self.turn, angle * fraction).rotation(), rotation)
            frame = transform(rotation, self.tip(fraction))
            return pose_of(frame, self.arm.task, self.arm.centre)
        return Pose(
            *self.tip(fraction),
            _between(self.origin.pitch_rad, self.end.pitch_rad, fraction),
            _between(self.origin.roll_rad, self.end.roll_rad, fraction),
        )

    def solve(self, fraction: float, before: Joints) -> Joints:
        """Return the posture at a fraction, near the one before; raises `PathBroken`."""
        pose = self.pose(fraction)
        found = self.arm.meet(self.arm.goal(pose), before, self.chain)
        if not found.ok:
            raise PathBroken(fraction, pose, _reason(found))
        joints = self.arm.joints_of(found.joints)
        turns = [abs(b - a) for a, b in zip(before, joints, strict=True)]
        if max(turns) > LARGEST_TURN_RAD:
            name = joints.names[turns.index(max(turns))].replace("_", " ")
            raise PathBroken(
                fraction,
                pose,
                f"the {name} would have to turn by {math.degrees(max(turns)):.0f}° at once, "
                "because the posture is singular there",
            )
        return joints


def chain_line(arm: ChainArm, start: Joints, goal: Pose) -> ChainLine:
    """Return the line from a posture to a pose."""
    origin = arm.fk(start)
    arm.goal(goal)  # refuses a yaw that is missing, or that this arm cannot take
    frame = arm.chain.fk(start.angles_rad)
    turn: Vector = (0.0, 0.0, 0.0)
    if arm.task is Task.WHOLE:
        wanted = rotation_of(arm.goal(goal).frame)
        turn = rotation_vector(multiply(wanted, transpose(rotation_of(frame))))
        end = goal
    else:
        end = replace(
            goal,
            pitch_rad=origin.pitch_rad + wrap(goal.pitch_rad - origin.pitch_rad),
            roll_rad=origin.roll_rad + wrap(goal.roll_rad - origin.roll_rad),
        )
    return ChainLine(arm, origin, end, rotation_of(frame), turn, _widened(arm, start))


def _widened(arm: ChainArm, start: Joints) -> Chain:
    """Return the chain with its limits widened to a posture beyond them."""
    if not arm.violations(start):
        return arm.chain
    links = tuple(
        replace(link, low=min(link.low, angle), high=max(link.high, angle))
        for link, angle in zip(arm.chain.links, start, strict=True)
    )
    return replace(arm.chain, links=links)


def _reason(found: Solution) -> str:
    if found.at_limit:
        return f"the {found.at_limit[0].replace('_', ' ')} would pass its limit"
    return "no posture near the one before holds the hand there"


def _between(a: float, b: float, fraction: float) -> float:
    return b if fraction >= 1.0 else a + fraction * (b - a)
