"""Eigenvectors of a small symmetric matrix, by Jacobi's rotations (Golub and Van Loan, 8.5).

Bare floats in lists. Jacobi's method is slow for large matrices, but for one of 4x4 it is short,
cannot fail, and finds every eigenvector to the last digits.
"""

from __future__ import annotations

import math

SWEEPS = 60
"""Far more than the half dozen that a 4x4 matrix needs: convergence is quadratic."""

Matrix = list[list[float]]


def symmetric_eigen(matrix: Matrix) -> tuple[list[float], list[list[float]]]:
    """Return the eigenvalues, largest first, and unit eigenvectors in the same order."""
    work = [list(row) for row in matrix]
    size = range(len(work))
    vectors = [[float(row == column) for column in size] for row in size]
    for _ in range(SWEEPS):
        if all(work[p][q] == 0.0 for p in size for q in range(p)):
            break
        for p in size:
            for q in range(p):
                _annihilate(work, vectors, p, q)
    order = sorted(size, key=lambda index: -work[index][index])
    return [work[index][index] for index in order], [vectors[index] for index in order]


def _annihilate(work: Matrix, vectors: Matrix, p: int, q: int) -> None:
    """Turn the plane of p and q so that the entry (p, q) vanishes."""
    off = work[p][q]
    gap = work[q][q] - work[p][p]
    if abs(off) <= 1e-18 * (abs(work[p][p]) + abs(work[q][q])):
        work[p][q] = work[q][p] = 0.0  # nothing that the diagonal could still notice
        return
    slope = gap / (2.0 * off)
    t = math.copysign(1.0, slope) / (abs(slope) + math.hypot(slope, 1.0))
    c = 1.0 / math.hypot(t, 1.0)
    s = t * c
    for row in work:
        row[p], row[q] = c * row[p] - s * row[q], s * row[p] + c * row[q]
    work[p], work[q] = _turned(work[p], work[q], c, s)
    vectors[p], vectors[q] = _turned(vectors[p], vectors[q], c, s)
    work[p][q] = work[q][p] = 0.0


def _turned(
    first: list[float], second: list[float], c: float, s: float
) -> tuple[list[float], list[float]]:
    pairs = list(zip(first, second, strict=True))
    return [c * a - s * b for a, b in pairs], [s * a + c * b for a, b in pairs]
