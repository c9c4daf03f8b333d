"""How hard each part of a path is on the accelerations: the limits of its parameter, cell by cell.

The parameter is the time that a path takes at full speed, so that its own speed is 1 at most
wherever a speed is at its limit. The corners stand for a smooth curve, and its direction is taken
to turn evenly from that of one chord in its middle to that of the next in its middle; what lies
between, a cell, has one curvature. In a cell a parameter of speed v and acceleration a keeps the
coordinate i within its limit if weight_i * |a| + bend_i * v^2 <= 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

from kinematics.timing_limits import Point


class Chord(NamedTuple):
    """A straight part of a path: the least time for it, and the way."""

    least_s: float
    change: Point


class Cell(NamedTuple):
    """From the middle of one chord to that of the next: its length, and what it asks of each."""

    length: float
    weights: Point
    bends: Point


def cells_of(chords: Sequence[Chord], accelerations: Sequence[float]) -> list[Cell]:
    """Return a cell for each corner and half a chord at each end; what has no limit is left out."""
    bounded = [(index, limit) for index, limit in enumerate(accelerations) if limit < math.inf]
    shares = [
        [chord.change[index] / (chord.least_s * limit) for index, limit in bounded]
        for chord in chords
    ]
    sizes = [tuple(map(abs, share)) for share in shares]
    straight = (0.0,) * len(bounded)
    cells = [Cell(chords[0].least_s / 2.0, sizes[0], straight)]
    for index in range(1, len(chords)):
        length = 0.5 * (chords[index - 1].least_s + chords[index].least_s)
        bends = [abs(b - a) / length for a, b in zip(shares[index - 1], shares[index], strict=True)]
        cells.append(Cell(length, tuple(map(max, sizes[index - 1], sizes[index])), tuple(bends)))
    cells.append(Cell(chords[-1].least_s / 2.0, sizes[-1], straight))
    return cells


def widened(cells: Sequence[Cell], window: float) -> list[Cell]:
    """Return cells that keep the limits of all that is nearer than `window` as well.

    Long cells are cut first, so that what is near their ends does not hold for all of them.
    """
    ends = list(accumulate(cell.length for cell in cells))
    starts = [0.0, *ends[:-1]]
    slack = 1e-9 * window  # what only touches is no neighbour
    made = []
    end = 0.0
    first = last = 0
    for cell in cells:
        for length in _cut(cell.length, window):
            start, end = end, end + length
            while ends[first] <= start - window + slack:
                first += 1
            while last < len(cells) and starts[last] < end + window - slack:
                last += 1
            made.append(_hardest(length, cells[first:last]))
    return made


def _cut(length: float, window: float) -> tuple[float, ...]:
    if length <= 2.0 * window:
        return (length,)
    return window, length - 2.0 * window, window


def _hardest(length: float, cells: Sequence[Cell]) -> Cell:
    """Return a cell of this length that is as hard on each coordinate as any of these."""
    if len(cells) == 1:
        return Cell(length, cells[0].weights, cells[0].bends)
    _, weights, bends = zip(*cells, strict=True)
    return Cell(length, tuple(map(max, *weights)), tuple(map(max, *bends)))
