"""What two links span, whatever they belong to. Lengths in mm."""

from __future__ import annotations

import math

REACH_MM = 1e-9
"""How far beyond its reach rounding may put a goal that touches it."""


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
