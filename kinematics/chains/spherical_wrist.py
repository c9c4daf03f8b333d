"""Six-axis arms with a spherical wrist, any lengths, on bare floats: all eight branches at once.

Source: the simplified Puma of McKerrow, chapter 4, section 16, written for the link table of Fu,
Gonzalez and Lee (1987), table 2.1, with any lengths: a shoulder offset (a1), a lateral shoulder
(d2), an upper arm (a2), an elbow offset (a3), a forearm (d4) and a hand (d6). The first three
joints place the wrist's centre, the last three turn the hand about it. Lengths in mm, angles in
rad; nothing is checked and nothing but floats and tuples is made, since planners call this often.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2, cos, hypot, pi, sin, sqrt, tau

from kinematics.frames.transforms import Transform

REACH_MM = 1e-9
"""How far beyond its reach rounding may put a goal that touches it."""

Angles6 = tuple[float, float, float, float, float, float]

NOWHERE = REACH_MM * REACH_MM
"""Square of a distance from an axis at which a direction means nothing."""

NEAR_STRAIGHT = 1e-3
"""Below this sine of joint 5 the outer wrist joints are solved as a pair, at no loss of digits."""

STRAIGHT = 1e-10
"""Below this sine of joint 5 only the sum (or difference) of joints 4 and 6 is defined.

The hand is then off by at most twice this angle, since joint 4 is taken as given.
"""


NOTHING_FREE = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class WristArm:
    """Lengths in mm of an arm with a spherical wrist, and what follows from them."""

    height: float
    shoulder_offset: float
    lateral: float
    upper: float
    hand: float
    reach: float
    """From the elbow to the wrist's centre, across the elbow offset."""
    lean: float
    """Angle at the elbow between the elbow offset and the line to the wrist's centre, in rad."""
    squares: float
    """Sum of the squares of upper arm and reach."""
    product: float
    """Twice the product of upper arm and reach."""

    @classmethod
    def of(
        cls,
        height: float,
        shoulder_offset: float,
        lateral: float,
        upper: float,
        elbow_offset: float,
        forearm: float,
        hand: float,
    ) -> WristArm:
        """Make the arm of a link table's d1, a1, d2, a2, a3, d4 and d6."""
        reach = hypot(elbow_offset, forearm)
        squares, product = upper * upper + reach * reach, 2.0 * upper * reach
        lean = atan2(forearm, elbow_offset)
        return cls(height, shoulder_offset, lateral, upper, hand, reach, lean, squares, product)


def inverse(
    goal: Transform, arm: WristArm, free: tuple[float, float, float] = NOTHING_FREE
) -> list[Angles6 | None]:
    """Return the eight postures that hold the hand at a frame, None where one does not exist.

    In order: base front and back, of each elbow up and down, of each wrist plain and flipped
    (joint 5 positive and negative). `free` gives joints 1, 2 and 4 where any value serves: the
    base with the wrist's centre on its axis, the upper arm with it on the shoulder, joint 4 with
    joint 5 straight. Angles within -pi to pi, the free ones as given.
    """
    (_, _, ax, px), (_, _, ay, py), (_, _, az, pz), _ = goal
    hand, lateral = arm.hand, arm.lateral
    x, y, z = px - hand * ax, py - hand * ay, pz - hand * az - arm.height
    squared = x * x + y * y - lateral * lateral
    if squared > 0.0:
        out = sqrt(squared)
    elif hypot(x, y) >= abs(lateral) - REACH_MM:
        out = 0.0
    else:
        return [None] * 8
    towards = atan2(y, x) if x * x + y * y > NOWHERE else free[0]
    turn = atan2(lateral, out)
    front, back = towards - turn, towards + turn - pi
    if front > pi or front <= -pi:
        front += tau if front < 0.0 else -tau
    if back <= -pi:
        back += tau
    offset = arm.shoulder_offset
    found = _postures(goal, arm, front, out - offset, z, 1.0, free)
    found += _postures(goal, arm, back, -out - offset, z, -1.0, free)
    return found


