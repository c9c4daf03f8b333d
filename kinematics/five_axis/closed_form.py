"""The closed form of the five-axis build on bare floats: forward, every branch, the nearest one.

Source: McKerrow, chapter 4, section 16 (the Mini-mover 5), with the elbow triangle generalised to
an upper arm and a forearm of any lengths. Lengths in mm, angles in rad. Arguments are not checked,
and only floats and tuples are created, because planners call these functions thousands of times.
"""

from __future__ import annotations

import math
from typing import Protocol

from kinematics.frames.transforms import Transform
from kinematics.geometry import AXIS_MM
from kinematics.limits import JointRange, all_fitted

# How far rounding may put a wrist beyond full stretch, or within full fold.
REACH_MM = 1e-9

# Height of the shoulder axis, upper arm, forearm, hand.
Lengths = tuple[float, float, float, float]

# Base, shoulder, elbow, wrist pitch, wrist roll.
Angles = tuple[float, float, float, float, float]


def branch_name(*, back: bool, up: bool) -> str:
    """Return the name of a branch: the base faces the tip or has its back to it.

    The elbow is up or down: on which side of the line from shoulder to wrist, seen outwards.
    """
    return f"base {'back' if back else 'front'}, elbow {'up' if up else 'down'}"


class Dimensions(Protocol):
    """Lengths and joint ranges of an arm of this build; they determine everything else."""

    @property
    def lengths(self) -> Lengths:
        """Base height, upper arm, forearm and hand in mm."""

    @property
    def limits(self) -> tuple[JointRange, ...]:
        """The range of each joint."""


def plane_tip(
    shoulder: float, elbow: float, wrist: float, lengths: Lengths
) -> tuple[float, float, float]:
    """Return the tip's signed distance from the base axis, its height, and the hand's pitch.

    All in the arm's own plane, in which a tip behind the base axis has a negative distance.
    """
    height, upper, fore, hand = lengths
    forearm = shoulder + elbow
    pitch = forearm + wrist
    r = upper * math.cos(shoulder) + fore * math.cos(forearm) + hand * math.cos(pitch)
    z = upper * math.sin(shoulder) + fore * math.sin(forearm) + hand * math.sin(pitch)
    return r, z + height, pitch


def forward(angles: Angles, lengths: Lengths) -> tuple[float, float, float, float, float]:
    """Return x, y, z, pitch and roll, neither angle wrapped.

    A tip behind the base axis is described as one in front of the opposite direction: pitch P
    in the arm's plane is pi - P seen outwards, and the roll's reference turns by pi.
    """
    base, shoulder, elbow, wrist, roll = angles
    r, z, pitch = plane_tip(shoulder, elbow, wrist, lengths)
    if r < -AXIS_MM:
        pitch, roll = math.pi - pitch, roll + math.pi
    return r * math.cos(base), r * math.sin(base), z, pitch, roll


def wrist_distance(r: float, z: float, pitch: float, lengths: Lengths) -> float:
    """Return how far from the shoulder axis the wrist must be for this tip, r outwards."""
    return math.hypot(
        r - lengths[3] * math.cos(pitch), z - lengths[0] - lengths[3] * math.sin(pitch)
    )


def elbow_triangle(
    wrist_r: float, wrist_z: float, upper: float, fore: float, free_shoulder: float
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Return (shoulder, elbow) with the elbow up, and down; None if the sides cannot meet.

    The wrist is given relative to the shoulder axis. If it lies on that axis (equal lengths,
    folded), the shoulder is free and takes `free_shoulder`.
    """
    square = wrist_r * wrist_r + wrist_z * wrist_z
    cosine = elbow_cosine(square, upper, fore)
    if cosine is None:
        return None
    bend = math.acos(cosine)
    if square <= REACH_MM * REACH_MM:
        return (free_shoulder, -bend), (free_shoulder, bend)
    direction = math.atan2(wrist_z, wrist_r)
    across = fore * math.sqrt((1.0 - cosine) * (1.0 + cosine))
    lift = math.atan2(across, upper + fore * cosine)
    return (direction + lift, -bend), (direction - lift, bend)


def elbow_cosine(square: float, upper: float, fore: float) -> float | None:
    """Return the cosine of the elbow's bend by the cosine rule; None if no triangle closes.

    `square` is the wrist's squared distance from the shoulder axis. A distance that rounding has
    put slightly beyond full stretch or within full fold counts as touching it.
    """
    cosine = (square - (upper * upper + fore * fore)) / (2.0 * upper * fore)
    if -1.0 <= cosine <= 1.0:
        return cosine
    distance = math.sqrt(square)
    if abs(upper - fore) - REACH_MM <= distance <= upper + fore + REACH_MM:
        return 1.0 if cosine > 0.0 else -1.0
    return None


def inverse(
    goal: Angles, lengths: Lengths, near: Angles, facing: float | None = None
) -> list[tuple[str, Angles]]:
    """Return every branch with its angles for x, y, z, pitch and roll; none if out of reach.

    The angles are of any turn. A tip on the base axis leaves the base free: it takes that of
    `near` and has only front branches, whose pitch is the convention on the axis. With `facing`,
    the direction of a hand that leans over the axis, it is not free.

    The back branches mirror the front ones in the base axis: the links are in the same place,
    driven from the other side.
    """
    x, y, z, pitch, roll = goal
    height, upper, fore, hand = lengths
    r = math.hypot(x, y)
    if r > AXIS_MM:
        facing = math.atan2(y, x)
    base = near[0] if facing is None else facing
    pair = elbow_triangle(
        r - hand * math.cos(pitch), z - height - hand * math.sin(pitch), upper, fore, near[1]
    )
    if pair is None:
        return []
    found: list[tuple[str, Angles]] = []
    for up, (shoulder, elbow) in zip((True, False), pair, strict=True):
        wrist = pitch - shoulder - elbow
        found.append((branch_name(back=False, up=up), (base, shoulder, elbow, wrist, roll)))
        if facing is not None:
            mirrored = (base + math.pi, math.pi - shoulder, -elbow, -wrist, roll + math.pi)
            found.append((branch_name(back=True, up=up), mirrored))
    return found


def nearest_branch(
    goal: Angles, facing: float | None, arm: Dimensions, near: Angles
) -> Angles | None:
    """Return the branch within limits with the least sum of squared changes from `near`, or None.

    `goal` and `facing` are those of `inverse`.
    """
    best: Angles | None = None
    least = math.inf
    spans = [(bounds.low_rad, bounds.high_rad) for bounds in arm.limits]
    for _, angles in inverse(goal, arm.lengths, near, facing):
        turned = all_fitted(angles, spans, near)
        if turned is not None:
            change = math.dist(turned, near)
            if change < least:
                base, shoulder, elbow, wrist, roll = turned
                best, least = (base, shoulder, elbow, wrist, roll), change
    return best


# The hand as a full frame.
#
# Lengths in mm, angles in rad. Axes of the hand's frame: z along the hand (the approach), x up from
# the hand's back where the roll is zero, y to complete a right-handed frame: the last frame of the
# arm's link table (McKerrow, chapter 4, section 16), with alpha = 90, 0, 0, 90, 0 degrees.


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
