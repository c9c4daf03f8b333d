"""Many poses at once with numpy: the five-axis closed form, one branch or all four, and forward.

Lengths in mm, angles in rad, arrays of shape (N, 5), (N, 4, 5) and (N, 4, 4). What cannot be met is
never answered with a number: its row is NaN (the root of a negative number, without a warning).
Work is done in blocks whose intermediate arrays stay in the processor's cache. Inputs may have any
memory layout; results are stored by columns, which is what the next computation reads fastest.

Source: McKerrow, chapter 4, section 16, as `closed_form` writes it for one pose.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from kinematics.errors import KinematicsError
from kinematics.five_axis.arm import Base, Elbow, FiveAxisArm
from kinematics.five_axis.closed_form import (
    ON_MANIFOLD_RAD,
    REACH_MM,
    UPRIGHT,
    Lengths,
)
from kinematics.geometry import AXIS_MM
from kinematics.limits import LIMIT_TOLERANCE_RAD

Array: TypeAlias = npt.NDArray[np.float64]

BLOCK = 8192
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
    joints = _result(out, len(goals), 5)
    for part in _blocks(len(goals)):
        _HandGoals.of_poses(arm.lengths, goals[part]).fill(joints[part], elbow)
        if base is Base.BACK:
            _mirror(joints[part])
    return joints


@np.errstate(all="ignore")
def branches_many(arm: FiveAxisArm, poses: npt.ArrayLike, out: Array | None = None) -> Array:
    """Return all branches of each pose in the order of `BRANCHES`: (N, 4, 5), NaN out of reach."""
    goals = _rows(poses, (5,))
    joints = _result(out, len(goals), 4, 5)
    for part in _blocks(len(goals)):
        _HandGoals.of_poses(arm.lengths, goals[part]).fill_all(joints[part])
    return joints


@np.errstate(all="ignore")
def branches_of_frames(
    arm: FiveAxisArm, frames: npt.ArrayLike, out: Array | None = None
) -> FrameBranches:
    """Return all branches of each hand frame (N, 4, 4), and how far it is off the manifold.

    The axes are those of `closed_form.forward_frame`; the rotations are taken for rotations.
    """
    goals = _rows(frames, (4, 4))
    joints = _result(out, len(goals), 4, 5)
    off = np.empty(len(goals))
    for part in _blocks(len(goals)):
        hands, off[part] = _hands_of_frames(arm.lengths, goals[part])
        hands.fill_all(joints[part])
    return FrameBranches(joints, off)


@np.errstate(all="ignore")
def forward_many(arm: FiveAxisArm, joints: npt.ArrayLike, out: Array | None = None) -> Array:
    """Return the pose of each posture: (N, 5), described as `FiveAxisArm.fk` does."""
    angles = _rows(joints, (5,))
    poses = _result(out, len(angles), 5)
    for part in _blocks(len(angles)):
        base, _, _, _, roll = angles[part].T
        r, z, pitch = _plane_tip(arm.lengths, angles[part])
        behind = r < -AXIS_MM
        x_mm, y_mm, z_mm, pitch_rad, roll_rad = poses[part].T
        np.multiply(np.cos(base), r, x_mm)
        np.multiply(np.sin(base), r, y_mm)
        z_mm[:] = z
        pitch_rad[:] = _wrapped(np.where(behind, math.pi - pitch, pitch))
        roll_rad[:] = _wrapped(np.where(behind, roll + math.pi, roll))
    return poses


@np.errstate(all="ignore")
def frames_many(arm: FiveAxisArm, joints: npt.ArrayLike, out: Array | None = None) -> Array:
    """Return the hand's frame of each posture: (N, 4, 4), each matrix in one piece of memory."""
    angles = _rows(joints, (5,))
    shape = len(angles), 4, 4
    frames = np.empty(shape) if out is None else _result(out, *shape)
    for part in _blocks(len(angles)):
        base, _, _, _, roll = angles[part].T
        r, z, pitch = _plane_tip(arm.lengths, angles[part])
        cos_base, sin_base = np.cos(base), np.sin(base)
        cos_pitch, sin_pitch = np.cos(pitch), np.sin(pitch)
        cos_roll, sin_roll = np.cos(roll), np.sin(roll)
        up_r, side_r = sin_pitch * cos_roll, sin_pitch * sin_roll
        rows = (
            (sin_base * sin_roll - cos_base * up_r, sin_base * cos_roll + cos_base * side_r),
            (-cos_base * sin_roll - sin_base * up_r, sin_base * side_r - cos_base * cos_roll),
            (cos_pitch * cos_roll, -cos_pitch * sin_roll),
        )
        directions = (cos_base * cos_pitch, cos_base * r), (sin_base * cos_pitch, sin_base * r)
        filled = frames[part]
        for row, entries in enumerate(zip(rows, (*directions, (sin_pitch, z)), strict=True)):
            for column, entry in enumerate((*entries[0], *entries[1])):
                filled[:, row, column] = entry
        filled[:, 3] = (0.0, 0.0, 0.0, 1.0)
    return frames


