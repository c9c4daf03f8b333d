"""The closed form of the five-axis build on bare floats: forward, every branch, the nearest one.

Source: McKerrow, chapter 4, section 16 (the Mini-mover 5), with the elbow triangle generalised to
an upper arm and a forearm of any lengths. Lengths in mm, angles in rad. Arguments are not checked,
and only floats and tuples are created, because planners call these functions thousands of times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import acos, asin, atan2, cos, hypot, inf, pi, sin, sqrt
from typing import NamedTuple, Protocol

from kinematics.frames.transforms import Transform
from kinematics.geometry import AXIS_MM
from kinematics.limits import LIMIT_TOLERANCE_RAD, JointRange, fitted
from kinematics.spaces import Joints, Pose

REACH_MM = 1e-9
"""How far rounding may put a wrist beyond full stretch, or within full fold."""

Lengths = tuple[float, float, float, float]
"""Height of the shoulder axis, upper arm, forearm, hand."""

Angles = tuple[float, float, float, float, float]
"""Base, shoulder, elbow, wrist pitch, wrist roll."""


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
    goal: tuple[float, float, float, float, float], lengths: Lengths, seed: Angles
) -> list[tuple[bool, bool, Angles]]:
    """Return every branch as (base is back, elbow is down, angles); none if out of reach.

    The angles are of any turn. A tip on the base axis leaves the base free: it takes the seed's
    base and has only front branches, whose pitch is the convention on the axis.

    The back branches mirror the front ones in the base axis: the links are in the same place,
    driven from the other side.
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
    found: list[tuple[bool, bool, Angles]] = []
    for down, (shoulder, elbow) in zip((False, True), pair, strict=True):
        wrist = pitch - shoulder - elbow
        found.append((False, down, (base, shoulder, elbow, wrist, roll)))
        if not on_axis:
            mirrored = (base + math.pi, math.pi - shoulder, -elbow, -wrist, roll + math.pi)
            found.append((True, down, mirrored))
    return found


# The branch nearest to a seed within limits, written as one straight piece of code.
#
# Planners and jogging solve poses thousands of times, and in Python calls and containers are what
# costs time. So the elbow triangle, its mirror image behind the base axis, the turns of every angle
# and the comparison with the seed are written out here once. The functions above contain the same
# formulas separately.

Span = tuple[float, float]
"""The lowest and the highest of a range."""

_FOLDED_MM2 = REACH_MM * REACH_MM


class ArmBuild(NamedTuple):
    """What the choice of a branch needs of an arm, computed once.

    `square_sum` is a2^2 + a3^2 and `double_product` 2 a2 a3, of the cosine rule. A base or elbow
    angle within half a turn either way and outside its gate has no turn within its limits.
    """

    height: float
    upper: float
    fore: float
    hand: float
    square_sum: float
    double_product: float
    base_gate: Span
    elbow_gate: Span
    bounds: tuple[Span, Span, Span, Span, Span]


def build(lengths: Lengths, bounds: tuple[Span, ...]) -> ArmBuild:
    """Return the values that `nearest_posture` needs of an arm with these lengths and limits."""
    height, upper, fore, hand = lengths
    base, shoulder, elbow, wrist, roll = bounds
    return ArmBuild(
        height,
        upper,
        fore,
        hand,
        upper * upper + fore * fore,
        2.0 * upper * fore,
        _gate(*base),
        _gate(*elbow),
        (base, shoulder, elbow, wrist, roll),
    )


def solve_pose(
    goal: tuple[float, float, float, float, float], arm: ArmBuild, near: Angles
) -> Angles | None:
    """Return the posture within limits nearest to `near` for x, y, z, pitch and roll, or None."""
    x, y, z, pitch, roll = goal
    r = hypot(x, y)
    on_axis = r <= AXIS_MM
    base = near[0] if on_axis else atan2(y, x)
    return nearest_posture(
        base,
        r - arm.hand * cos(pitch),
        z - arm.height - arm.hand * sin(pitch),
        pitch,
        roll,
        not on_axis,
        arm,
        near,
    )


