"""Run every behaviour on every dialect and transport; print the table, or write its page.

    python -m tests.conformance
    python -m tests.conformance --write docs/background/conformance.md

The exit code is 1 if a behaviour is not as promised.
"""

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from armdrive.registry import DIALECTS

from .running import BEHAVIOURS, BENCHES, RowResult, Task, Verdict, is_reachable, run_task
from .table import broken, markdown, page, summary

COMMAND = "python -m tests.conformance --write docs/background/conformance.md"
JOBS = 4


def options(words: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.conformance", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--write", metavar="PAGE", type=Path, help="write the page as well")
    parser.add_argument("--dialect", action="append", choices=list(DIALECTS))
    parser.add_argument("--transport", action="append", choices=list(BENCHES))
    parser.add_argument("--only", default="", metavar="TEXT", help="behaviours with this text")
    parser.add_argument("--jobs", type=int, default=JOBS, help="rows at a time")
    return parser.parse_args(words)


def tasks(chosen: argparse.Namespace) -> list[Task]:
    """Return the chosen rows."""
    return [
        (row.name, dialect, transport)
        for transport in chosen.transport or BENCHES
        for row in BEHAVIOURS
        if chosen.only in row.name and row.runs_over(transport)
        for dialect in chosen.dialect or DIALECTS
        if is_reachable(dialect, transport)
    ]


def results(wanted: Sequence[Task], jobs: int) -> Iterator[RowResult]:
    """Run the rows in several processes, because nearly all of their time is waiting."""
    with ProcessPoolExecutor(jobs) as pool:
        for number, result in enumerate(pool.map(run_task, wanted), 1):
            if result.verdict is Verdict.BROKEN:
                sys.stderr.write(f"\r{result.dialect}, {result.transport}: {result.behaviour}: ")
                sys.stderr.write(f"{result.words}\n")
            sys.stderr.write(f"\r{number} of {len(wanted)} ")
            sys.stderr.flush()
            yield result
    sys.stderr.write("\n")


def main(words: Sequence[str] | None = None) -> int:
    """Run the chosen rows; return the exit code."""
    chosen = options(words)
    began_s = time.monotonic()
    found = list(results(tasks(chosen), max(chosen.jobs, 1)))
    run = {each.behaviour for each in found}
    shown = [row for row in BEHAVIOURS if row.name in run]
    sys.stdout.write("\n".join([*markdown(shown, found), *broken(found)]))
    sys.stdout.write(f"\n{summary(found)} in {time.monotonic() - began_s:.0f} s\n")
    if chosen.write is not None:
        chosen.write.write_text(page(shown, found, COMMAND), encoding="utf-8")
    return int(any(each.verdict is Verdict.BROKEN for each in found))


if __name__ == "__main__":
    sys.exit(main())
