"""One finding: how grave it is, what was found, and what mends it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum


class Grade(Enum):
    """How grave a finding is."""

    OK = "ok"
    NOTE = "note"
    PROBLEM = "problem"


@dataclass(frozen=True, slots=True)
class Finding:
    """What was found, as a sentence, and what mends it: a line to type, or a sentence."""

    grade: Grade
    what: str
    mend: str = ""

    def view(self) -> dict[str, str]:
        """Return it as plain data."""
        return {"grade": self.grade.value, "what": self.what, "mend": self.mend}


def ok(what: str) -> Finding:
    """Return a finding that is as it should be."""
    return Finding(Grade.OK, what)


def note(what: str, mend: str = "") -> Finding:
    """Return a finding that is worth knowing."""
    return Finding(Grade.NOTE, what, mend)


def problem(what: str, mend: str) -> Finding:
    """Return a finding that has to be mended."""
    return Finding(Grade.PROBLEM, what, mend)


def any_problem(findings: Iterable[Finding]) -> bool:
    """Tell whether something has to be mended."""
    return any(each.grade is Grade.PROBLEM for each in findings)