def within_limits(arm: FiveAxisArm, joints: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Tell which postures (..., 5) have a turn of every angle within its limits; NaN has none."""
    angles = np.asarray(joints, dtype=np.float64)
    inside = np.ones(angles.shape[:-1], dtype=np.bool_)
    for index, bounds in enumerate(arm.limits):
        middle = (bounds.low_rad + bounds.high_rad) / 2.0
        reach = (bounds.high_rad - bounds.low_rad) / 2.0 + LIMIT_TOLERANCE_RAD
        inside &= np.abs(_wrapped(angles[..., index] - middle)) <= reach
    return inside


class _HandGoals:
    """What a block of goals asks in the arm's own plane, and the elbow triangle that gives it.

    (a2 + a3)^2 - d^2 = 4 a2 a3 s^2 and d^2 - (a2 - a3)^2 = 4 a2 a3 c^2, with the wrist's distance
    d from the shoulder and the sine s and cosine c of half the bend. Where no triangle closes, one
    of the two is the root of a negative number, and all that follows is NaN.
    """

    def __init__(
        self,
        lengths: Lengths,
        base: Array,
        wrist: tuple[Array, Array],
        pitch: Array,
        roll: Array,
    ) -> None:
        _, upper, fore, _ = lengths
        r, z = self._wrist = wrist
        square = r * r + z * z
        sine = _root((upper + fore) ** 2 - square, 2.0 * (upper + fore) * REACH_MM)
        cosine = _root(
            square - (upper - fore) ** 2, max(2.0 * abs(upper - fore), REACH_MM) * REACH_MM
        )
        share = 0.5 / math.sqrt(upper * fore)
        sine *= share
        cosine *= share
        self._bend = 2.0 * np.arctan2(sine, cosine)
        self._along = upper + fore * (cosine * cosine - sine * sine)
        self._across = 2.0 * fore * sine * cosine
        hole = self._bend * 0.0  # 0, or NaN where no triangle closes
        self._base, self._pitch, self._roll = base + hole, pitch, roll + hole

    @classmethod
    def of_poses(cls, lengths: Lengths, goals: Array) -> _HandGoals:
        """Go back along the hand from the tips of poses."""
        height, _, _, hand = lengths
        x, y, z, pitch, roll = goals.T
        wrist_r = np.sqrt(x * x + y * y) - hand * np.cos(pitch)
        wrist_z = z - height - hand * np.sin(pitch)
        return cls(lengths, np.arctan2(y, x), (wrist_r, wrist_z), pitch, roll)

    def fill(self, joints: Array, elbow: Elbow) -> None:
        """Fill the posture of one front branch: the wrist's direction turned by the lift."""
        (r, z), along = self._wrist, self._along
        across, bend = self._across, -self._bend
        if elbow is Elbow.DOWN:
            across, bend = -across, -bend
        angles = joints.T
        angles[0] = self._base
        angles[1] = np.arctan2(z * along + r * across, r * along - z * across)
        angles[2] = bend
        angles[3] = _wrapped(self._pitch - angles[1] - bend)
        angles[4] = self._roll

    def fill_all(self, joints: Array) -> None:
        """Fill the four postures (N, 4, 5) in the order of `BRANCHES`."""
        for index, elbow in enumerate((Elbow.UP, Elbow.DOWN)):
            self.fill(joints[:, index], elbow)
            joints[:, index + 2] = joints[:, index]
            _mirror(joints[:, index + 2])


def _hands_of_frames(lengths: Lengths, goals: Array) -> tuple[_HandGoals, Array]:
    """Return what frames ask, and how far each approach leaves the arm's plane."""
    height, _, _, hand = lengths
    (ux, _, hx, x), (uy, _, hy, y), (uz, _, hz, z), _ = goals.transpose(1, 2, 0)
    out_x, out_y = x, y
    on_axis = np.hypot(x, y) <= AXIS_MM
    if on_axis.any():  # the tip tells no plane there: the hand's direction does, if it has one
        upright = np.hypot(hx, hy) <= UPRIGHT
        out_x = np.where(on_axis, np.where(upright, 1.0, hx), x)
        out_y = np.where(on_axis, np.where(upright, 0.0, hy), y)
    distance = np.hypot(out_x, out_y)
    cosine, sine = out_x / distance, out_y / distance
    off = np.arcsin(np.minimum(np.abs(hx * sine - hy * cosine), 1.0))
    level, up = hx * cosine + hy * sine, ux * cosine + uy * sine
    wrist_r = x * cosine + y * sine - hand * level
    wrist_r[off > ON_MANIFOLD_RAD] = np.nan
    found = _HandGoals(
        lengths,
        np.arctan2(out_y, out_x),
        (wrist_r, z - height - hand * hz),
        np.arctan2(hz, level),
        np.arctan2(ux * sine - uy * cosine, uz * level - hz * up),
    )
    return found, off


def _plane_tip(lengths: Lengths, angles: Array) -> tuple[Array, Array, Array]:
    """Return the tip outwards and upwards in the arm's plane and the pitch: `plane_tip` of many."""
    height, *links = lengths
    elevation = np.zeros(len(angles))
    r, z = np.zeros(len(angles)), np.full(len(angles), height)
    for length, joint in zip(links, angles.T[1:4], strict=True):
        elevation = elevation + joint
        r += length * np.cos(elevation)
        z += length * np.sin(elevation)
    return r, z, elevation


def _mirror(joints: Array) -> None:
    """Turn front branches into the back branches of the same links: driven from behind."""
    base, shoulder, elbow, wrist, roll = joints.T
    base -= np.copysign(math.pi, base)
    np.subtract(np.copysign(math.pi, shoulder), shoulder, shoulder)
    np.negative(elbow, elbow)
    np.negative(wrist, wrist)
    roll += math.pi


def _root(square: Array, tolerance: float) -> Array:
    """Return square roots, of 0 where rounding has put full stretch or fold a hair beyond."""
    square[(square < 0.0) & (square >= -tolerance)] = 0.0
    return np.sqrt(square, square)


def _wrapped(angle: Array) -> Array:
    """Return the turn of each angle within half a circle either way."""
    return angle - np.rint(angle * (1.0 / math.tau)) * math.tau


def _rows(values: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    rows = np.asarray(values, dtype=np.float64)
    if rows.shape[1:] != shape:
        wanted = ", ".join(str(size) for size in shape)
        raise KinematicsError(f"an array of shape (N, {wanted}) is needed, not {rows.shape}")
    return rows


def _result(out: Array | None, count: int, *shape: int) -> Array:
    """Return the caller's array, checked, or a new one with every column in one piece of memory."""
    if out is None:
        return np.moveaxis(np.empty((*shape, count)), -1, 0)
    if out.shape != (count, *shape) or out.dtype != np.float64:
        raise KinematicsError(
            f"`out` must be an array of 64-bit floats of shape {(count, *shape)}, "
            f"not of {out.dtype} of shape {out.shape}"
        )
    return out


def _blocks(count: int) -> Iterator[slice]:
    for start in range(0, count, BLOCK):
        yield slice(start, min(start + BLOCK, count))
