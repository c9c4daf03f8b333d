"""Print how long and how far each simulated arm goes on: `python benchmarks/stopping.py`.

For every dialect, in real time, on its twin in another process over a pty: a jog that is released,
a motion that is stopped, a program that is killed. The worst of them stands beside the bound that
the status had announced. Exit code 1 where one is above its bound.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from statistics import median

from measuring import own_home
from reporting import machine

sys.path.insert(0, str(Path(__file__).parents[1]))
from armdrive.registry import DIALECTS
from tests.conformance.overrun import ENDINGS, StopMeasurement, measure

TIMES = 10
HEAD = ("dialect", "what", "median", "worst", "announced", "median", "worst", "announced", "")
WIDTHS = (12, 36, 9, 9, 11, 10, 10, 11, 0)


def line(dialect: str, what: str, found: list[StopMeasurement]) -> str:
    """Return a row: seconds and mm, the worst beside the least that was announced."""
    times = [each.time_s for each in found]
    ways = [each.way_mm for each in found]
    cells = (
        dialect,
        what,
        f"{median(times):.3f} s",
        f"{max(times):.3f} s",
        f"{min(each.announced_s for each in found):.3f} s",
        f"{median(ways):.1f} mm",
        f"{max(ways):.1f} mm",
        f"{min(each.announced_mm for each in found):.1f} mm",
        "" if all(each.kept for each in found) else "ABOVE ITS BOUND",
    )
    return padded(cells)


def padded(cells: tuple[str, ...]) -> str:
    """Return cells in columns."""
    return "".join(f"{cell:<{width}}" for cell, width in zip(cells, WIDTHS, strict=True)).rstrip()


def main(argv: list[str] | None = None) -> int:
    """Measure every dialect, or those that are asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("dialects", nargs="*", metavar="DIALECT", help=", ".join(DIALECTS))
    parser.add_argument("--times", type=int, default=TIMES, help="how often each is done")
    options = parser.parse_args(argv)
    unknown = set(options.dialects) - set(DIALECTS)
    if unknown:
        parser.error(f"no dialect is called {min(unknown)}; there are {', '.join(DIALECTS)}")
    print(machine(), f"each {options.times} times", padded(HEAD), sep="\n")
    kept = True
    with own_home():
        for dialect in options.dialects or DIALECTS:
            for ending in ENDINGS:
                found = measure(dialect, ending, max(options.times, 1))
                print(line(dialect, ending.what, found), flush=True)
                kept = kept and all(each.kept for each in found)
    return 0 if kept else 1


if __name__ == "__main__":
    sys.exit(main())
