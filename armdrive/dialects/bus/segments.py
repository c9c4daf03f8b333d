"""One straight segment of a way on which drives are led. Steps, seconds since the motion began."""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinematics.spaces import Motors


@dataclass(frozen=True, slots=True)
class BusSegment:
    """When and where it begins and ends."""

    start_s: float
    end_s: float
    start: Motors
    end: Motors

    def at(self, motor: int, time_s: float) -> float:
        """Return where a motor is on it, or at the nearer of its ends."""
        if time_s >= self.end_s:
            return float(self.end[motor])
        share = max(time_s - self.start_s, 0.0) / (self.end_s - self.start_s)
        return self.start[motor] + share * (self.end[motor] - self.start[motor])


# How long a way takes from rest to rest, by ramps.


def trapezoid_s(way: float, speed: float, slope: float) -> float:
    """Return how long a way takes from rest to rest, at most this fast, by ramps of a slope."""
    if not way:
        return 0.0
    if math.isinf(slope):
        return way / speed
    peak = min(speed, math.sqrt(way * slope))
    return way / peak + peak / slope if peak >= speed else 2.0 * way / peak