def _postures(
    goal: Transform,
    arm: WristArm,
    base: float,
    u: float,
    v: float,
    up: float,
    free: tuple[float, float, float],
) -> list[Angles6 | None]:
    """Return the four postures of one base angle; `up` is the elbow's sign that means up.

    The wrist's centre is u outwards and v upwards of the shoulder, in the arm's own plane.
    """
    cosine = (u * u + v * v - arm.squares) / arm.product
    if not -1.0 <= cosine <= 1.0:
        if broken_bound(hypot(u, v), arm.upper, arm.reach) is not None:
            return [None] * 4
        cosine = 1.0 if cosine > 0.0 else -1.0
    sine = up * sqrt(1.0 - cosine * cosine)
    lean, reach = arm.lean, arm.reach
    along, across = arm.upper + reach * cosine, reach * sine
    bend = atan2(sine, cosine)
    cb, sb = cos(base), sin(base)
    (nx, ox, ax, _), (ny, oy, ay, _), (nz, oz, az, _), _ = goal
    n, o, a = cb * nx + sb * ny, cb * ox + sb * oy, cb * ax + sb * ay
    wy = cb * ay - sb * ax
    away = u * u + v * v > NOWHERE
    found: list[Angles6 | None] = []
    for side in (across, -across):
        upper = atan2(v * along + u * side, u * along - v * side) if away else -free[1]
        elbow = lean + bend
        both = elbow - upper
        if elbow > pi or elbow <= -pi:
            elbow += tau if elbow < 0.0 else -tau
        c, s = cos(both), sin(both)
        wx, wz = c * a - s * az, s * a + c * az
        bent = sqrt(wx * wx + wy * wy)
        five = atan2(bent, wz)
        if bent > NEAR_STRAIGHT:
            four = atan2(wy, wx)
            six = atan2(s * o + c * oz, -s * n - c * nz)
        else:
            four = atan2(wy, wx) if bent > STRAIGHT else free[2]
            six = _last(four, c * n - s * nz, cb * ny - sb * nx, c * o - s * oz, cb * oy - sb * ox)
        found += (
            (base, -upper, elbow, four, five, six),
            (
                base,
                -upper,
                elbow,
                four + pi if four <= 0.0 else four - pi,
                -five,
                six + pi if six <= 0.0 else six - pi,
            ),
        )
        bend = -bend
    return found


def _last(four: float, nx: float, ny: float, ox: float, oy: float) -> float:
    """Return joint 6 from joint 4 and the hand's x and y axes, seen from the forearm.

    Exact for any joint 4 where joint 5 is straight, and keeps all digits next to it, where
    joints 4 and 6 each lose digits but only together turn the hand.
    """
    c, s = cos(four), sin(four)
    return atan2(c * ny - s * nx, c * oy - s * ox)


# Where the wrist's centre of an arm with a spherical wrist can be, and what keeps it elsewhere.
# Joint limits aside: this is what the lengths alone allow.


def reach_broken(arm: WristArm, x: float, y: float, z: float) -> tuple[str, float, float]:
    """Return what a wrist's centre out of reach breaks: the quantity, its value, its bound."""
    radius, lateral = math.hypot(x, y), abs(arm.lateral)
    if radius < lateral:
        return "the wrist's distance from the base axis", radius, lateral
    out = math.sqrt(radius * radius - lateral * lateral)
    up = z - arm.height
    distance = min(
        (math.hypot(side - arm.shoulder_offset, up) for side in (out, -out)),
        key=lambda value: abs(value - (broken_bound(value, arm.upper, arm.reach) or value)),
    )
    bound = broken_bound(distance, arm.upper, arm.reach)
    return "the wrist's distance from the shoulder", distance, distance if bound is None else bound


def nearest_wrist(arm: WristArm, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a wrist's centre within reach near to this one, in the same direction of the base."""
    radius = math.hypot(x, y)
    out = math.sqrt(max(radius * radius - arm.lateral * arm.lateral, 0.0))
    up = z - arm.height
    near_out, near_up = min(
        _candidates(arm, out, up), key=lambda point: math.hypot(point[0] - out, point[1] - up)
    )
    wide = math.hypot(near_out, arm.lateral)
    along = (x / radius, y / radius) if radius > 0.0 else (1.0, 0.0)
    return along[0] * wide, along[1] * wide, near_up + arm.height


def _candidates(arm: WristArm, out: float, up: float) -> Iterator[tuple[float, float]]:
    """Yield points (outwards, upwards of the shoulder's height) that front or back reach."""
    longest = arm.upper + arm.reach
    for side in (1.0, -1.0):
        offset = side * arm.shoulder_offset
        near_out, near_up = brought_within(out - offset, up, arm.upper, arm.reach)
        if near_out + offset >= 0.0:
            yield near_out + offset, near_up
        if longest + offset >= 0.0:
            yield longest + offset, 0.0


# What two links span, whatever they belong to.


def broken_bound(distance: float, first: float, second: float) -> float | None:
    """Return the span in mm that a tip at this distance exceeds or undercuts, or None."""
    longest, shortest = first + second, abs(first - second)
    if distance > longest + REACH_MM:
        return longest
    return shortest if distance < shortest - REACH_MM else None


def brought_within(x: float, y: float, first: float, second: float) -> tuple[float, float]:
    """Return the point nearest to (x, y) that two links reach; at the joint itself, along x."""
    distance = math.hypot(x, y)
    bound = broken_bound(distance, first, second)
    if bound is None:
        return x, y
    if distance <= REACH_MM:
        return bound, 0.0
    return x * bound / distance, y * bound / distance
