"""What followers of every build do alike: turn the hand in proportion, refuse to leap.

Units: rad. Of a hand that is two angles the first is its pitch and the second its roll, each of
any turn.
"""

from __future__ import annotations

import math

from kinematics.arm_geometry import Hand, NotFollowed
from kinematics.limits import turn_near
from kinematics.spaces import Joints, Pose


def hand_near(pose: Pose, near: Hand) -> Hand:
    """Return a pose's pitch and roll, each the shorter way round from another hand."""
    return turn_near(pose.pitch_rad, near[0]), turn_near(pose.roll_rad, near[1])


def in_proportion(a: Hand, b: Hand, share: float) -> Hand:
    """Return the hand at a share (0 to 1) of the turn, both angles in proportion; b is exact."""
    if share >= 1.0:
        return b
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def refuse_leap(before: Joints, reached: Joints, most_rad: float) -> None:
    """Raise `NotFollowed` where a joint would turn by more than `most_rad` between waypoints."""
    name, turn_rad = largest_turn(before, reached)
    if turn_rad > most_rad:
        raise NotFollowed(leap_sentence(name, turn_rad, "the posture is singular there"))


def largest_turn(before: Joints, reached: Joints) -> tuple[str, float]:
    """Return the joint that turns furthest, and by how much."""
    turns = [abs(b - a) for a, b in zip(before, reached, strict=True)]
    furthest = max(turns)
    return reached.names[turns.index(furthest)], furthest


def leap_sentence(joint: str, turn_rad: float, why: str) -> str:
    """Return the reason for refusing to turn a joint so far in one step."""
    turn = f"{math.degrees(turn_rad):.0f}° at once"
    return f"the {joint.replace('_', ' ')} would have to turn by {turn}, because {why}"
