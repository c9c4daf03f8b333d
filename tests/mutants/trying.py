"""Runs the tests of mutants in copies of the project that have the fault, several in parallel."""

import shutil
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from .copies import FAILED, PASSED, Copy, Run, copy_project, module_of
from .mutant import Mutant, applied

ALL_OTHERS = "--ignore=tests/mutants"
"""All tests but those of the table, which would notice the changed text of the row."""
FIRST_STAMP = 1_000_000_000
"""The time of the first mutant's file in seconds: long before any real one."""


class Verdict(Enum):
    """The verdict on a mutant."""

    KILLED = "killed"
    SURVIVED = "SURVIVED"
    EXPLAINED = "survives, as explained"
    BROKEN = "BROKEN ROW"


@dataclass(frozen=True, slots=True)
class Trial:
    """The result of one mutant: the verdict, the killing test or other words, and the time."""

    mutant: Mutant
    verdict: Verdict
    words: str
    took_s: float

    @property
    def good(self) -> bool:
        """Whether the verdict is as the table says."""
        return self.verdict in (Verdict.KILLED, Verdict.EXPLAINED)

    def __str__(self) -> str:
        head = f"{self.mutant.name}: {self.verdict.value}"
        by = " by" if self.verdict is Verdict.KILLED else ":"
        return f"{head}{by if self.words else ''} {self.words} in {self.took_s:.1f} s"


class Copies:
    """Copies of one project for several workers.

    All are copied from the first one, with its compiled files.
    """

    def __init__(self, root: Path, folder: Path, packages: Sequence[str]) -> None:
        self._folder = folder
        self._packages = packages
        first = folder / "0"
        first.mkdir()
        copy_project(root, first)
        self.untouched = Copy(first, packages)  # never has a mutant
        self._made = [self.untouched]
        self._free: list[Copy] = []
        self._lock = threading.Lock()

    def close(self) -> None:
        """End the processes of all copies."""
        for copy in self._made:
            copy.close()

    @contextmanager
    def borrowed(self) -> Iterator[Copy]:
        """Lend a free copy, or make another one."""
        with self._lock:
            copy = self._free.pop() if self._free else self._new()
        try:
            yield copy
        finally:
            self._free.append(copy)

    def _new(self) -> Copy:
        folder = self._folder / str(len(self._made))
        shutil.copytree(self.untouched.folder, folder, symlinks=True)
        self._made.append(Copy(folder, self._packages))
        return self._made[-1]


def try_all(
    copies: Copies, mutants: Sequence[Mutant], jobs: int, *, everything: bool = False
) -> Iterator[Trial]:
    """Try mutants, several in parallel; yield each result when it is there."""
    with ThreadPoolExecutor(jobs) as pool:
        tried = [
            pool.submit(try_one, copies, mutant, FIRST_STAMP + number, everything=everything)
            for number, mutant in enumerate(mutants)
        ]
        for each in as_completed(tried):
            yield each.result()


def try_one(copies: Copies, mutant: Mutant, stamp: int, *, everything: bool = False) -> Trial:
    """Try one mutant. With `everything`, run the whole suite if its own tests all pass."""
    changed = module_of(mutant.path)
    try:
        with copies.borrowed() as copy, applied(mutant, copy.folder, stamp):
            run = copy.run_tests(mutant.tests, changed=changed)
            if run.code == PASSED and everything:
                run = copy.run_tests((ALL_OTHERS,), changed=changed)
    except ValueError as error:
        return Trial(mutant, Verdict.BROKEN, str(error), 0.0)
    return Trial(mutant, *_verdict(mutant, run), run.took_s)


def _verdict(mutant: Mutant, run: Run) -> tuple[Verdict, str]:
    """Return the verdict of a run, and why; only a test that ran and failed kills a mutant."""
    if run.code == FAILED and run.failed:
        if mutant.survives:
            return Verdict.BROKEN, f"{run.failed[0]} kills it: it survives no longer"
        return Verdict.KILLED, run.failed[0]
    if run.code == PASSED:
        if mutant.survives:
            return Verdict.EXPLAINED, mutant.survives
        return Verdict.SURVIVED, mutant.promise
    return Verdict.BROKEN, f"pytest ended with {run.code}: {run.words[-600:].strip()}"
