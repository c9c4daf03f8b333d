"""A day of mixed work in simulated time: memory stays flat, nothing drifts, no step is lost.

    python -m tests.campaign.soak --jobs 2                   24 hours of each dialect
    python -m tests.campaign.soak --hours 1 --dialect grbl
    python -m tests.campaign.soak --lasting                one program all the time

After every call the physical arm is compared with the acknowledged position. Every hour the arm
returns to its start, where its motors must stand on the same steps. The exit code is 1 if they do
not, or if memory keeps growing.
"""

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from multiprocessing import get_context

from armdrive.registry import DIALECTS

from .laws import Broken
from .soak_judge import BETWEEN, PROCESS, WITHIN, judged, trend_kb
from .soak_work import Figures, Soak


def wrong_with(found: Sequence[Figures], *, lasting: bool = False) -> list[str]:
    """Return what is wrong with the figures of one arm."""
    in_use = [(each.hours, each.memory_kb) for each in found]
    process = [(each.hours, each.process_kb) for each in found]
    wrong = judged(in_use, WITHIN if lasting else BETWEEN) + judged(process, PROCESS)
    if any(each.drift_steps for each in found):
        wrong.append("it drifted")
    return wrong


def row(dialect: str, found: Sequence[Figures]) -> str:
    """Return a row of the table: the figures after the warm-up, and at the end."""
    first, last = found[0], found[-1]
    trend = trend_kb([(each.hours, each.memory_kb) for each in found])
    drift = max(each.drift_steps for each in found)
    return (
        f"| {dialect} | {last.hours:.1f} | {last.calls} | {last.refused} | {first.memory_kb:.0f} | "
        f"{last.memory_kb:.0f} | {trend:+.1f} | {first.process_kb / 1024:.1f} | "
        f"{last.process_kb / 1024:.1f} | {drift} | {last.took_s:.0f} |"
    )


HEAD = (
    "| dialect | hours | calls | refused | kB warm | kB at the end | trend, kB | "
    "process MB warm | at the end | drift, steps | took s |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|"
)


def soak(dialect: str, hours: float, *, lasting: bool = False) -> tuple[str, list[str]]:
    """Run one arm and print its figures; return its row, and what is wrong."""
    found: list[Figures] = []
    work = None
    try:
        work = Soak(dialect, lasting=lasting)
        for figures in work.work(hours):
            found.append(figures)
            sys.stdout.write(f"{dialect:12s}{figures}\n")
            sys.stdout.flush()
        wrong = wrong_with(found, lasting=lasting)
        if wrong:
            wrong.append(f"grown most: {work.grown()}")
    except Broken as law:
        wrong = [f"{law}, after {work.calls if work else 0} calls"]
    return row(dialect, found) if found else "", [f"{dialect}: {line}" for line in wrong]


def main(words: Sequence[str] | None = None) -> int:
    """Run the chosen arms, each in a process of its own; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaign.soak", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--hours", type=float, default=24.0)
    parser.add_argument("--dialect", action="append", choices=list(DIALECTS))
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time")
    parser.add_argument("--lasting", action="store_true", help="one program all the time")
    chosen = parser.parse_args(words)
    one = partial(soak, hours=chosen.hours, lasting=chosen.lasting)
    with get_context("spawn").Pool(chosen.jobs, maxtasksperchild=1) as pool:
        ended = list(pool.imap(one, chosen.dialect or DIALECTS, 1))
    wrong = [line for _, lines in ended for line in lines]
    table = [line for line, _ in ended if line]
    verdict = wrong or ["flat, no drift, no step lost"]
    sys.stdout.write("\n".join(["", HEAD, *table, "", *verdict]) + "\n")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
