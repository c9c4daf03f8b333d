"""The quickest profile of a path's parameter through its cells: a pass forwards, one backwards.

The parameter's speed is at most 1 (see timing_cells.py). Squared speeds are what accelerations
add to evenly along the way. Where a cell bends, what the bend takes of a coordinate's
acceleration is taken as if it always added to what speeds up or brakes; so nothing is passed, and
a little is given away in curves.

Source: the passes are those of Kunz and Stilman, Time-Optimal Trajectory Generation for Path
Following with Bounded Acceleration and Velocity (RSS 2012), with the two terms of an
acceleration kept apart, which leaves no place where the way on is barred.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import sqrt

from kinematics.profiles import Phase, Profile
from kinematics.timing_cells import Cell

ROUNDING = 1e-12
"""A squared speed that is this much higher is not: top speed is 1."""


def quickest(cells: Sequence[Cell], whole: float) -> Profile:
    """Return the profile of the parameter over all cells, whose lengths add up to the whole."""
    squares = _squares(cells)
    phases: list[Phase] = []
    distance = 0.0
    for cell, (before, behind) in zip(cells, pairwise(squares), strict=True):
        for phase in _through(cell, before, behind, distance):
            if phases and phase.steady and phases[-1].steady and phase.speed == phases[-1].speed:
                longer_s = phases[-1].duration_s + phase.duration_s
                phases[-1] = phases[-1]._replace(duration_s=longer_s)
            else:
                phases.append(phase)
        distance += cell.length
    return Profile(tuple(phases), whole)


def _squares(cells: Sequence[Cell]) -> list[float]:
    """Return the largest squared speed at each cell's border, 0 at both ends of the path."""
    caps = [min(1.0, _inverse(max(cell.bends, default=0.0))) for cell in cells]
    borders = [0.0, *map(min, caps, caps[1:]), 0.0]
    _pass(cells, borders)
    borders.reverse()
    _pass(cells[::-1], borders)
    borders.reverse()
    return borders


def _pass(cells: Iterable[Cell], borders: list[float]) -> None:
    """Lower each border to what the acceleration from the one before allows."""
    square = borders[0]
    for index, (length, weights, bends) in enumerate(cells, 1):
        if square >= borders[index]:
            square = borders[index]
            continue
        double = 2.0 * length
        gain = math.inf
        for weight, bend in zip(weights, bends, strict=True):
            under = weight + double * bend  # the bend counts at the faster end
            if under > 0.0:
                gain = min(gain, (1.0 - bend * square) / under)
        square = min(borders[index], square + double * max(gain, 0.0))
        borders[index] = square


def _through(cell: Cell, before: float, behind: float, distance: float) -> Iterator[Phase]:
    """Yield the phases through a cell: up to a speed, at it, and down to that of the next."""
    length = cell.length
    slope = math.inf if before == 1.0 == behind else _slope(cell, before + behind)
    if slope == math.inf:
        yield Phase(length, distance, 1.0, 0.0, 0.0)
        return
    peak = 0.5 * (before + behind) + slope * length
    if peak <= max(before, behind) + ROUNDING:
        change = 0.5 * (behind - before) / length
        start, end = sqrt(before), sqrt(behind)
        yield Phase(2.0 * length / (start + end), distance, start, change, 0.0)
        return
    peak = min(peak, 1.0)
    start, top, end = sqrt(before), sqrt(peak), sqrt(behind)
    up, down = 0.5 * (peak - before) / slope, 0.5 * (peak - behind) / slope
    level = length - up - down
    if up > 0.0:
        yield Phase((top - start) / slope, distance, start, slope, 0.0)
    if level > 0.0:
        yield Phase(level / top, distance + up, top, 0.0, 0.0)
    if down > 0.0:
        yield Phase((top - end) / slope, distance + length - down, top, -slope, 0.0)


def _slope(cell: Cell, squares: float) -> float:
    """Return the acceleration at which a cell may be sped through and braked in.

    The speed is at most that of a peak in its middle: half the sum of the squares at its ends,
    and the acceleration times its length.
    """
    slope = math.inf
    for weight, bend in zip(cell.weights, cell.bends, strict=True):
        under = weight + bend * cell.length
        if under > 0.0:
            slope = min(slope, (1.0 - 0.5 * bend * squares) / under)
    return max(slope, 0.0)


def _inverse(value: float) -> float:
    return 1.0 / value if value > 0.0 else math.inf
