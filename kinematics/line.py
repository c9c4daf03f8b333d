"""A straight line in x, y, z, pitch and roll, solved point by point on one branch.

Units: mm and rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinematics.closed_form import AXIS_MM, elbow_triangle, plane_tip, wrist_distance
from kinematics.errors import PathBroken
from kinematics.five_axis import FiveAxisArm
from kinematics.limits import LIMIT_TOLERANCE_RAD, JointRange, wrap
from kinematics.spaces import JOINT_NAMES, Joints, Pose

STRAIGHT_RAD = 1e-6
"""An elbow nearer to straight than this is on neither side; the side its range allows is taken."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line from a posture to a pose, and the branch on which it is followed.

    `end` has the start's own turns of pitch and roll; `back` says that the tip is behind the
    base axis, and `elbow_sign` whether the elbow's angle is above or below zero: the branch.
    `ranges` are the arm's limits, widened to the start where it lies outside them.
    """

    arm: FiveAxisArm
    start: Joints
    origin: Pose
    end: Pose
    roll_change: float
    back: bool
    elbow_sign: float
    ranges: tuple[JointRange, ...]

    def pose(self, fraction: float) -> Pose:
        """Return the line's pose at a fraction (0 to 1) of its length."""
        a, b = self.origin, self.end
        return Pose(
            _between(a.x_mm, b.x_mm, fraction),
            _between(a.y_mm, b.y_mm, fraction),
            _between(a.z_mm, b.z_mm, fraction),
            _between(a.pitch_rad, b.pitch_rad, fraction),
            _between(a.roll_rad, a.roll_rad + self.roll_change, fraction),
        )

    def tip(self, fraction: float) -> tuple[float, float, float]:
        """Return the point of the line at a fraction of its length."""
        a, b = self.origin, self.end
        return (
            _between(a.x_mm, b.x_mm, fraction),
            _between(a.y_mm, b.y_mm, fraction),
            _between(a.z_mm, b.z_mm, fraction),
        )

    def solve(self, fraction: float, before: Joints) -> Joints:
        """Return the posture at a fraction, its base's turn nearest to the posture before.

        Raises `PathBroken` where the wrist is out of reach or a joint beyond its range.
        """
        x, y, z = self.tip(fraction)
        pitch = _between(self.origin.pitch_rad, self.end.pitch_rad, fraction)
        height, upper, fore, hand = self.arm.lengths
        r = math.hypot(x, y)
        base = before[0]
        if r > AXIS_MM:
            base += math.remainder(math.atan2(y, x) + math.pi * self.back - base, math.tau)
        if self.back:
            r, pitch = -r, math.pi - pitch
        wrist_r, wrist_z = r - hand * math.cos(pitch), z - height - hand * math.sin(pitch)
        pair = elbow_triangle(wrist_r, wrist_z, upper, fore, before[1])
        if pair is None:
            raise PathBroken(fraction, self.pose(fraction), self._span(fraction))
        shoulder, elbow = pair[self.elbow_sign > 0.0]
        shoulder += math.tau * round((before[1] - shoulder) / math.tau)
        elbow += math.tau * round((before[2] - elbow) / math.tau)
        wrist = pitch - shoulder - elbow
        wrist += math.tau * round((before[3] - wrist) / math.tau)
        roll = self.start[4] + fraction * self.roll_change
        return Joints(self._limited(fraction, (base, shoulder, elbow, wrist, roll)))

    def _limited(self, fraction: float, angles: tuple[float, ...]) -> tuple[float, ...]:
        """Return the angles, snapped to limits that rounding has passed."""
        snapped = []
        for name, angle, bounds in zip(JOINT_NAMES, angles, self.ranges, strict=True):
            inside = bounds.clamp(angle)
            if abs(angle - inside) > LIMIT_TOLERANCE_RAD:
                reason = (
                    f"the {name.replace('_', ' ')} would pass its limit of "
                    f"{math.degrees(inside):.1f}°"
                )
                raise PathBroken(fraction, self.pose(fraction), reason)
            snapped.append(inside)
        return tuple(snapped)

    def _span(self, fraction: float) -> str:
        x, y, z = self.tip(fraction)
        pitch = _between(self.origin.pitch_rad, self.end.pitch_rad, fraction)
        distance = wrist_distance(math.hypot(x, y), z, pitch, self.arm.lengths)
        longest = self.arm.upper_arm_mm + self.arm.forearm_mm
        if distance > longest:
            return f"the wrist would be further away than the {longest:.1f} mm that the arm spans"
        shortest = abs(self.arm.upper_arm_mm - self.arm.forearm_mm)
        return f"the wrist would be nearer to the shoulder than {shortest:.1f} mm"


def line_from(arm: FiveAxisArm, start: Joints, goal: Pose) -> Line:
    """Return the line from a posture to a pose, its turns of pitch and roll and branch chosen."""
    origin = arm.fk(start)
    r, _, _ = plane_tip(start[1], start[2], start[3], arm.lengths)
    back = r < -AXIS_MM
    ranges = tuple(
        JointRange(min(bounds.low_rad, angle), max(bounds.high_rad, angle))
        for bounds, angle in zip(arm.limits, start, strict=True)
    )
    roll_change = wrap(goal.roll_rad - origin.roll_rad)
    if not _holds(ranges[4], start[4] + roll_change):
        other = roll_change - math.copysign(math.tau, roll_change)
        roll_change = other if _holds(ranges[4], start[4] + other) else roll_change
    pitch = origin.pitch_rad + wrap(goal.pitch_rad - origin.pitch_rad)
    end = Pose(goal.x_mm, goal.y_mm, goal.z_mm, pitch, origin.roll_rad + roll_change)
    sign = _elbow_sign(wrap(start[2]), arm.limits[2])
    return Line(arm, start, origin, end, roll_change, back, sign, ranges)


def _elbow_sign(elbow: float, bounds: JointRange) -> float:
    """Return the side that the forearm is bent to: that of the start, or one that is allowed."""
    if abs(elbow) > STRAIGHT_RAD:
        return math.copysign(1.0, elbow)
    return -1.0 if bounds.low_rad < -STRAIGHT_RAD else 1.0


def _holds(bounds: JointRange, angle: float) -> bool:
    return abs(bounds.clamp(angle) - angle) <= LIMIT_TOLERANCE_RAD


def _between(a: float, b: float, fraction: float) -> float:
    return b if fraction >= 1.0 else a + fraction * (b - a)
