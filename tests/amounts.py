"""How much is tried: a sample every day, all of it with THOROUGH=1 in the environment."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TypeVar

T = TypeVar("T")
U = TypeVar("U")
V = TypeVar("V")

THOROUGH = os.environ.get("THOROUGH", "0") not in ("", "0")


def amount(everyday: int, thorough: int) -> int:
    """Return one of two numbers of rounds, examples or frames."""
    return thorough if THOROUGH else everyday


def every_pair(first: Iterable[T], second: Iterable[U], third: Iterable[V]) -> list[tuple[T, U, V]]:
    """Return combinations in which each pair of values from two of the lists occurs.

    `third` must be the shortest list. With THOROUGH=1, return every combination.
    """
    rows, columns, others = list(first), list(second), list(third)
    assert len(others) <= min(len(rows), len(columns))
    return [
        (row, column, other)
        for i, row in enumerate(rows)
        for j, column in enumerate(columns)
        for k, other in enumerate(others)
        if THOROUGH or (i + j) % len(others) == k
    ]
