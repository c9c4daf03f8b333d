"""What is wrong with a program, and how a person is told: the line, and a caret under the place."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from armdrive.errors import ArmError
from armdrive.errors.printable import printable

EXCERPT = 200
"""Characters of a long line that are shown."""

MOST_TOLD = 20
"""So many problems of one program are told at once: more are the echo of the first."""


@dataclass(frozen=True, slots=True)
class SourceMark:
    """Where in a program something stands: line and column count from 1. `file` may be empty."""

    line: int
    column: int = 1
    file: str = ""

    def __str__(self) -> str:
        where = f"line {self.line}, column {self.column}"
        return f"{self.file}: {where}" if self.file else where


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong with a program, where it stands."""

    mark: SourceMark
    text: str


class ProgramError(ArmError):
    """A program that cannot be read, or a line of it that cannot be carried out.

    `mark` is the first place that is wrong, None where no place is; `problems` are all of them.
    The message has the lines, with a caret under the place.
    """

    exit_code = 2
    code = "E113"

    def __init__(
        self, message: str, *, mark: SourceMark | None = None, problems: tuple[Problem, ...] = ()
    ) -> None:
        self.mark = mark
        self.problems = problems
        super().__init__(message)


def lines_of(text: str) -> list[str]:
    """Return the lines of a text, however its lines end."""
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n").split("\n")


def pointed(problem: Problem, lines: list[str], file: str | None = None) -> str:
    """Return what is wrong, the line, and a caret under the place.

    The lines are those of `file`: what stands in another is told without its line.
    """
    mark = problem.mark
    if not 1 <= mark.line <= len(lines) or file not in (None, mark.file):
        return f"{mark}: {problem.text}"
    return f"{mark}: {problem.text}\n{excerpt(lines[mark.line - 1], mark.column)}"


def excerpt(line: str, column: int) -> str:
    """Return a line of a program, and a caret under the place; columns count from 1.

    What is not printable is shown as its escape, a tab as a space. Of a long line only the part
    around the place is shown.
    """
    at = column - 1
    first = max(0, min(at, len(line)) - EXCERPT // 2)
    part = line[first : first + EXCERPT].replace("\t", " ")
    before, behind = printable(part[: at - first]), printable(part[at - first :])
    more, rest = "..." * (first > 0), "..." * (first + EXCERPT < len(line))
    caret = " " * (len(more) + len(before) + max(at - len(line), 0))
    return f"    {more}{before}{behind}{rest}\n    {caret}^"


def program_error(problems: Iterable[Problem], text: str, file: str | None = None) -> ProgramError:
    """Return the error that tells of these problems of a program, in the order of its lines."""
    found = tuple(sorted(set(problems), key=lambda each: (each.mark.line, each.mark.column)))
    lines = lines_of(text)
    told = tell_all(found, lambda each: pointed(each, lines, file))
    return ProgramError(told, mark=found[0].mark, problems=found)


def tell_all(problems: Sequence[Problem], point: Callable[[Problem], str]) -> str:
    """Return what is wrong with a program, as much as a person may want to read at once."""
    told = [point(each) for each in problems[:MOST_TOLD]]
    more = len(problems) - MOST_TOLD
    return "\n".join(told + [f"and {more} more"] * (more > 0))
