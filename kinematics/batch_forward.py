"""Forward kinematics of blocks of postures with numpy: poses, and the hand's frames.

Lengths in mm, angles in rad. Rows of `row` are spare arrays as long as the block; see `batch`.
"""

from __future__ import annotations

import math

import numpy as np

from kinematics.batch_trig import Array, sine_cosine, wrap
from kinematics.closed_form import AXIS_MM, Lengths

POSE_ROWS = 7
FRAME_ROWS = 14
"""How many spare arrays a block needs."""


def fill_poses(lengths: Lengths, angles: Array, poses: Array, row: Array) -> None:
    """Fill the poses of a block, described as `closed_form.forward` does, angles wrapped."""
    height, upper, fore, hand = lengths
    base, shoulder, elbow, wrist, roll = angles.T
    sine, cosine, spare, r, z, link, total = row
    r[:], z[:] = 0.0, height
    link[:] = 0.0
    for length, joint in ((upper, shoulder), (fore, elbow), (hand, wrist)):
        link += joint
        sine_cosine(link, sine, cosine, spare)
        cosine *= length
        sine *= length
        r += cosine
        z += sine
    poses[:, 2] = z
    sine_cosine(base, sine, cosine, spare)
    np.multiply(cosine, r, poses[:, 0])
    np.multiply(sine, r, poses[:, 1])
    np.copyto(total, roll)
    behind = np.flatnonzero(r < -AXIS_MM)
    if len(behind):
        link[behind] = math.pi - link[behind]
        total[behind] += math.pi
    wrap(link, poses[:, 3], spare)
    wrap(total, poses[:, 4], spare)


def fill_frames(lengths: Lengths, angles: Array, frames: Array, row: Array) -> None:
    """Fill the frames of a block: the columns u, v, h and the tip of `forward_frame`."""
    height, upper, fore, hand = lengths
    base, shoulder, elbow, wrist, roll = angles.T
    spare, r, z, link, up_r, side_r, a, b = row[:8]
    cos_base, sin_base, cos_pitch, sin_pitch, cos_roll, sin_roll = row[8:14]
    np.copyto(link, shoulder)
    sine_cosine(link, z, r, spare)
    r *= upper
    z *= upper
    z += height
    link += elbow
    sine_cosine(link, b, a, spare)
    a *= fore
    b *= fore
    r += a
    z += b
    link += wrist
    sine_cosine(link, sin_pitch, cos_pitch, spare)
    np.multiply(cos_pitch, hand, a)
    np.multiply(sin_pitch, hand, b)
    r += a
    z += b
    sine_cosine(base, sin_base, cos_base, spare)
    sine_cosine(roll, sin_roll, cos_roll, spare)
    np.multiply(sin_pitch, cos_roll, up_r)
    np.multiply(sin_pitch, sin_roll, side_r)
    _level_row(frames[:, 0], cos_base, sin_base, row)
    np.negative(cos_base, a)
    _level_row(frames[:, 1], sin_base, a, row)
    np.multiply(cos_pitch, cos_roll, frames[:, 2, 0])
    np.multiply(cos_pitch, sin_roll, a)
    np.negative(a, frames[:, 2, 1])
    frames[:, 2, 2] = sin_pitch
    frames[:, 2, 3] = z
    frames[:, 3] = (0.0, 0.0, 0.0, 1.0)


def _level_row(out: Array, outwards: Array, sideways: Array, row: Array) -> None:
    """Fill the x or the y row of the frames: the two differ by a quarter turn of the base."""
    spare, r, _, link, up_r, side_r = row[:6]
    cos_pitch, cos_roll, sin_roll = row[10], row[12], row[13]
    np.multiply(sideways, sin_roll, spare)
    np.multiply(outwards, up_r, link)
    np.subtract(spare, link, out[:, 0])
    np.multiply(sideways, cos_roll, spare)
    np.multiply(outwards, side_r, link)
    np.add(spare, link, out[:, 1])
    np.multiply(outwards, cos_pitch, out[:, 2])
    np.multiply(outwards, r, out[:, 3])
