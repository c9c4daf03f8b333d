"""One posture of the five-axis build, kept along a straight line or any other curve of the tip.

Units: mm and rad. A hand is its pitch (seen outwards, of any turn) and the angle of the wrist roll.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinematics.five_axis.closed_form import (
    Dimensions,
    Lengths,
    elbow_triangle,
    plane_tip,
    wrist_distance,
)
from kinematics.geometry import AXIS_MM, Hand, NotFollowed, Point
from kinematics.limits import LIMIT_TOLERANCE_RAD, JointRange, turn_near, widened_to, wrap
from kinematics.paths.curves import Line, in_proportion, straight_between
from kinematics.spaces import JOINT_NAMES, Joints, Pose

STRAIGHT_RAD = 1e-6
"""An elbow nearer to straight than this is on neither side; the side allowed by its range is used.
"""


@dataclass(frozen=True, slots=True, eq=False)
class FiveAxisFollower:
    """The branch on which a curve is followed.

    `back` says that the tip is behind the base axis, and `elbow_sign` whether the elbow's angle is
    above or below zero: the branch. `ranges` are the arm's limits, widened to the start where it
    lies outside them. The wrist roll is the pose's roll and `roll_offset`.
    """

    lengths: Lengths
    first: Hand
    back: bool
    elbow_sign: float
    roll_offset: float
    ranges: tuple[JointRange, ...]

    @property
    def posture(self) -> str:
        """The branch in words."""
        up = (self.elbow_sign < 0.0) != self.back
        return f"elbow {'up' if up else 'down'}, base {'back' if self.back else 'front'}"

    def hand(self, pose: Pose, near: Hand) -> Hand:
        """Return how a pose holds the hand: pitch and roll turn the shorter way round.

        The roll takes the longer way if the wrist's range forbids the shorter one.
        """
        pitch = turn_near(pose.pitch_rad, near[0])
        change = wrap(pose.roll_rad + self.roll_offset - near[1])
        if not self._rolls_to(near[1] + change):
            other = change - math.copysign(math.tau, change)
            change = other if self._rolls_to(near[1] + other) else change
        return pitch, near[1] + change

    def between(self, a: Hand, b: Hand, share: float) -> Hand:
        """Return the hand at a share of the turn: pitch and roll in proportion."""
        return in_proportion(a, b, share)

    def pose(self, tip: Point, hand: Hand) -> Pose:
        """Return the pose of a tip and a hand, with pitch and roll of any turn."""
        return Pose(*tip, hand[0], hand[1] - self.roll_offset)

    def solve(self, tip: Point, hand: Hand, before: Joints) -> Joints:
        """Return the posture, with the base's turn nearest to the previous posture.

        Raises `NotFollowed` if the wrist is out of reach or a joint beyond its range.
        """
        x, y, z = tip
        pitch, roll = hand
        height, upper, fore, length = self.lengths
        old_base, old_shoulder, old_elbow, old_wrist, _ = before.angles_rad
        r = math.hypot(x, y)
        base = old_base
        if r > AXIS_MM:
            base += math.remainder(math.atan2(y, x) + math.pi * self.back - base, math.tau)
        if self.back:
            r, pitch = -r, math.pi - pitch
        wrist_r, wrist_z = r - length * math.cos(pitch), z - height - length * math.sin(pitch)
        pair = elbow_triangle(wrist_r, wrist_z, upper, fore, old_shoulder)
        if pair is None:
            raise NotFollowed(self._span(tip, hand[0]))
        shoulder, elbow = pair[self.elbow_sign > 0.0]
        shoulder += math.tau * round((old_shoulder - shoulder) / math.tau)
        elbow += math.tau * round((old_elbow - elbow) / math.tau)
        wrist = pitch - shoulder - elbow
        wrist += math.tau * round((old_wrist - wrist) / math.tau)
        return Joints(self._limited((base, shoulder, elbow, wrist, roll)))

    def _limited(self, angles: tuple[float, ...]) -> tuple[float, ...]:
        """Return the angles, snapped to limits that they exceed by rounding only."""
        snapped = []
        for name, angle, bounds in zip(JOINT_NAMES, angles, self.ranges, strict=True):
            inside = bounds.clamp(angle)
            if abs(angle - inside) > LIMIT_TOLERANCE_RAD:
                raise NotFollowed(
                    f"the {name.replace('_', ' ')} would pass its limit of "
                    f"{math.degrees(inside):.1f}°"
                )
            snapped.append(inside)
        return tuple(snapped)

    def _span(self, tip: Point, pitch: float) -> str:
        x, y, z = tip
        distance = wrist_distance(math.hypot(x, y), z, pitch, self.lengths)
        _, upper, fore, _ = self.lengths
        longest = upper + fore
        if distance > longest:
            return f"the wrist would be further away than the {longest:.1f} mm that the arm spans"
        return f"the wrist would be nearer to the shoulder than {abs(upper - fore):.1f} mm"

    def _rolls_to(self, angle: float) -> bool:
        return abs(self.ranges[4].clamp(angle) - angle) <= LIMIT_TOLERANCE_RAD


def line_from(arm: Dimensions, start: Joints, origin: Pose, goal: Pose) -> Line:
    """Return the line to a pose, with the turns of pitch and roll and its branch chosen.

    It begins in the posture `start`, whose pose is `origin`.
    """
    r, _, _ = plane_tip(start[1], start[2], start[3], arm.lengths)
    follower = FiveAxisFollower(
        arm.lengths,
        (origin.pitch_rad, start[4]),
        r < -AXIS_MM,
        _elbow_sign(wrap(start[2]), arm.limits[2]),
        start[4] - origin.roll_rad,
        widened_to(arm.limits, start),
    )
    tip = origin.x_mm, origin.y_mm, origin.z_mm
    return straight_between(follower, tip, follower.first, goal)


def _elbow_sign(elbow: float, bounds: JointRange) -> float:
    """Return the side to which the forearm is bent: that of the start, or the allowed one."""
    if abs(elbow) > STRAIGHT_RAD:
        return math.copysign(1.0, elbow)
    return -1.0 if bounds.low_rad < -STRAIGHT_RAD else 1.0
