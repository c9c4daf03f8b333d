"""A stack of points whose directions are wanted all at once, for a block of goals.

Lengths in mm, angles in rad. Every angle of the arm's closed form but one is the direction of a
point whose distance is known; the one is the elbow's bend. All their arc tangents are taken on
stacked rows together: that is fewer calls, and calls are what a block costs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics.batch_trig import Array, arc_tangent, directions, mirror_back


class Stack(NamedTuple):
    """Spare arrays of a block: the points whose directions are wanted, and room to find them.

    `y`, `x` and `length` have a row for each direction, the other four one more, for the bend.
    """

    y: Array
    x: Array
    length: Array
    tangent: Array
    angle: Array
    spare: Array
    other: Array


def rows_needed(count: int) -> int:
    """Return how many spare rows a stack of so many directions takes."""
    return 7 * count + 4


def stack(row: Array, count: int) -> Stack:
    """Cut spare rows into a stack of so many directions."""
    cuts = [index * count for index in range(3)]
    more = [3 * count + index * (count + 1) for index in range(4)]
    parts = [row[cut : cut + count] for cut in cuts]
    wide = [row[cut : cut + count + 1] for cut in more]
    return Stack(parts[0], parts[1], parts[2], wide[0], wide[1], wide[2], wide[3])


def fill_length(rows: Stack, index: int, spare: Array) -> None:
    """Fill the length of one of the stack's points."""
    length = rows.length[index]
    np.multiply(rows.x[index], rows.x[index], length)
    np.multiply(rows.y[index], rows.y[index], spare)
    length += spare
    np.sqrt(length, length)


def solve(rows: Stack, angles: Array) -> None:
    """Fill the angles: the stack's directions, and a quarter of the bend."""
    directions(rows.y, rows.x, rows.length, rows.tangent[:-1])
    arc_tangent(rows.tangent, angles, rows.spare, rows.other)
    mirror_back(angles[:-1], rows.y, rows.x)
