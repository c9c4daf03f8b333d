"""How long a way takes from rest to rest, by ramps."""

from __future__ import annotations

import math


def trapezoid_s(way: float, speed: float, slope: float) -> float:
    """Return how long a way takes from rest to rest, at most this fast, by ramps of a slope."""
    if not way:
        return 0.0
    if math.isinf(slope):
        return way / speed
    peak = min(speed, math.sqrt(way * slope))
    return way / peak + peak / slope if peak >= speed else 2.0 * way / peak
