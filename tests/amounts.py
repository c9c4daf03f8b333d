"""How much the tests try: a sample by default, everything with THOROUGH=1 in the environment."""

import os
from collections.abc import Sequence
from itertools import product

import pytest

THOROUGH = os.environ.get("THOROUGH", "0") not in ("", "0")


def amount(everyday: int, thorough: int) -> int:
    """Return one of two numbers of rounds, examples or frames."""
    return thorough if THOROUGH else everyday


def in_pairs(names: str, *values: Sequence[object]) -> pytest.MarkDecorator:
    """Parametrize a test with three or more lists of values.

    A sample has every pair of values of any two lists, but not every combination of all.
    """
    rows = list(product(*(enumerate(each) for each in values)))
    fewest = 1 if THOROUGH else min(map(len, values))
    tried = [row for row in rows if sum(index for index, _ in row) % fewest == 0]
    return pytest.mark.parametrize(names, [tuple(value for _, value in row) for row in tried])
