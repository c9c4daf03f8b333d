"""Small matrices on plain floats, without numpy: products and linear systems.

Enough for six motors or seven joints; beyond that numpy is the tool.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import mul

Matrix = tuple[tuple[float, ...], ...]

PIVOT = 1e-12
"""A pivot smaller than this, against its row's largest entry, is a row that adds nothing."""


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
    if any(len(row) != len(vector) for row in matrix):
        raise ValueError(f"a vector of {len(vector)} does not fit the rows of this matrix")
    return tuple([sum(map(mul, row, vector)) for row in matrix])


def transposed(matrix: Matrix) -> Matrix:
    """Return the matrix with rows and columns exchanged."""
    return tuple(zip(*matrix, strict=True))
