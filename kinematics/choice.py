"""The branch nearest a seed within limits, on bare floats, in one straight piece of code.

Lengths in mm, angles in rad. Planners and jogging solve one pose thousands of times, and what
costs time in Python is calls and containers: so the elbow triangle of McKerrow, chapter 4,
section 16, its mirror image behind the base axis, the turns of every angle and the comparison
with the seed are written out here once. `closed_form` holds the same formulas one by one.
"""

from __future__ import annotations

from math import acos, atan2, cos, hypot, inf, pi, sin, sqrt
from typing import NamedTuple

from kinematics.closed_form import AXIS_MM, REACH_MM, Angles, Lengths, elbow_cosine
from kinematics.limits import LIMIT_TOLERANCE_RAD, fitted

Span = tuple[float, float]
"""The lowest and the highest of a range."""

_FOLDED_MM2 = REACH_MM * REACH_MM


class Build(NamedTuple):
    """What the choice needs of an arm, worked out once.

    `square_sum` is a2^2 + a3^2 and `double_product` 2 a2 a3, of the cosine rule. No base or elbow
    angle within half a turn either way and outside of its gate has a turn within its limits.
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


def build(lengths: Lengths, bounds: tuple[Span, ...]) -> Build:
    """Return what `nearest_posture` needs of an arm with these lengths and limits."""
    height, upper, fore, hand = lengths
    base, shoulder, elbow, wrist, roll = bounds
    return Build(
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
    goal: tuple[float, float, float, float, float], arm: Build, table_roll: float, near: Angles
) -> Angles | None:
    """Return the posture for x, y, z, pitch and roll; see `closed_form.inverse` for the terms."""
    x, y, z, pitch, roll = goal
    r = hypot(x, y)
    on_axis = r <= AXIS_MM
    base = near[0] if on_axis else atan2(y, x)
    return nearest_posture(
        base,
        r - arm.hand * cos(pitch),
        z - arm.height - arm.hand * sin(pitch),
        pitch,
        roll + table_roll * base,
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
    arm: Build,
    near: Angles,
) -> Angles | None:
    """Return the posture within limits with the least sum of squared changes from `near`.

    The wrist is given in the arm's plane from the shoulder axis, and the base within half a turn
    either way. None where the elbow triangle does not close or every branch breaks a limit. The
    base turned by half a circle is tried where `mirrored_too`.
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
            if change < least:  # never where a joint found no turn: that is infinitely far
                best, least = (b, s, e, w, r), change
    return best


def _gate(low: float, high: float) -> Span:
    """Return the gate of a range: none where a second turn of an angle may lie within it."""
    low, high = low - LIMIT_TOLERANCE_RAD, high + LIMIT_TOLERANCE_RAD
    return (low, high) if -pi < low and high < pi else (-inf, inf)
