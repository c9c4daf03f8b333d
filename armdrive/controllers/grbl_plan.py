"""How long a board's planner takes for queued lines: trapezoids, and corners passed in motion.

Units are the board's own ("mm"), seconds. Source of the corner's speed and of the two passes:
gnea/grbl grbl/planner.c (plan_buffer_line, planner_recalculate).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from kinematics.spaces import Motors

STRAIGHT = 1e-6
"""A cosine so near to 1 or -1 is a turn right round, or none."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What the axes of the motors can do: steps a unit, units a second, units a second squared.

    `junction` is how far a corner may be cut in thought ($11), in units.
    """

    steps_per_unit: tuple[float, ...]
    rates: tuple[float, ...]
    accelerations: tuple[float, ...]
    junction: float

    def along(self, unit: Sequence[float], limits: Sequence[float]) -> float:
        """Return what a direction may have of a limit, so that no axis exceeds its own."""
        shares = zip(limits, unit, strict=True)
        return min((limit / abs(share) for limit, share in shares if share), default=math.inf)

    def rates_hz(self) -> tuple[float, ...]:
        """Return the fastest steps a second of each motor."""
        return tuple(map(math.prod, zip(self.rates, self.steps_per_unit, strict=True)))


@dataclass(frozen=True, slots=True)
class Way:
    """One line: its length, its direction, and the speed and acceleration it is driven with.

    `rate_hz` is that speed in steps a second of the busiest motor.
    """

    length: float
    unit: tuple[float, ...]
    speed: float
    acceleration: float
    rate_hz: float = math.inf

    @property
    def nominal_s(self) -> float:
        """How long it takes without ramps."""
        return self.length / self.speed

    def rest(self, share: float) -> Way:
        """Return what is left of it when a share has been driven."""
        return replace(self, length=self.length * max(1.0 - share, STRAIGHT))


def way(steps: Motors, duration_s: float, limits: Limits) -> Way:
    """Return the line of some steps that shall last so long, or longer where the axes are slow."""
    parts = [count / per for count, per in zip(steps, limits.steps_per_unit, strict=True)]
    length = math.hypot(*parts)
    unit = tuple(part / length for part in parts)
    speed = min(length / max(duration_s, 1e-9), limits.along(unit, limits.rates))
    rate_hz = speed / length * steps.largest
    return Way(length, unit, speed, limits.along(unit, limits.accelerations), rate_hz)


def corner_speed(one: Way, other: Way, limits: Limits) -> float:
    """Return how fast the corner between two lines may be passed."""
    fastest = min(one.speed, other.speed)
    cosine = -sum(a * b for a, b in zip(one.unit, other.unit, strict=True))
    if cosine > 1.0 - STRAIGHT:
        return 0.0
    if cosine < STRAIGHT - 1.0:
        return fastest
    turn = [b - a for a, b in zip(one.unit, other.unit, strict=True)]
    size = math.hypot(*turn)
    slope = limits.along([part / size for part in turn], limits.accelerations)
    half_sine = math.sqrt(0.5 * (1.0 - cosine))
    return min(fastest, math.sqrt(slope * limits.junction * half_sine / (1.0 - half_sine)))


def planned_s(ways: Sequence[Way], limits: Limits) -> float:
    """Return how long lines take from a stand-still to a stand-still."""
    speeds = [0.0, *(corner_speed(a, b, limits) for a, b in pairwise(ways)), 0.0]
    for index in range(len(ways) - 1, -1, -1):
        room = 2.0 * ways[index].acceleration * ways[index].length
        speeds[index] = min(speeds[index], math.sqrt(speeds[index + 1] ** 2 + room))
    total_s = 0.0
    for index, one in enumerate(ways):
        room = 2.0 * one.acceleration * one.length
        speeds[index + 1] = min(speeds[index + 1], math.sqrt(speeds[index] ** 2 + room))
        total_s += trapezoid_s(one, speeds[index], speeds[index + 1])
    return total_s


def trapezoid_s(one: Way, enter: float, leave: float) -> float:
    """Return how long a line takes that is entered and left at these speeds."""
    slope = one.acceleration
    peak = min(one.speed, math.sqrt(slope * one.length + (enter**2 + leave**2) / 2.0))
    peak = max(peak, enter, leave)
    ramps = (2.0 * peak**2 - enter**2 - leave**2) / (2.0 * slope)
    return (2.0 * peak - enter - leave) / slope + max(one.length - ramps, 0.0) / peak
