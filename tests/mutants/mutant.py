"""A deliberate fault, and a context that applies it to a copy of the project."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Mutant:
    """A fault that breaks a promise, and the tests that notice it.

    `path` is a product file, `old` a text that occurs in it exactly once, `new` its replacement.
    `tests` are pytest node ids, as few and as quick as possible: at least one of them fails.
    `survives` is empty, or the reason why no everyday test can notice this fault.
    """

    name: str
    promise: str
    path: str
    old: str
    new: str
    tests: tuple[str, ...]
    survives: str = ""

    def mutated(self, text: str) -> str:
        """Return a file's text with the fault. Raises `ValueError` if the fault does not fit."""
        found = text.count(self.old)
        if found != 1:
            raise ValueError(
                f"{self.name!r}: its text occurs {found} times in {self.path}, not once: "
                "update the lines that it changes"
            )
        if self.old == self.new:
            raise ValueError(f"{self.name!r} changes nothing")
        return text.replace(self.old, self.new)


@contextmanager
def applied(mutant: Mutant, folder: Path, stamp: int) -> Iterator[None]:
    """Apply a fault to a copy of the project, and remove it at the end.

    `stamp` is the file's time in seconds, different for each mutant: Python compares the time and
    size of a cached module with its source, and two mutants of one size may follow in one second.
    """
    path = folder / mutant.path
    before, times = path.read_bytes(), path.stat()
    try:
        path.write_text(mutant.mutated(before.decode("utf-8")), encoding="utf-8")
        os.utime(path, (stamp, stamp))
        yield
    finally:
        path.write_bytes(before)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
