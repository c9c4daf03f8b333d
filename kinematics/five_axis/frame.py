"""The hand as a full frame: forward to a 4x4, and the inverse of any 4x4, honest about five axes.

Lengths in mm, angles in rad. Axes of the hand's frame: z along the hand (the approach), x up from
the hand's back where the roll is zero, y to complete a right-handed frame: the last frame of the
arm's link table (McKerrow, chapter 4, section 16), with alpha = 90, 0, 0, 90, 0 degrees.

Five axes cannot turn the hand out of the vertical plane through the base axis and the tip, so
most frames in space have no posture. The sine of the angle by which the goal's approach leaves
that plane is what a five-axis arm must be told of, and what a general solver keeps to itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import asin, atan2, hypot
from typing import NamedTuple

from kinematics.five_axis.closed_form import Angles, ArmBuild, Lengths, nearest_posture
from kinematics.frames.transforms import Transform
from kinematics.spaces import Joints, Pose

NEAR_AXIS_MM = 1e-6
"""Nearer to the base axis than this, the plane is taken from the hand and not from the tip."""

UPRIGHT = 1e-9
"""A hand whose horizontal part is smaller than this is vertical, and lies in every plane."""

ON_MANIFOLD_RAD = 1e-6
"""A frame this near to one that five axes can give counts as one of them."""


class FrameAngles(NamedTuple):
    """What the bare solver answers: the angles, or None, and how the goal's plane was found.

    `off_rad` is how far the approach leaves the arm's plane, `base_free` true where the tip is
    on the base axis and the hand vertical, so that the seed's base was taken.
    """

    angles: Angles | None
    off_rad: float
    base_free: bool
    goal: tuple[float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class FrameSolution:
    """How far an arm meets a goal given as a full frame.

    `pose` is the goal as far as five axes can give it, the position kept and the approach turned
    by `off_manifold_rad` into the arm's plane; `joints` the posture within the limits nearest to
    the seed that holds it, or None where none does (`FiveAxisArm.ik` of `pose` says why).
    """

    joints: Joints | None
    pose: Pose
    off_manifold_rad: float
    base_free: bool

    @property
    def on_manifold(self) -> bool:
        """Whether the goal's direction is one that five axes can give at that place."""
        return self.off_manifold_rad <= ON_MANIFOLD_RAD

    @property
    def met(self) -> bool:
        """Whether the posture holds the whole goal: position, direction and roll."""
        return self.joints is not None and self.on_manifold


def forward_frame(angles: Angles, lengths: Lengths) -> Transform:
    """Return the hand's frame in the arm's base frame."""
    base, shoulder, elbow, wrist, roll = angles
    height, upper, fore, hand = lengths
    forearm = shoulder + elbow
    pitch = forearm + wrist
    cos_base, sin_base = math.cos(base), math.sin(base)
    cos_pitch, sin_pitch = math.cos(pitch), math.sin(pitch)
    cos_roll, sin_roll = math.cos(roll), math.sin(roll)
    r = upper * math.cos(shoulder) + fore * math.cos(forearm) + hand * cos_pitch
    z = upper * math.sin(shoulder) + fore * math.sin(forearm) + hand * sin_pitch + height
    up_r, side_r = sin_pitch * cos_roll, sin_pitch * sin_roll
    return (
        (
            sin_base * sin_roll - cos_base * up_r,
            sin_base * cos_roll + cos_base * side_r,
            cos_base * cos_pitch,
            cos_base * r,
        ),
        (
            -cos_base * sin_roll - sin_base * up_r,
            -cos_base * cos_roll + sin_base * side_r,
            sin_base * cos_pitch,
            sin_base * r,
        ),
        (cos_pitch * cos_roll, -cos_pitch * sin_roll, sin_pitch, z),
        (0.0, 0.0, 0.0, 1.0),
    )


def solve_frame(goal: Transform, arm: ArmBuild, near: Angles) -> FrameAngles:
    """Return the posture within limits nearest to `near`, and how far the goal is off.

    Nothing is checked: `goal` must be a transform of finite numbers. A goal off the manifold is
    answered by the frame nearest to it of those with the same position.
    """
    (ux, vx, hx, x), (uy, vy, hy, y), (uz, vz, hz, z), _ = goal
    r = hypot(x, y)
    base_free = False
    if r > NEAR_AXIS_MM:
        cos_base, sin_base = x / r, y / r
        base = atan2(y, x)
    else:
        base, base_free = (near[0], True) if hypot(hx, hy) <= UPRIGHT else (atan2(hy, hx), False)
        cos_base, sin_base = math.cos(base), math.sin(base)
        r = x * cos_base + y * sin_base
    out = hx * cos_base + hy * sin_base
    off = hx * sin_base - hy * cos_base
    if -1e-9 < off < 1e-9:
        off_rad = abs(off)
        cos_pitch, sin_pitch, pitch = out, hz, atan2(hz, out)
        up_side = ux * sin_base - uy * cos_base
        roll = atan2(up_side, uz * cos_pitch - sin_pitch * (ux * cos_base + uy * sin_base))
    else:
        off_rad = asin(min(abs(off), 1.0))
        pitch = atan2(hz, out)
        cos_pitch, sin_pitch = math.cos(pitch), math.sin(pitch)
        up = ux * cos_base + uy * sin_base, ux * sin_base - uy * cos_base, uz
        side = vx * cos_base + vy * sin_base, vx * sin_base - vy * cos_base, vz
        roll = atan2(
            up[1] - side[2] * cos_pitch + side[0] * sin_pitch,
            up[2] * cos_pitch - up[0] * sin_pitch + side[1],
        )
    angles = nearest_posture(
        base,
        r - arm.hand * cos_pitch,
        z - arm.height - arm.hand * sin_pitch,
        pitch,
        roll,
        not base_free,
        arm,
        near,
    )
    return FrameAngles(angles, off_rad, base_free, (x, y, z, pitch, roll))


def frame_solution(found: FrameAngles) -> FrameSolution:
    """Return what the bare solver found in the types of the three spaces."""
    x, y, z, pitch, roll = found.goal
    return FrameSolution(
        None if found.angles is None else Joints(found.angles),
        Pose(x, y, z, pitch, roll),
        found.off_rad,
        found.base_free,
    )
