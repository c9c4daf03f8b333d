"""Many poses at once with numpy: the five-axis closed form, one branch or all four, and forward.

Lengths in mm, angles in rad, arrays of shape (N, 5), (N, 4, 5) and (N, 4, 4). What cannot be met
is never answered with a number: its row is NaN (the root of a negative number, without a
warning). Work is done in blocks that stay in the processor's cache, with the sines and arc
tangents of `batch_trig`. Inputs may have any memory layout; results are stored by columns, which
is what the next computation reads fastest.

Source: McKerrow, chapter 4, section 16, as `closed_form` writes it for one pose.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from kinematics import batch_forward as forward
from kinematics import batch_inverse as inverse
from kinematics.batch_stack import rows_needed
from kinematics.batch_trig import Array
from kinematics.errors import KinematicsError
from kinematics.five_axis import Base, Elbow, FiveAxisArm
from kinematics.limits import LIMIT_TOLERANCE_RAD

BLOCK = 12288
"""Poses in a block: as few as keep a call's own cost small, as many as the caches hold."""

BRANCHES = tuple((base, elbow) for base in Base for elbow in (Elbow.UP, Elbow.DOWN))
"""Order of the branches in (N, 4, 5): front up, front down, back up, back down."""


class FrameBranches(NamedTuple):
    """All branches of goals given as frames: joints (N, 4, 5), and how far each goal is off.

    Rows are NaN where the goal is out of reach, or where its approach leaves the arm's plane by
    more than `ON_MANIFOLD_RAD`; `off_manifold_rad` (N,) says by how much.
    """

    joints: Array
    off_manifold_rad: Array


@np.errstate(all="ignore")
def inverse_many(
    arm: FiveAxisArm,
    poses: npt.ArrayLike,
    base: Base = Base.FRONT,
    elbow: Elbow = Elbow.UP,
    out: Array | None = None,
) -> Array:
    """Return one branch of each pose (x, y, z, pitch, roll): joint angles (N, 5), or NaN.

    Limits are not looked at (see `within_limits`); every angle but the roll is within half a
    turn either way, and a tip on the base axis takes some base, since any will do. Without
    `out`, which must not overlap the poses, the result is a new array.
    """
    goals = _rows(poses, (5,))
    joints = _by_columns(len(goals), 5) if out is None else _result(out, (len(goals), 5))
    for part, row in _blocks(len(goals), rows_needed(2)):
        inverse.fill_one_branch(arm.lengths, goals[part], joints[part], row, elbow is Elbow.DOWN)
        if base is Base.BACK:
            inverse.mirror(joints[part])
    return joints


@np.errstate(all="ignore")
def branches_many(arm: FiveAxisArm, poses: npt.ArrayLike, out: Array | None = None) -> Array:
    """Return all branches of each pose in the order of `BRANCHES`: (N, 4, 5), NaN out of reach."""
    goals = _rows(poses, (5,))
    joints = _by_columns(len(goals), 4, 5) if out is None else _result(out, (len(goals), 4, 5))
    for part, row in _blocks(len(goals), rows_needed(3)):
        inverse.fill_branches_of_poses(arm.lengths, goals[part], joints[part], row)
    return joints


@np.errstate(all="ignore")
def branches_of_frames(
    arm: FiveAxisArm, frames: npt.ArrayLike, out: Array | None = None
) -> FrameBranches:
    """Return all branches of each hand frame (N, 4, 4), and how far it is off the manifold.

    The frames' axes are those of `hand_frame`; their rotations are taken for rotations.
    """
    goals = _rows(frames, (4, 4))
    joints = _by_columns(len(goals), 4, 5) if out is None else _result(out, (len(goals), 4, 5))
    off = np.empty(len(goals))
    for part, row in _blocks(len(goals), rows_needed(5)):
        inverse.fill_branches_of_frames(arm.lengths, goals[part], joints[part], off[part], row)
    return FrameBranches(joints, off)


@np.errstate(all="ignore")
def forward_many(arm: FiveAxisArm, joints: npt.ArrayLike, out: Array | None = None) -> Array:
    """Return the pose of each posture: (N, 5), described as `FiveAxisArm.fk` does."""
    angles = _rows(joints, (5,))
    poses = _by_columns(len(angles), 5) if out is None else _result(out, (len(angles), 5))
    for part, row in _blocks(len(angles), forward.POSE_ROWS):
        forward.fill_poses(arm.lengths, angles[part], poses[part], row)
    return poses


@np.errstate(all="ignore")
def frames_many(arm: FiveAxisArm, joints: npt.ArrayLike, out: Array | None = None) -> Array:
    """Return the hand's frame of each posture: (N, 4, 4), each matrix in one piece of memory."""
    angles = _rows(joints, (5,))
    shape = len(angles), 4, 4
    frames = np.empty(shape) if out is None else _result(out, shape)
    for part, row in _blocks(len(angles), forward.FRAME_ROWS):
        forward.fill_frames(arm.lengths, angles[part], frames[part], row)
    return frames


def within_limits(arm: FiveAxisArm, joints: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Tell which postures (..., 5) have a turn of every angle within its limits; NaN has none."""
    angles = np.asarray(joints, dtype=np.float64)
    inside = np.ones(angles.shape[:-1], dtype=np.bool_)
    for index, bounds in enumerate(arm.limits):
        middle = (bounds.low_rad + bounds.high_rad) / 2.0
        reach = (bounds.high_rad - bounds.low_rad) / 2.0 + LIMIT_TOLERANCE_RAD
        turn = angles[..., index] - middle
        inside &= np.abs(turn - np.rint(turn / math.tau) * math.tau) <= reach
    return inside


def _rows(values: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    rows = np.asarray(values, dtype=np.float64)
    if rows.shape[1:] != shape:
        wanted = ", ".join(str(size) for size in shape)
        raise KinematicsError(f"an array of shape (N, {wanted}) is needed, not {rows.shape}")
    return rows


def _result(out: Array, shape: tuple[int, ...]) -> Array:
    if out.shape != shape or out.dtype != np.float64:
        raise KinematicsError(
            f"`out` must be an array of 64-bit floats of shape {shape}, "
            f"not of {out.dtype} of shape {out.shape}"
        )
    return out


def _by_columns(count: int, *shape: int) -> Array:
    """Return an empty (N, ...) array in which every column is one piece of memory."""
    return np.moveaxis(np.empty((*shape, count)), -1, 0)


def _blocks(count: int, spares: int) -> Iterator[tuple[slice, Array]]:
    """Yield the parts of an array and as many spare rows of their length."""
    room = np.empty((spares, min(BLOCK, count)))
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        yield slice(start, stop), room[:, : stop - start]
