"""How much the tests try: a sample by default, everything with THOROUGH=1 in the environment."""

import functools
import inspect
import os
from collections.abc import Callable, Iterable, Sequence
from itertools import product
from typing import TypeVar

import pytest

T = TypeVar("T")

THOROUGH = os.environ.get("THOROUGH", "0") not in ("", "0")


def amount(everyday: T, thorough: T) -> T:
    """Return one of two numbers of rounds, examples or frames, or one of two lists of rows."""
    return thorough if THOROUGH else everyday


def in_pairs(names: str, *values: Sequence[object]) -> pytest.MarkDecorator:
    """Parametrize a test with three or more lists of values.

    A sample has every pair of values of any two lists, but not every combination of all.
    """
    rows = list(product(*(enumerate(each) for each in values)))
    fewest = 1 if THOROUGH else min(map(len, values))
    tried = [row for row in rows if sum(index for index, _ in row) % fewest == 0]
    return pytest.mark.parametrize(names, [tuple(value for _, value in row) for row in tried])


def each_value(names: str, *values: Sequence[object]) -> pytest.MarkDecorator:
    """Parametrize a test with lists of values that hardly depend on each other.

    A sample has every value of every list; everything has all combinations.
    """
    count = max(map(len, values))
    sample = [tuple(each[index % len(each)] for each in values) for index in range(count)]
    return pytest.mark.parametrize(names, list(product(*values)) if THOROUGH else sample)


def every_row(
    names: str, rows: Iterable[object], ids: Iterable[str] | Callable[[object], str] = repr
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Check every row of a table of plain values in one test, which names all rows that fail.

    It is written as `pytest.mark.parametrize`, which makes a test of every row: that takes longer
    than checking a hundred values. Rows here share their fixtures, so scenarios stay there.
    """
    keys = [name.strip() for name in names.split(",")]
    rows = list(rows)
    titles = map(ids, rows) if callable(ids) else ids
    table = [
        (title, dict(zip(keys, row if len(keys) > 1 else (row,), strict=True)))
        for title, row in zip(titles, rows, strict=True)
    ]
    assert table, "a table without a row would check nothing"

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(test)
        def check_all(**fixtures: object) -> None:
            failures = []
            for title, values in table:
                try:
                    test(**fixtures, **values)
                except (Exception, pytest.fail.Exception) as failure:
                    failure.add_note(f"in the row {title}")
                    failures.append(failure)
            if failures:
                raise BaseExceptionGroup(f"{len(failures)} of {len(table)} rows fail", failures)

        signature = inspect.signature(test)
        others = [each for name, each in signature.parameters.items() if name not in keys]
        check_all.__signature__ = signature.replace(parameters=others)
        return check_all

    return decorate
