"""Small matrices on plain floats, without numpy: products, linear systems, singular values.

Enough for six motors or seven joints; beyond that numpy is the tool.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import mul

Matrix = tuple[tuple[float, ...], ...]

# A pivot smaller than this, against its row's largest entry, is a row that adds nothing.
PIVOT = 1e-12


class DependentRow(ArithmeticError):
    """A row of a square matrix is a combination of the rows above it; `row` is its index."""

    def __init__(self, row: int) -> None:
        self.row = row
        super().__init__(f"row {row} depends on the rows above it")


def inverse(matrix: Matrix) -> Matrix:
    """Return the inverse of a square matrix, or raise `DependentRow`.

    Gauss-Jordan with the largest entry of each row as its pivot: rows keep their order, so that
    the row which adds nothing can be named.
    """
    size = len(matrix)
    rows = [
        [*row, *(1.0 if column == index else 0.0 for column in range(size))]
        for index, row in enumerate(matrix)
    ]
    pivots: list[int] = []
    for index, row in enumerate(rows):
        scale = max(abs(entry) for entry in matrix[index])
        pivot = max(range(size), key=lambda column: abs(row[column]))
        if abs(row[pivot]) <= PIVOT * scale:
            raise DependentRow(index)
        pivots.append(pivot)
        rows[index] = row = [entry / row[pivot] for entry in row]
        for other, line in enumerate(rows):
            if other != index and line[pivot] != 0.0:
                factor = line[pivot]
                rows[other] = [a - factor * b for a, b in zip(line, row, strict=True)]
    order = sorted(range(size), key=pivots.__getitem__)
    return tuple(tuple(rows[index][size:]) for index in order)


def times(matrix: Matrix, vector: Sequence[float]) -> tuple[float, ...]:
    """Return the product of a matrix and a vector."""
    for row in matrix:
        if len(row) != len(vector):
            raise ValueError(f"a vector of {len(vector)} does not fit the rows of this matrix")
    return tuple([sum(map(mul, row, vector)) for row in matrix])


def transposed(matrix: Matrix) -> Matrix:
    """Return the matrix with rows and columns exchanged."""
    return tuple(zip(*matrix, strict=True))


# Singular values.

# Cosine between two columns below which a sweep of rotations leaves them alone.
ORTHOGONAL = 1e-13

# Sweeps after which singular values are taken as they are; some six are usual.
SWEEPS = 60


@dataclass(frozen=True, slots=True)
class Singular:
    """A matrix as the sum of value * left * right over its singular values, largest first.

    There are as many as the smaller of its dimensions. `left` are unit vectors of the rows'
    space and `right` of the columns', each set orthogonal; the left vector of a value that is
    exactly zero is zero too (of a matrix wider than high, the right one).
    """

    values: tuple[float, ...]
    left: Matrix
    right: Matrix


def singular(matrix: Matrix) -> Singular:
    """Return the singular value decomposition, by one-sided rotations (Hestenes, 1958).

    Columns are rotated in pairs until they are orthogonal: small singular values come out as
    exact, against their own size, as large ones, which elimination and normal equations lose.
    """
    if len(matrix) < len(matrix[0]):
        turned = singular(transposed(matrix))
        return Singular(turned.values, turned.right, turned.left)
    columns = [list(column) for column in transposed(matrix)]
    size = len(columns)
    turns = [[1.0 if i == j else 0.0 for i in range(size)] for j in range(size)]
    for _ in range(SWEEPS):
        if not _sweep(columns, turns):
            break
    lengths = [math.hypot(*column) for column in columns]
    order = sorted(range(size), key=lambda index: -lengths[index])
    return Singular(
        tuple(lengths[index] for index in order),
        tuple(
            tuple(entry / lengths[index] if lengths[index] else 0.0 for entry in columns[index])
            for index in order
        ),
        tuple(tuple(turns[index]) for index in order),
    )


def _sweep(columns: list[list[float]], turns: list[list[float]]) -> bool:
    """Make every pair of columns orthogonal once; whether any was not."""
    turned = False
    sizes = [sum(map(mul, column, column)) for column in columns]
    for i in range(len(columns) - 1):
        for j in range(i + 1, len(columns)):
            one, other = columns[i], columns[j]
            across = sum(map(mul, one, other))
            if across * across <= ORTHOGONAL * ORTHOGONAL * sizes[i] * sizes[j]:
                continue
            turned = True
            ratio = (sizes[j] - sizes[i]) / (2.0 * across)
            tangent = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
            cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
            sine = cosine * tangent
            columns[i] = [cosine * a - sine * b for a, b in zip(one, other)]  # noqa: B905
            columns[j] = [sine * a + cosine * b for a, b in zip(one, other)]  # noqa: B905
            one, other = turns[i], turns[j]
            turns[i] = [cosine * a - sine * b for a, b in zip(one, other)]  # noqa: B905
            turns[j] = [sine * a + cosine * b for a, b in zip(one, other)]  # noqa: B905
            sizes[i] = sum(map(mul, columns[i], columns[i]))
            sizes[j] = sum(map(mul, columns[j], columns[j]))
    return turned