def nearest_posture(
    base: float,
    wrist_r: float,
    wrist_z: float,
    pitch: float,
    roll: float,
    mirrored_too: bool,
    arm: ArmBuild,
    near: Angles,
) -> Angles | None:
    """Return the posture within limits with the least sum of squared changes from `near`.

    The wrist is given in the arm's plane from the shoulder axis, and the base within half a turn
    either way. Returns None if the elbow triangle does not close or every branch violates a limit.
    With `mirrored_too`, the base turned by half a circle is tried as well.
    """
    _, upper, fore, _, square_sum, double_product, base_gate, elbow_gate, bounds = arm
    square = wrist_r * wrist_r + wrist_z * wrist_z
    cosine = (square - square_sum) / double_product
    if not -1.0 <= cosine <= 1.0:
        touching = elbow_cosine(square, upper, fore)
        if touching is None:
            return None
        cosine = touching
    bend = acos(cosine)
    if square <= _FOLDED_MM2:  # equal links, folded: the shoulder is free
        direction, lift = near[1], 0.0
    else:
        direction = atan2(wrist_z, wrist_r)
        lift = atan2(fore * sqrt((1.0 - cosine) * (1.0 + cosine)), upper + fore * cosine)
    (b_low, b_high), (s_low, s_high), (e_low, e_high), (w_low, w_high), (r_low, r_high) = bounds
    b_gate_low, b_gate_high = base_gate
    e_gate_low, e_gate_high = elbow_gate
    b_near, s_near, e_near, w_near, r_near = near
    best: Angles | None = None
    least = inf
    for back in (False, True) if mirrored_too else (False,):
        b, r = base, roll
        if back:
            b = b - pi if b > 0.0 else b + pi
            r += pi
        if not b_gate_low <= b <= b_gate_high:
            continue
        if not (b_low <= b <= b_high and -pi < b - b_near < pi):
            b = fitted(b, b_low, b_high, b_near)
        if not (r_low <= r <= r_high and -pi < r - r_near < pi):
            r = fitted(r, r_low, r_high, r_near)
        for e, s in ((-bend, direction + lift), (bend, direction - lift)):
            w = pitch - s - e
            if back:
                s, e, w = pi - s, -e, -w
            if not e_gate_low <= e <= e_gate_high:
                continue
            if not (e_low <= e <= e_high and -pi < e - e_near < pi):
                e = fitted(e, e_low, e_high, e_near)
            if not (s_low <= s <= s_high and -pi < s - s_near < pi):
                s = fitted(s, s_low, s_high, s_near)
            if not (w_low <= w <= w_high and -pi < w - w_near < pi):
                w = fitted(w, w_low, w_high, w_near)
            db, ds, de, dw, dr = b - b_near, s - s_near, e - e_near, w - w_near, r - r_near
            change = db * db + ds * ds + de * de + dw * dw + dr * dr
            if change < least:  # infinite, so never true, if a joint has no valid turn
                best, least = (b, s, e, w, r), change
    return best


def _gate(low: float, high: float) -> Span:
    """Return the gate of a range; no gate if a second turn of an angle may lie within the range."""
    low, high = low - LIMIT_TOLERANCE_RAD, high + LIMIT_TOLERANCE_RAD
    return (low, high) if -pi < low and high < pi else (-inf, inf)


# The hand as a full frame: forward to a 4x4, and the inverse of any 4x4 within the limits of five
# axes.
#
# Lengths in mm, angles in rad. Axes of the hand's frame: z along the hand (the approach), x up from
# the hand's back where the roll is zero, y to complete a right-handed frame: the last frame of the
# arm's link table (McKerrow, chapter 4, section 16), with alpha = 90, 0, 0, 90, 0 degrees.
#
# Five axes cannot turn the hand out of the vertical plane through the base axis and the tip, so
# most frames in space have no posture. The caller is told the angle by which the goal's approach
# leaves that plane; a general solver keeps it to itself.

UPRIGHT = 1e-9
"""A hand whose horizontal part is smaller than this is vertical, and lies in every plane."""

ON_MANIFOLD_RAD = 1e-6
"""A frame this near to one that five axes can give counts as reachable."""


class FrameAngles(NamedTuple):
    """The bare solver's result: the angles, or None, and how the goal's plane was found.

    `off_rad` is how far the approach leaves the arm's plane. `base_free` is true if the tip is on
    the base axis and the hand vertical, so that the seed's base was used.
    """

    angles: Angles | None
    off_rad: float
    base_free: bool
    goal: tuple[float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class FrameSolution:
    """How well an arm meets a goal given as a full frame.

    `pose` is the goal as far as five axes can give it: the position kept, and the approach turned
    by `off_manifold_rad` into the arm's plane. `joints` is the posture within the limits nearest to
    the seed that holds it, or None if there is none (`FiveAxisArm.ik` of `pose` says why).
    """

    joints: Joints | None
    pose: Pose
    off_manifold_rad: float
    base_free: bool

    @property
    def on_manifold(self) -> bool:
        """Whether five axes can give the goal's direction at that place."""
        return self.off_manifold_rad <= ON_MANIFOLD_RAD

    @property
    def met(self) -> bool:
        """Whether the posture meets the whole goal: position, direction and roll."""
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

    Arguments are not checked: `goal` must be a transform of finite numbers. A goal off the manifold
    is replaced by the nearest frame on it with the same position.
    """
    (ux, vx, hx, x), (uy, vy, hy, y), (uz, vz, hz, z), _ = goal
    r = hypot(x, y)
    base_free = False
    if r > AXIS_MM:
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
    """Return the bare solver's result in the types of the three spaces."""
    x, y, z, pitch, roll = found.goal
    return FrameSolution(
        None if found.angles is None else Joints(found.angles),
        Pose(x, y, z, pitch, roll),
        found.off_rad,
        found.base_free,
    )
