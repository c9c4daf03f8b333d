"""The posture of a link table near another: a small step away, or all along a curve of the tip.

Units: mm and rad. Five joints take pitch and roll in proportion, each the shorter way round: a
hand is the two angles, of any turn. Six turn the hand about one axis, the shorter way, which no
angle's own degeneracy disturbs: a hand is the unit quaternion of its rotation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from kinematics.chains.chain import Chain
from kinematics.chains.closed_form import closed_form
from kinematics.chains.descent import QUICK, Descent
from kinematics.chains.goals import Goal, HandTask, goal_of, pose_of
from kinematics.chains.inverse import Solution, descend
from kinematics.frames.orientations import Quaternion, quaternion_of
from kinematics.frames.transforms import homogeneous, position_of, rotation_of
from kinematics.frames.vectors import Vector
from kinematics.geometry import Hand, NotFollowed, Point
from kinematics.limits import LIMIT_TOLERANCE_RAD
from kinematics.paths.curves import Line, hand_near, in_proportion, refuse_leap, straight_between
from kinematics.spaces import Joints, Pose

LARGEST_TURN_RAD = 0.1
"""The furthest that a joint may turn between two waypoints, so that the hand's direction, which
is no sum of joint angles here, stays within some thousandths of a rad of the line's."""


@dataclass(frozen=True, slots=True)
class ChainFollower:
    """The posture near the one before; `chain` has limits widened to the start."""

    chain: Chain
    task: HandTask
    first: Hand
    posture = ""

    @property
    def centre(self) -> Vector:
        """A point of the base axis, from which outwards is counted."""
        return position_of(self.chain.base)

    def hand(self, pose: Pose, near: Hand) -> Hand:
        """Return how a pose holds the hand; refuses a yaw that is missing or cannot be taken."""
        goal = goal_of(pose, self.task, self.centre)
        if self.task is HandTask.WHOLE:
            turn = _four(quaternion_of(rotation_of(goal.frame)))
            opposite = sum(a * b for a, b in zip(near, turn, strict=True)) < 0.0
            return tuple(-part for part in turn) if opposite else turn
        return hand_near(pose, near)

    def between(self, a: Hand, b: Hand, share: float) -> Hand:
        """Return the hand at a share of the turn from one to another."""
        if self.task is HandTask.WHOLE and share < 1.0:
            return _turned(a, b, share)
        return in_proportion(a, b, share)

    def pose(self, tip: Point, hand: Hand) -> Pose:
        """Return the pose of a tip and a hand."""
        if self.task is HandTask.WHOLE:
            frame = homogeneous(Quaternion.of(*hand).rotation(), tip)
            return pose_of(frame, self.task, self.centre)
        return Pose(*tip, *hand)

    def solve(self, tip: Point, hand: Hand, before: Joints) -> Joints:
        """Return the posture near the one before; raises `NotFollowed`."""
        goal = goal_of(self.pose(tip, hand), self.task, self.centre)
        near = self._closed_posture(goal, before)
        if near is None:
            found = descend(self.chain, goal, before.angles_rad)
            if not found.ok:
                raise NotFollowed(_reason(found))
            near = found.joints
        joints = Joints(near, self.chain.joint_names)
        refuse_leap(before, joints, LARGEST_TURN_RAD)
        return joints

    def _closed_posture(self, goal: Goal, before: Joints) -> tuple[float, ...] | None:
        closed = closed_form(self.chain)
        if closed is None or not closed.structure.exact or not closed.solves(goal):
            return None
        return closed.nearest(goal, before.angles_rad)


def chain_line(chain: Chain, task: HandTask, start: Joints, origin: Pose, goal: Pose) -> Line:
    """Return the line to a pose from a posture, whose own pose is `origin`."""
    first: Hand = (origin.pitch_rad, origin.roll_rad)
    if task is HandTask.WHOLE:
        first = _four(quaternion_of(rotation_of(chain.fk(start.angles_rad))))
    follower = ChainFollower(_widened(chain, start), task, first)
    tip = origin.x_mm, origin.y_mm, origin.z_mm
    return straight_between(follower, tip, first, goal)


def _four(turn: Quaternion) -> Hand:
    return turn.w, turn.x, turn.y, turn.z


def _turned(a: Hand, b: Hand, share: float) -> Hand:
    """Return the unit quaternion at a share of the turn about one axis (Shoemake, 1985).

    The angle is that of half difference and half sum, which is exact for small turns.
    """
    apart = math.dist(a, b)
    half = 2.0 * math.atan2(apart, math.hypot(*map(float.__add__, a, b)))
    if half == 0.0:
        return a
    sine = math.sin(half)
    first, second = math.sin((1.0 - share) * half) / sine, math.sin(share * half) / sine
    return tuple(first * one + second * two for one, two in zip(a, b, strict=True))


def _widened(chain: Chain, start: Joints) -> Chain:
    """Return the chain with its limits widened to a posture beyond them."""
    if not chain.violations(start.angles_rad):
        return chain
    pairs = zip(chain.limits, start, strict=True)
    return chain.within((min(low, angle), max(high, angle)) for (low, high), angle in pairs)


def _reason(found: Solution) -> str:
    if found.at_limit:
        return f"the {found.at_limit[0].replace('_', ' ')} would pass its limit"
    return "no posture near the one before holds the hand there"


# The posture of a chain a small step from one that is known, quickly, or none. A jog asks for this
# many times in each leg, also for points that cannot be reached, and has no time for reasons:
# `ik_near` gives those.

INSIDE_RAD = 0.05
"""How far from a joint's limit the second look begins."""


def near_posture(chain: Chain, goal: Goal, start: Sequence[float]) -> tuple[float, ...] | None:
    """Return the posture within the limits a small step from a start that meets a goal, or None.

    A singular posture is often one with a joint at its limit, as a straight elbow is: no slope
    leads out of it, so that a look from further inside comes second.
    """
    descent = Descent(chain, goal, limited=False)
    found = descent.met(start, QUICK)
    if found is None:
        inside = [
            min(max(value, low + INSIDE_RAD), high - INSIDE_RAD)
            for value, (low, high) in zip(start, chain.limits, strict=True)
        ]
        found = descent.met(inside, QUICK) if inside != list(start) else None
    if found is None:
        return None
    bounded = chain.clamp(found)
    excess = max(abs(a - b) for a, b in zip(bounded, found, strict=True))
    return bounded if excess <= LIMIT_TOLERANCE_RAD else None  # more than rounding
