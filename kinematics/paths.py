"""Paths between postures: straight in the joints, or straight in x, y, z, pitch and roll.

Units: mm and rad. A straight line is solved on one branch of the inverse kinematics and cut into
joint motions short enough that the tip stays within a tolerance of the line (chords.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from kinematics.arm_geometry import ArmGeometry
from kinematics.chords import corners, cut, smooth
from kinematics.spaces import Joints, Pose

Point = tuple[float, ...]

LINE_TOLERANCE_MM = 0.5
"""How far the tip may leave a straight line by default: less than two steps of a TeachMover."""


@dataclass(frozen=True, slots=True)
class JointPath:
    """A motion in which every joint turns in proportion, from one posture to another."""

    start: Joints
    goal: Joints

    def at(self, fraction: float) -> Joints:
        """Return the posture at a fraction (0 to 1) of the way; the ends are exact."""
        if fraction >= 1.0:
            return self.goal
        return Joints(
            tuple(a + fraction * (b - a) for a, b in zip(self.start, self.goal, strict=True)),
            self.start.names,
        )

    @property
    def changes_rad(self) -> tuple[float, ...]:
        """How far each joint turns."""
        return tuple(b - a for a, b in zip(self.start, self.goal, strict=True))


def joint_path(start: Joints, goal: Joints) -> JointPath:
    """Return the joint motion between two postures; ranges are convex, so checking ends is enough.

    Guards are another matter: see guards_path.py.
    """
    return JointPath(start, goal)


def line_path(
    arm: ArmGeometry, start: Joints, goal: Pose, tolerance_mm: float = LINE_TOLERANCE_MM
) -> tuple[Joints, ...]:
    """Return waypoints, the start included, of a straight line from a posture to a pose.

    Straight in x, y, z, pitch and roll: pitch takes the shorter way round, and so does roll
    unless the wrist's range forbids it. All waypoints are on the start's branch. With the joints
    turning in proportion between waypoints, the tip is never further than `tolerance_mm` from
    the point of the line at the same fraction; pitch and roll, being sums of joint angles, are
    exact. At a waypoint the direction in joint space turns by at most 15 degrees (chords.py).
    Raises `PathBroken` where the reach, a limit, or the branch ends. A joint that starts beyond
    its limit may come back, but not go further.
    """
    return corners(smooth(cut(arm, arm.line(start, goal), start, tolerance_mm)))


def deviation_mm(
    arm: ArmGeometry, waypoints: Sequence[Joints], goal: Pose, samples: int = 16
) -> float:
    """Return the largest distance of the tip from the straight line to `goal`, in mm.

    The joints turn in proportion between waypoints; each such motion is looked at `samples` times.
    """
    first = arm.fk(waypoints[0])
    origin = first.x_mm, first.y_mm, first.z_mm
    end = goal.x_mm, goal.y_mm, goal.z_mm
    worst = 0.0
    for a, b in pairwise(waypoints):
        for index in range(samples + 1):
            tip = arm.points(JointPath(a, b).at(index / samples))[-1]
            worst = max(worst, _off_segment(tip, origin, end))
    return worst


def _off_segment(point: Point, start: Point, end: Point) -> float:
    """Return the distance in mm of a point from the straight segment between two others."""
    along = tuple(b - a for a, b in zip(start, end, strict=True))
    length = sum(part * part for part in along)
    if length == 0.0:
        return math.dist(point, start)
    share = sum(d * (p - a) for d, p, a in zip(along, point, start, strict=True)) / length
    share = min(max(share, 0.0), 1.0)
    return math.dist(point, tuple(a + share * d for a, d in zip(start, along, strict=True)))
