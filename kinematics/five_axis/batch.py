"""Many poses at once with numpy: the five-axis closed form, one branch or all four, and forward.

Lengths in mm, angles in rad, arrays of shape (N, 5), (N, 4, 5) and (N, 4, 4). What cannot be met is
never answered with a number: its row is NaN (the root of a negative number, without a warning).
Work is done in blocks that stay in the processor's cache, in rows of spare arrays as long as the
block. Inputs may have any memory layout; results are stored by columns, which is what the next
computation reads fastest.

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
from kinematics.five_axis.closed_form import AXIS_MM, REACH_MM, Lengths
from kinematics.five_axis.frame import NEAR_AXIS_MM, ON_MANIFOLD_RAD, UPRIGHT
from kinematics.limits import LIMIT_TOLERANCE_RAD

# Sine, cosine and arc tangent of whole arrays, from products and quotients alone.
#
# The C library's sines and arc tangents work on one number at a time on many processors (20 to 40
# ns each), while numpy's products work on several. Both functions here are therefore quotients of
# two polynomials, in Horner's form and in place. They are exact to a few units in the last place;
# the coefficients minimise the largest relative error (Remez in the Lawson form, computed with 60
# digits).

Array: TypeAlias = npt.NDArray[np.float64]

_TINY = 1e-300
"""Keeps a quotient of two zeros from being no number, and changes no other."""

_ARCTAN_OVER = (
    1.0,
    2.2765284166557884,
    1.8190722532173773,
    0.6064657316624958,
    0.07732920279856478,
    0.0025207285084859793,
)
_ARCTAN_UNDER = (
    1.0,
    2.6098617499890664,
    2.4890261698840708,
    1.0570259143877427,
    0.19359222332525175,
    0.012145895204678984,
    0.0001125665346465461,
)
"""atan(t) = t * over(t^2) / under(t^2) for t from -1 to 1, with a relative error of 3e-16."""

_TAN_OVER = (1.0, -0.12828349603647296, 0.0028059210960441204, -7.483662590665358e-06)
_TAN_UNDER = (1.0, -0.46161682936980347, 0.023344864219242256, -0.00020844845398152633)
"""tan(a) = a * over(a^2) / under(a^2) for a up to 45 degrees, with a relative error of 2e-17."""

_QUARTER_OVER = tuple(0.25 * c / 16.0**k for k, c in enumerate(_TAN_OVER))
_QUARTER_UNDER = tuple(c / 16.0**k for k, c in enumerate(_TAN_UNDER))
"""The same for the tangent of a quarter of the angle, so that the angle may be half a turn."""


def sine_cosine(angle: Array, sine: Array, cosine: Array, spare: Array) -> None:
    """Fill `sine` and `cosine` from angles of any turn; `spare` is overwritten.

    From the tangent t of the quarter angle: the sine of the half angle is 2t / (1 + t^2), its
    cosine (1 - t^2) / (1 + t^2), and both are doubled once more.
    """
    wrap(angle, spare, sine)
    np.multiply(spare, spare, sine)
    _polynomial(sine, _QUARTER_OVER, cosine)
    spare *= cosine
    _polynomial(sine, _QUARTER_UNDER, cosine)
    spare /= cosine
    np.multiply(spare, spare, sine)
    sine += 1.0
    np.divide(2.0, sine, cosine)
    np.multiply(spare, cosine, sine)  # of the half angle
    cosine -= 1.0
    np.multiply(sine, sine, spare)
    sine *= cosine
    sine *= 2.0
    np.multiply(spare, -2.0, cosine)
    cosine += 1.0


def arc_tangent(tangent: Array, out: Array, spare: Array, other: Array) -> None:
    """Fill `out` with the arc tangent of what lies between -1 and 1; the spares are overwritten."""
    np.multiply(tangent, tangent, spare)
    _polynomial(spare, _ARCTAN_OVER, out)
    _polynomial(spare, _ARCTAN_UNDER, other)
    out /= other
    out *= tangent


def directions(y: Array, x: Array, length: Array, tangents: Array) -> None:
    """Fill `tangents` with those of the half angles of (x, y), whose lengths are known.

    That is y / (length + x); to the left of the y axis the mirror image is taken, whose
    denominator does not cancel, and `mirror_back` undoes it. A point without direction has 0.
    """
    np.abs(x, tangents)
    tangents += length
    tangents += _TINY
    np.divide(y, tangents, tangents)


def mirror_back(angles: Array, y: Array, x: Array) -> None:
    """Turn half angles of `directions` into the directions of (x, y); `x` is overwritten."""
    np.copysign(2.0, x, x)
    angles *= x
    np.subtract(2.0, x, x)
    x *= math.pi / 4.0
    np.copysign(x, y, x)
    angles += x


def wrap(angle: Array, out: Array, spare: Array) -> None:
    """Fill `out` with the turn of each angle within half a circle either way."""
    np.multiply(angle, 1.0 / math.tau, spare)
    np.rint(spare, spare)
    spare *= math.tau
    np.subtract(angle, spare, out)


def _polynomial(x: Array, coefficients: tuple[float, ...], out: Array) -> None:
    np.multiply(x, coefficients[-1], out)
    for coefficient in coefficients[-2:0:-1]:
        out += coefficient
        out *= x
    out += coefficients[0]


# Forward kinematics of blocks of postures: poses, and the hand's frames.

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


# A stack of points whose directions are wanted all at once, for a block of goals.
#
# Every angle of the arm's closed form but one is the direction of a point whose distance is known;
# the one is the elbow's bend. All their arc tangents are taken on stacked rows together: that is
# fewer calls, and calls are what a block costs.


class Stack(NamedTuple):
    """Spare arrays of a block: the points whose directions are wanted, and room to find them.

    `y`, `x` and `length` have a row for each direction, the other four one more, for the bend.
    """

    y: Array
    x: Array
    length: Array
    tangent: Array
    angle: Array
    spare: Array
    other: Array


def rows_needed(count: int) -> int:
    """Return how many spare rows a stack of so many directions takes."""
    return 7 * count + 4


def stack(row: Array, count: int) -> Stack:
    """Cut spare rows into a stack of so many directions."""
    cuts = [index * count for index in range(3)]
    more = [3 * count + index * (count + 1) for index in range(4)]
    parts = [row[cut : cut + count] for cut in cuts]
    wide = [row[cut : cut + count + 1] for cut in more]
    return Stack(parts[0], parts[1], parts[2], wide[0], wide[1], wide[2], wide[3])


def fill_length(rows: Stack, index: int, spare: Array) -> None:
    """Fill the length of one of the stack's points."""
    length = rows.length[index]
    np.multiply(rows.x[index], rows.x[index], length)
    np.multiply(rows.y[index], rows.y[index], spare)
    length += spare
    np.sqrt(length, length)


