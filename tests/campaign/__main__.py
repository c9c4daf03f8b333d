"""Run thousands of missions with random faults in simulated time, and print their outcomes.

    python -m tests.campaign                              10,000 missions over all dialects
    python -m tests.campaign --missions 500 --seed 7
    python -m tests.campaign --dialect teachmover --only 123      one mission again, with its log

The exit code is 1 if a mission broke a law; the command that repeats this mission is printed.
"""

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from multiprocessing import get_context

from armdrive.registry import DIALECTS
from tests.scenarios.happenings import HAPPENINGS

from .mission import Outcome, Result, run_mission, run_task
from .programs import PROGRAM_FAULTS

CHUNK = 10
LOG_LINES = 30
NONE = "nothing"
"""The name of the row for missions without a fault."""
Task = tuple[str, int]
TITLES = {
    Outcome.ENDED_WELL: "ended well",
    Outcome.REFUSED: "refused",
    Outcome.ERROR_STOP: "error-stop, recovered",
    Outcome.PROGRAM_ENDED: "program ended, recovered",
    Outcome.LINK_LOST: "link lost, recovered",
    Outcome.VIOLATION: "VIOLATION",
}


def options(words: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaign", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--missions", type=int, default=10_000, help="their number")
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument(
        "--only", type=int, metavar="SEED", help="run this mission alone, and print its log"
    )
    parser.add_argument("--dialect", action="append", choices=list(DIALECTS))
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes")
    return parser.parse_args(words)


def tasks(dialects: Sequence[str], missions: int, seed: int) -> list[Task]:
    """Return the missions to run; the dialects take turns."""
    return [(dialects[i % len(dialects)], seed + i // len(dialects)) for i in range(missions)]


def results(wanted: Sequence[Task], jobs: int) -> Iterator[Result]:
    """Run missions, in processes of their own if there is more than one job."""
    if jobs <= 1:
        yield from map(run_task, wanted)
        return
    # `run_task` is in another file, because a spawned process does not load a package's `__main__`
    with get_context("spawn").Pool(jobs) as pool:
        yield from pool.imap_unordered(run_task, wanted, CHUNK)


def with_progress(found: Iterable[Result], total: int) -> Iterator[Result]:
    """Show the progress, and each violation as it comes."""
    for number, each in enumerate(found, 1):
        if each.broken:
            sys.stderr.write(f"\r{story(each)}\n")
        sys.stderr.write(f"\r{number} of {total} ")
        sys.stderr.flush()
        yield each
    sys.stderr.write("\n")


def story(result: Result) -> str:
    """Return what a mission broke, how to repeat it, and the end of its log."""
    lines = [f"VIOLATION ({result.dialect}): {'; '.join(result.broken)}"]
    lines += [f"  repeat: {result.command}"]
    lines += [f"  {line}" for line in result.log[-LOG_LINES:]]
    return "\n".join(lines)


def table_of(results: Iterable[Result]) -> str:
    """Return the table of outcomes as Markdown; a mission counts for each of its faults."""
    found = Counter((name, each.outcome) for each in results for name in each.faults or (NONE,))
    lines = ["| fault | " + " | ".join(TITLES.values()) + " |", "|---" * (1 + len(Outcome)) + "|"]
    for name in (NONE, *(each.name for each in HAPPENINGS), *PROGRAM_FAULTS):
        numbers = [found[name, each] for each in Outcome]
        if any(numbers):
            lines.append(f"| {name} | " + " | ".join(map(str, numbers)) + " |")
    return "\n".join(lines)


def main(words: Sequence[str] | None = None) -> int:
    """Run the chosen missions; return the exit code."""
    chosen = options(words)
    dialects = chosen.dialect or list(DIALECTS)
    if chosen.only is not None:
        found = [run_mission(name, chosen.only, keep_log=True) for name in dialects]
        for each in found:
            end = f"{each.dialect} {chosen.only}: {each.outcome.name}"
            sys.stdout.write("\n".join(each.log) + f"\n{end}\n")
        return int(any(each.broken for each in found))
    began_s = time.monotonic()
    wanted = tasks(dialects, chosen.missions, chosen.seed)
    found = list(with_progress(results(wanted, chosen.jobs), len(wanted)))
    broken = sum(each.outcome is Outcome.VIOLATION for each in found)
    simulated_h = sum(each.simulated_s for each in found) / 3600
    sys.stdout.write(
        f"{table_of(found)}\n\n{len(found)} missions ({', '.join(dialects)}; seeds from "
        f"{chosen.seed}), {simulated_h:.1f} simulated hours in {time.monotonic() - began_s:.0f} s: "
        f"{broken} violations\n"
    )
    return int(broken > 0)


if __name__ == "__main__":
    sys.exit(main())
