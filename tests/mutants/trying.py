"""Whether tests notice a mutant: run in a copy that has it, several copies side by side."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from queue import SimpleQueue

from .copies import FAILED, PASSED, Copy, Run, copy_project
from .mutant import Mutant, applied

ALL_OTHERS = "--ignore=tests/mutants"
"""All tests but those of the table, which notice that a row's text is no longer there."""
FIRST_STAMP = 1_000_000_000
"""Files of mutants have times from here on, in seconds: long before any real one."""


class Verdict(Enum):
    """What became of a mutant."""

    KILLED = "killed"
    SURVIVED = "SURVIVED"
    EXPLAINED = "survives, as explained"
    BROKEN = "BROKEN ROW"


@dataclass(frozen=True, slots=True)
class Trial:
    """One mutant tried: by which test it was killed, or what else there is to say, and its time."""

    mutant: Mutant
    verdict: Verdict
    words: str
    took_s: float

    @property
    def good(self) -> bool:
        """Tell whether this is as the table says."""
        return self.verdict in (Verdict.KILLED, Verdict.EXPLAINED)

    def __str__(self) -> str:
        head = f"{self.mutant.name}: {self.verdict.value}"
        by = " by" if self.verdict is Verdict.KILLED else ":"
        return f"{head}{by if self.words else ''} {self.words} in {self.took_s:.1f} s"


class Copies:
    """Copies of one project for several workers; the first is made, the others copied from it.

    What was compiled in the first one comes along.
    """

    def __init__(self, root: Path, folder: Path, packages: Sequence[str]) -> None:
        self._folder = folder
        self._packages = packages
        first = folder / "0"
        first.mkdir()
        copy_project(root, first)
        self.untouched = Copy(first, packages)  # never has a mutant
        self._made = [self.untouched]
        self._free: SimpleQueue[Copy] = SimpleQueue()
        self._lock = threading.Lock()

    def close(self) -> None:
        """End the processes of all copies."""
        for copy in self._made:
            copy.close()

    def take(self) -> Copy:
        """Return a copy of one's own, to be given `back`."""
        with self._lock:
            if not self._free.empty():
                return self._free.get()
            folder = self._folder / str(len(self._made))
            shutil.copytree(self.untouched.folder, folder, symlinks=True)
            self._made.append(Copy(folder, self._packages))
            return self._made[-1]

    def back(self, copy: Copy) -> None:
        """Give a copy to whoever needs one next."""
        self._free.put(copy)


def try_all(
    copies: Copies, mutants: Sequence[Mutant], jobs: int, *, everything: bool = False
) -> Iterator[Trial]:
    """Try mutants, several side by side; gives each as it is done."""
    with ThreadPoolExecutor(jobs) as pool:
        tried = [
            pool.submit(try_one, copies, mutant, FIRST_STAMP + number, everything=everything)
            for number, mutant in enumerate(mutants)
        ]
        for each in as_completed(tried):
            yield each.result()


def try_one(copies: Copies, mutant: Mutant, stamp: int, *, everything: bool = False) -> Trial:
    """Try one mutant. With `everything` the whole suite is tried where its own tests all pass."""
    copy = copies.take()
    try:
        with applied(mutant, copy.folder, stamp):
            run = copy.run_tests(mutant.tests)
            if run.code == PASSED and everything:
                run = copy.run_tests((ALL_OTHERS,))
    except ValueError as error:
        return Trial(mutant, Verdict.BROKEN, str(error), 0.0)
    finally:
        copies.back(copy)
    return _judged(mutant, run)


def _judged(mutant: Mutant, run: Run) -> Trial:
    """Say what a run means; only a test that was run and failed kills a mutant."""
    trial = _told_to(mutant, run.took_s)
    if run.code == FAILED and run.failed:
        if mutant.survives:
            return trial(Verdict.BROKEN, f"{run.failed[0]} kills it: it survives no longer")
        return trial(Verdict.KILLED, run.failed[0])
    if run.code == PASSED:
        if mutant.survives:
            return trial(Verdict.EXPLAINED, mutant.survives)
        return trial(Verdict.SURVIVED, mutant.promise)
    return trial(Verdict.BROKEN, f"pytest ended with {run.code}: {run.words[-600:].strip()}")


def _told_to(mutant: Mutant, took_s: float) -> Callable[[Verdict, str], Trial]:
    return lambda verdict, words: Trial(mutant, verdict, words, took_s)