def solve(rows: Stack, angles: Array) -> None:
    """Fill the angles: the stack's directions, and a quarter of the bend."""
    directions(rows.y, rows.x, rows.length, rows.tangent[:-1])
    arc_tangent(rows.tangent, angles, rows.spare, rows.other)
    mirror_back(angles[:-1], rows.y, rows.x)


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
        fill_one_branch(arm.lengths, goals[part], joints[part], row, elbow is Elbow.DOWN)
        if base is Base.BACK:
            mirror(joints[part])
    return joints


@np.errstate(all="ignore")
def branches_many(arm: FiveAxisArm, poses: npt.ArrayLike, out: Array | None = None) -> Array:
    """Return all branches of each pose in the order of `BRANCHES`: (N, 4, 5), NaN out of reach."""
    goals = _rows(poses, (5,))
    joints = _by_columns(len(goals), 4, 5) if out is None else _result(out, (len(goals), 4, 5))
    for part, row in _blocks(len(goals), rows_needed(3)):
        fill_branches_of_poses(arm.lengths, goals[part], joints[part], row)
    return joints


@np.errstate(all="ignore")
def branches_of_frames(
    arm: FiveAxisArm, frames: npt.ArrayLike, out: Array | None = None
) -> FrameBranches:
    """Return all branches of each hand frame (N, 4, 4), and how far it is off the manifold.

    The frames' axes are those of `five_axis.frame`; their rotations are taken for rotations.
    """
    goals = _rows(frames, (4, 4))
    joints = _by_columns(len(goals), 4, 5) if out is None else _result(out, (len(goals), 4, 5))
    off = np.empty(len(goals))
    for part, row in _blocks(len(goals), rows_needed(5)):
        fill_branches_of_frames(arm.lengths, goals[part], joints[part], off[part], row)
    return FrameBranches(joints, off)


@np.errstate(all="ignore")
def forward_many(arm: FiveAxisArm, joints: npt.ArrayLike, out: Array | None = None) -> Array:
    """Return the pose of each posture: (N, 5), described as `FiveAxisArm.fk` does."""
    angles = _rows(joints, (5,))
    poses = _by_columns(len(angles), 5) if out is None else _result(out, (len(angles), 5))
    for part, row in _blocks(len(angles), POSE_ROWS):
        fill_poses(arm.lengths, angles[part], poses[part], row)
    return poses


@np.errstate(all="ignore")
def frames_many(arm: FiveAxisArm, joints: npt.ArrayLike, out: Array | None = None) -> Array:
    """Return the hand's frame of each posture: (N, 4, 4), each matrix in one piece of memory."""
    angles = _rows(joints, (5,))
    shape = len(angles), 4, 4
    frames = np.empty(shape) if out is None else _result(out, shape)
    for part, row in _blocks(len(angles), FRAME_ROWS):
        fill_frames(arm.lengths, angles[part], frames[part], row)
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


# Where the wrist must be for a block of hand frames, and how far the frames are off:
# `frame.solve_frame` for many.


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


# Inverse kinematics of blocks of goals: one branch of each, or all four. Each function finds the
# points whose directions are the angles, puts them in a stack, and has all of them solved at once.


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
