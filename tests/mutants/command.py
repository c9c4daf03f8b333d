"""Apply deliberate faults to a copy of the project, one at a time; the tests must notice each.

    python -m tests.mutants
    python -m tests.mutants --only stop
    python -m tests.mutants --only "a stop is ignored" --everything

In the end, each test that noticed a fault runs without any: only if it passes then, its failure
meant something. The exit code is 1 if a mutant survives without an explanation in the table, or if
a row is broken.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack, closing
from pathlib import Path

from kinematics.text import counted

from .copies import HUNG, PACKAGES, PASSED, CopyError
from .mutant import Mutant
from .table import MUTANTS
from .trying import Copies, Trial, Verdict, try_all

ROOT = Path(__file__).parents[2]


def options(words: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutants", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="mutants at a time")
    parser.add_argument(
        "--only", default="", metavar="TEXT", help="mutants whose row has this text"
    )
    parser.add_argument("--list", action="store_true", help="list the mutants, and try none")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument(
        "--everything",
        action="store_true",
        help="run the whole test suite on a mutant that its own tests do not notice",
    )
    return parser.parse_args(words)


def main(
    words: Sequence[str] | None = None,
    *,
    mutants: Sequence[Mutant] = MUTANTS,
    root: Path = ROOT,
    packages: Sequence[str] = PACKAGES,
) -> int:
    """Try the chosen mutants; return the exit code."""
    chosen = options(words)
    wanted = [each for each in mutants if _has(each, chosen.only)]
    if not wanted:
        sys.stderr.write(f"no mutant has {chosen.only!r} in its name, promise or path\n")
        return 2
    if chosen.list:
        sys.stdout.write("".join(map(_listed, wanted)))
        return 0
    began_s = time.monotonic()
    with ExitStack() as opened:
        folder = opened.enter_context(tempfile.TemporaryDirectory(prefix="armdrive-mutants-"))
        try:
            copies = opened.enter_context(closing(Copies(root, Path(folder), packages)))
        except CopyError as error:
            sys.stderr.write(f"{error}\n")
            return 2
        trials = []
        jobs = max(chosen.jobs, 1)
        for trial in try_all(copies, wanted, jobs, everything=chosen.everything):
            trials.append(trial)
            if not chosen.json:
                sys.stdout.write(f"{trial}\n")
                sys.stdout.flush()
        if trouble := _fails_anyway(copies, trials, jobs):
            sys.stderr.write(f"without any mutant, these tests do not pass:\n{trouble}\n")
            return 2
    if chosen.json:
        sys.stdout.write(json.dumps(_document(trials), indent=1) + "\n")
    else:
        sys.stdout.write(f"{_total(trials)} in {time.monotonic() - began_s:.0f} s\n")
    return int(not all(trial.good for trial in trials))


def _has(mutant: Mutant, text: str) -> bool:
    return any(text in each for each in (mutant.name, mutant.promise, mutant.path))


def _listed(mutant: Mutant) -> str:
    why = f"    survives: {mutant.survives}\n" if mutant.survives else ""
    tests = "".join(f"    {test}\n" for test in mutant.tests)
    return f"{mutant.name}\n    breaks: {mutant.promise}\n    in {mutant.path}\n{tests}{why}"


def _fails_anyway(copies: Copies, trials: Sequence[Trial], jobs: int) -> str:
    """Return those of the tests that have killed a mutant which fail without one as well."""
    tests = sorted({trial.words for trial in trials if trial.verdict is Verdict.KILLED})
    tests = [test for test in tests if test != HUNG]
    if not tests:
        return ""
    run = copies.untouched.run_tests(tests, workers=jobs if jobs > 1 else 0, first=False)
    return "" if run.code == PASSED else "\n".join(run.failed) or run.words


def _total(trials: Sequence[Trial]) -> str:
    counts = {verdict: sum(each.verdict is verdict for each in trials) for verdict in Verdict}
    said = [f"{count} {verdict.value}" for verdict, count in counts.items() if count]
    return f"{counted(len(trials), 'mutant')}: {', '.join(said)}"


def _document(trials: Sequence[Trial]) -> list[dict[str, object]]:
    return [
        {
            "name": trial.mutant.name,
            "promise": trial.mutant.promise,
            "path": trial.mutant.path,
            "verdict": trial.verdict.name.lower(),
            "words": trial.words,
            "took_s": round(trial.took_s, 2),
        }
        for trial in trials
    ]
