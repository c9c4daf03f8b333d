"""Print how long and how far each simulated arm goes on: `python benchmarks/stopping.py`.

For every dialect, in real time, on its twin in another process over a pty: a jog that is released,
a motion that is stopped, a program that is killed. Each time and each way stands beside the bound
that the status had announced. Exit code 1 where one is above its bound.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

from feel import Figures, Measured, Options, report

from tests.conformance.overrun import ENDINGS, StopMeasurement
from tests.conformance.overrun import measure as overruns

TIMES, QUICK_TIMES = 10, 1


def figures(dialect: str, what: str, found: list[StopMeasurement]) -> Iterator[Figures]:
    """Give times and ways, each beside what was announced."""
    times = [Measured(each.time_s * 1e3, each.announced_s * 1e3) for each in found]
    yield Figures(dialect, what, "ms", times)
    yield Figures(dialect, what, "mm", [Measured(each.way_mm, each.announced_mm) for each in found])


def measure(options: Options, dialect: str) -> Iterator[Figures]:
    """End motions of one dialect in every way."""
    for ending in ENDINGS:
        yield from figures(dialect, ending.what, overruns(dialect, ending, options.times))


def main(argv: list[str] | None = None) -> int:
    """Measure every dialect, or those that are asked for."""
    return report(argv, __doc__, measure, times=TIMES, quick_times=QUICK_TIMES)


if __name__ == "__main__":
    sys.exit(main())
