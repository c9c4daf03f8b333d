"""Inverse kinematics of blocks of goals with numpy: one branch of each, or all four.

Lengths in mm, angles in rad. Each function finds the points whose directions are the angles,
puts them in a stack, and has all of them solved at once. See `batch` for the meaning.
"""

from __future__ import annotations

import math

import numpy as np

from kinematics.batch_frame import wrist_of_frame
from kinematics.batch_stack import Stack, fill_length, solve, stack
from kinematics.batch_trig import Array, sine_cosine, wrap
from kinematics.closed_form import REACH_MM, Lengths


def fill_one_branch(
    lengths: Lengths,
    goals: Array,
    joints: Array,
    row: Array,
    down: bool,
) -> None:
    """Fill the posture of one front branch: base and shoulder are the stack's directions."""
    rows = stack(row, 2)
    wrist_r, wrist_z = _wrist_of_pose(lengths, goals, rows)
    along, across = _triangle(lengths, wrist_r, wrist_z, rows)
    _shoulder(wrist_r, wrist_z, along, across, rows, 1, down)
    angles = joints.T
    solve(rows, angles[:3])
    angles[2] *= 4.0 if down else -4.0
    _wrist(goals[:, 3], angles, rows)
    hole = rows.spare[0]
    np.multiply(angles[2], 0.0, hole)  # 0, or NaN where no triangle closes
    angles[0] += hole
    np.add(goals[:, 4], hole, angles[4])


def fill_branches_of_poses(lengths: Lengths, goals: Array, joints: Array, row: Array) -> None:
    """Fill the four postures of each pose: base and the two shoulders are the directions."""
    rows = stack(row, 3)
    wrist_r, wrist_z = _wrist_of_pose(lengths, goals, rows)
    _both_shoulders(lengths, wrist_r, wrist_z, rows, 1)
    solve(rows, rows.angle)
    _four(goals[:, 3], goals[:, 4], rows.angle[1:], rows, joints)


def fill_branches_of_frames(
    lengths: Lengths, goals: Array, joints: Array, off: Array, row: Array
) -> None:
    """Fill the four postures of each frame: base, roll, pitch and two shoulders."""
    rows = stack(row, 5)
    wrist_r, wrist_z = wrist_of_frame(lengths, goals, off, rows)
    _both_shoulders(lengths, wrist_r, wrist_z, rows, 3)
    solve(rows, rows.angle)
    _four(rows.angle[2], rows.angle[1], rows.angle[3:], rows, joints)


def mirror(joints: Array) -> None:
    """Turn front branches into the back branches of the same links: driven from behind."""
    base, shoulder, elbow, wrist, roll = joints.T
    base -= np.copysign(math.pi, base)
    np.subtract(np.copysign(math.pi, shoulder), shoulder, shoulder)
    np.negative(elbow, elbow)
    np.negative(wrist, wrist)
    roll += math.pi


def _wrist_of_pose(lengths: Lengths, goals: Array, rows: Stack) -> tuple[Array, Array]:
    """Return the wrist in the arm's plane, and put the tip in the stack's first row."""
    height, _, _, hand = lengths
    x, y, z, pitch, _ = goals.T
    wrist_r, wrist_z, spare = rows.other[0], rows.other[1], rows.spare[0]
    sine_cosine(pitch, wrist_z, wrist_r, spare)
    wrist_z *= -hand
    wrist_z += z
    wrist_z -= height
    wrist_r *= -hand
    rows.x[0], rows.y[0] = x, y
    fill_length(rows, 0, spare)
    wrist_r += rows.length[0]
    return wrist_r, wrist_z


def _triangle(lengths: Lengths, wrist_r: Array, wrist_z: Array, rows: Stack) -> tuple[Array, Array]:
    """Solve the elbow triangle by half angles; return along and across of the forearm's end.

    (a2 + a3)^2 - d^2 = 4 a2 a3 s^2 and d^2 - (a2 - a3)^2 = 4 a2 a3 c^2, with the sine s and the
    cosine c of half the bend; where no triangle closes, one of the two is the root of a negative
    number, and all that follows is NaN. A quarter of the bend has the tangent s / (1 + c).
    Leaves d^2, which is the length of the shoulder's point, in the stack's last length.
    """
    _, upper, fore, _ = lengths
    square, tangent = rows.length[-1], rows.tangent[-1]
    cosine, sine = rows.spare[0], rows.spare[1]
    np.multiply(wrist_r, wrist_r, square)
    np.multiply(wrist_z, wrist_z, sine)
    square += sine
    np.subtract((upper + fore) ** 2, square, sine)
    np.subtract(square, (upper - fore) ** 2, cosine)
    _touch(sine, 2.0 * (upper + fore) * REACH_MM)
    _touch(cosine, max(2.0 * abs(upper - fore), REACH_MM) * REACH_MM)
    both = rows.spare[:2]
    both *= 0.25 / (upper * fore)
    np.sqrt(both, both)
    np.add(cosine, 1.0, tangent)
    np.divide(sine, tangent, tangent)
    np.multiply(sine, cosine, rows.angle[0])
    np.multiply(both, both, both)
    cosine -= sine
    cosine *= fore
    cosine += upper
    np.multiply(rows.angle[0], 2.0 * fore, sine)
    return cosine, sine


def _touch(excess: Array, tolerance: float) -> None:
    """Bring what rounding has put a hair beyond full stretch or full fold back to it."""
    if np.fmin.reduce(excess, initial=0.0) < 0.0:
        excess[(excess < 0.0) & (excess >= -tolerance)] = 0.0


def _shoulder(
    wrist_r: Array,
    wrist_z: Array,
    along: Array,
    across: Array,
    rows: Stack,
    index: int,
    down: bool,
) -> None:
    """Put the upper arm's point in the stack: the wrist's, turned by the lift, up or down."""
    turn, turn_back = (np.subtract, np.add) if down else (np.add, np.subtract)
    x, y, spare = rows.x[index], rows.y[index], rows.angle[0]
    np.multiply(wrist_z, along, y)
    np.multiply(wrist_r, across, spare)
    turn(y, spare, y)
    np.multiply(wrist_r, along, x)
    np.multiply(wrist_z, across, spare)
    turn_back(x, spare, x)


def _both_shoulders(
    lengths: Lengths, wrist_r: Array, wrist_z: Array, rows: Stack, index: int
) -> None:
    along, across = _triangle(lengths, wrist_r, wrist_z, rows)
    np.copyto(rows.length[index], rows.length[-1])
    for down in (False, True):
        _shoulder(wrist_r, wrist_z, along, across, rows, index + down, down)


def _wrist(pitch: Array, angles: Array, rows: Stack) -> None:
    wrist, spare = rows.spare[0], rows.spare[1]
    np.subtract(pitch, angles[1], wrist)
    wrist -= angles[2]
    wrap(wrist, angles[3], spare)


def _four(pitch: Array, roll: Array, shoulders_and_bend: Array, rows: Stack, joints: Array) -> None:
    """Write the four postures of a block."""
    bend, hole = shoulders_and_bend[2], rows.tangent[0]
    np.multiply(bend, 0.0, hole)  # 0, or NaN where no triangle closes
    for index, quarter in ((0, -4.0), (1, 4.0)):
        angles = joints[:, index].T
        np.add(rows.angle[0], hole, angles[0])
        np.copyto(angles[1], shoulders_and_bend[index])
        np.multiply(bend, quarter, angles[2])
        _wrist(pitch, angles, rows)
        np.add(roll, hole, angles[4])
        np.copyto(joints[:, index + 2], joints[:, index])
        mirror(joints[:, index + 2])
