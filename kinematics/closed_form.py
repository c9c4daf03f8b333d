"""The closed form of the five-axis build on bare floats: forward, and every inverse branch.

Source: McKerrow, chapter 4, section 16 (the Mini-mover 5), whose elbow triangle is here written
for an upper arm and a forearm of any lengths. Lengths in mm, angles in rad; nothing is checked
and nothing but floats and tuples is made, because planners call this thousands of times.
"""

from __future__ import annotations

import math

AXIS_MM = 1e-9
"""Nearer to the base axis than this, a tip is on it, and its direction from it means nothing."""

REACH_MM = 1e-9
"""How far beyond full stretch (or within full fold) rounding may put a wrist that touches it."""

Lengths = tuple[float, float, float, float]
"""Height of the shoulder axis, upper arm, forearm, hand."""

Angles = tuple[float, float, float, float, float]
"""Base, shoulder, elbow, wrist pitch, wrist roll."""


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
    """Return x, y, z, pitch and roll (in the hand's frame), neither angle wrapped.

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
    """Return (shoulder, elbow) with the elbow up, and down; None where the sides cannot meet.

    The wrist is given from the shoulder axis. Where it lies on that axis (equal lengths, folded)
    the shoulder is free and takes `free_shoulder`.
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
    """Return the cosine of the elbow's bend by the cosine rule; None where no triangle closes.

    `square` is the wrist's squared distance from the shoulder axis. One that rounding has put a
    hair beyond full stretch or within full fold counts as touching it.
    """
    cosine = (square - (upper * upper + fore * fore)) / (2.0 * upper * fore)
    if -1.0 <= cosine <= 1.0:
        return cosine
    distance = math.sqrt(square)
    if abs(upper - fore) - REACH_MM <= distance <= upper + fore + REACH_MM:
        return 1.0 if cosine > 0.0 else -1.0
    return None


def inverse(
    goal: tuple[float, float, float, float, float],
    lengths: Lengths,
    table_roll: float,
    seed: Angles,
) -> list[tuple[bool, bool, Angles]]:
    """Return every branch as (base is back, elbow is down, angles); none where out of reach.

    The angles are of any turn. `table_roll` is 1 where the goal's roll is given in the table's
    frame and 0 where in the hand's. A tip on the base axis leaves the base free: it takes the
    seed's base and only front branches, of which the pitch on the axis is the convention.

    The back branches are the front ones mirrored in the base axis: the links stand where they
    stood, driven from the other side.
    """
    x, y, z, pitch, roll = goal
    height, upper, fore, hand = lengths
    r = math.hypot(x, y)
    on_axis = r <= AXIS_MM
    base = seed[0] if on_axis else math.atan2(y, x)
    pair = elbow_triangle(
        r - hand * math.cos(pitch), z - height - hand * math.sin(pitch), upper, fore, seed[1]
    )
    if pair is None:
        return []
    roll += table_roll * base
    found: list[tuple[bool, bool, Angles]] = []
    for down, (shoulder, elbow) in zip((False, True), pair, strict=True):
        wrist = pitch - shoulder - elbow
        found.append((False, down, (base, shoulder, elbow, wrist, roll)))
        if not on_axis:
            mirrored = (base + math.pi, math.pi - shoulder, -elbow, -wrist, roll + math.pi)
            found.append((True, down, mirrored))
    return found
