"""Where the wrist must be for a block of hand frames, and how far the frames are off.

Lengths in mm, angles in rad. Meaning and names are those of `hand_frame.solve_frame`.
"""

from __future__ import annotations

import numpy as np

from kinematics.batch_stack import Stack, fill_length
from kinematics.batch_trig import Array
from kinematics.closed_form import Lengths
from kinematics.hand_frame import NEAR_AXIS_MM, ON_MANIFOLD_RAD, UPRIGHT


def wrist_of_frame(lengths: Lengths, goals: Array, off: Array, rows: Stack) -> tuple[Array, Array]:
    """Return the wrist in the arm's plane; put base, roll and pitch in the stack, and the rest."""
    height, _, _, hand = lengths
    (ux, _, hx, x), (uy, _, hy, y), (uz, _, hz, z), _ = goals.transpose(1, 2, 0)
    wrist_r, wrist_z, r, up = rows.other[0], rows.other[1], rows.spare[0], rows.spare[1]
    (sin_base, side, rise), (cos_base, back, level) = rows.y[:3], rows.x[:3]
    np.multiply(x, x, r)
    np.multiply(y, y, up)
    r += up
    np.sqrt(r, r)
    np.divide(x, r, cos_base)
    np.divide(y, r, sin_base)
    _take_plane_from_hand(goals, r, cos_base, sin_base)
    rows.length[0] = 1.0
    np.multiply(hx, cos_base, level)
    np.multiply(hy, sin_base, up)
    level += up
    np.multiply(hx, sin_base, up)
    np.multiply(hy, cos_base, side)
    up -= side
    _angle_of_sine(up, off)
    r[off > ON_MANIFOLD_RAD] = np.nan
    np.multiply(ux, cos_base, up)
    np.multiply(uy, sin_base, wrist_r)
    up += wrist_r
    up *= hz
    np.multiply(uz, level, back)
    back -= up
    np.multiply(ux, sin_base, side)
    np.multiply(uy, cos_base, up)
    side -= up
    np.copyto(rise, hz)
    fill_length(rows, 1, up)
    fill_length(rows, 2, up)
    np.multiply(level, -hand, wrist_r)
    wrist_r += r
    np.multiply(hz, -hand, wrist_z)
    wrist_z += z
    wrist_z -= height
    return wrist_r, wrist_z


def _take_plane_from_hand(goals: Array, r: Array, cos_base: Array, sin_base: Array) -> None:
    """Put the hand's direction for the tip's where the tip is on the base axis."""
    on_axis = np.flatnonzero(r <= NEAR_AXIS_MM)
    if len(on_axis) == 0:
        return
    hx, hy = goals[on_axis, 0, 2], goals[on_axis, 1, 2]
    level = np.hypot(hx, hy)
    upright = level <= UPRIGHT
    level[upright] = 1.0
    cos_base[on_axis] = np.where(upright, 1.0, hx / level)
    sin_base[on_axis] = np.where(upright, 0.0, hy / level)
    r[on_axis] = goals[on_axis, 0, 3] * cos_base[on_axis] + goals[on_axis, 1, 3] * sin_base[on_axis]


def _angle_of_sine(sine: Array, out: Array) -> None:
    """Fill `out` with the size of the angle; below 1e-6 it is the sine itself, to 1e-19."""
    np.abs(sine, out)
    large = np.flatnonzero(out > ON_MANIFOLD_RAD)
    if len(large):
        out[large] = np.arcsin(np.minimum(out[large], 1.0))
