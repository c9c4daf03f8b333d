"""One straight line of a path in motor space: its length, and how fast it may be followed.

Steps of the motors; `units` of the controller's own (mm or degrees), seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from armdrive.sim.profile import nearest

_STRAIGHT = 1e-6
"""Lines whose directions differ by less than this cosine are one, or turn right round."""


@dataclass(frozen=True, slots=True)
class PathLimits:
    """What each axis can do, and how far a corner may be cut in thought (GRBL's $11), in units."""

    steps_per_unit: tuple[float, ...]
    most_rate: tuple[float, ...]
    acceleration: tuple[float, ...]
    junction_deviation: float = 0.01

    def along(self, unit: Sequence[float], limits: Sequence[float]) -> float:
        """Return what a direction may have of a limit, so that no axis exceeds its own."""
        return min(
            (limit / abs(share) for limit, share in zip(limits, unit, strict=True) if share),
            default=math.inf,
        )


@dataclass(frozen=True, slots=True)
class Line:
    """A line by its steps; `rate` is what was asked for, and `most` what the axes allow.

    A motor that turns at all makes the line at no less than the speed `least`.
    """

    deltas: tuple[int, ...]
    length: float
    unit: tuple[float, ...]
    acceleration: float
    most: float
    rate: float
    rapid: bool
    tag: Any
    least: float = 0.0

    @property
    def step(self) -> float:
        """The length of one step of its busiest motor."""
        return self.length / max(map(abs, self.deltas))

    def nominal(self, scale: tuple[float, float]) -> float:
        """Return the speed of its middle; `scale` is the override of feeds and of rapids."""
        return min((self.most if self.rapid else self.rate) * scale[self.rapid], self.most)

    def made(self, along: float) -> tuple[int, ...]:
        """Return the steps made at a length along it."""
        if along >= self.length:
            return self.deltas
        share = along / self.length
        return tuple(
            nearest(abs(delta) * share) * (1 if delta > 0 else -1) for delta in self.deltas
        )


def line(
    deltas: Sequence[int],
    limits: PathLimits,
    rate: float,
    slowest_hz: float = 0.0,
    *,
    rapid: bool = False,
    tag: Any = None,
) -> Line | None:
    """Make a line of some steps at a rate in units a second; None where there is no way to go.

    Its busiest motor turns no slower than `slowest_hz` steps a second.
    """
    way = [count / per for count, per in zip(deltas, limits.steps_per_unit, strict=True)]
    length = math.hypot(*way)
    if not length:
        return None
    unit = tuple(part / length for part in way)
    slope = limits.along(unit, limits.acceleration)
    most = limits.along(unit, limits.most_rate)
    least = slowest_hz * length / max(map(abs, deltas))
    return Line(tuple(deltas), length, unit, slope, most, rate, rapid, tag, least)


def corner_speed(one: Line, other: Line, limits: PathLimits) -> float:
    """Return how fast the corner between two lines may be passed.

    Source: gnea/grbl grbl/planner.c (plan_buffer_line): the speed on a circle that touches both
    lines and comes within the junction deviation of their corner.
    """
    cosine = -sum(a * b for a, b in zip(one.unit, other.unit, strict=True))
    if cosine > 1.0 - _STRAIGHT:
        return 0.0
    if cosine < _STRAIGHT - 1.0:
        return math.inf
    turn = [b - a for a, b in zip(one.unit, other.unit, strict=True)]
    size = math.hypot(*turn)
    slope = limits.along([part / size for part in turn], limits.acceleration)
    half_sine = math.sqrt((1.0 - cosine) / 2)
    return math.sqrt(slope * limits.junction_deviation * half_sine / (1.0 - half_sine))
