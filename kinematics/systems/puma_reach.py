"""Where the wrist's centre of an arm with a spherical wrist can be, and what keeps it elsewhere.

Lengths in mm. Joint limits aside: this is what the lengths alone allow.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from kinematics.systems.spherical_wrist import WristArm
from kinematics.systems.triangle import broken_bound, brought_within


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
