"""Problems of a program, and how they are shown: the line, and a caret under the place."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from armdrive.errors import ArmError
from armdrive.errors.printable import printable

EXCERPT = 200
"""The most characters of a line that are shown."""

MOST_SHOWN = 20
"""The most problems of a program that are shown: more are consequences of the first."""


@dataclass(frozen=True, slots=True)
class SourceMark:
    """A place in a program: line and column count from 1. `file` may be empty."""

    line: int
    column: int = 1
    file: str = ""

    def __str__(self) -> str:
        where = f"line {self.line}, column {self.column}"
        return f"{self.file}: {where}" if self.file else where


@dataclass(frozen=True, slots=True)
class Problem:
    """One problem of a program, and its place."""

    mark: SourceMark
    text: str


class ProgramError(ArmError):
    """A program that cannot be read, or a line of it that cannot be carried out.

    `problems` are all problems and `mark` is the place of the first, None if it has no place. The
    message shows the lines, with a caret under each place.
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
    """Return the lines of a text with any kind of line breaks."""
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n").split("\n")


def pointed(problem: Problem, lines: list[str], file: str | None = None) -> str:
    """Return the text of a problem, its line, and a caret under the place.

    The lines are those of `file`; a problem in another file is shown without its line.
    """
    mark = problem.mark
    if not 1 <= mark.line <= len(lines) or file not in (None, mark.file):
        return f"{mark}: {problem.text}"
    return f"{mark}: {problem.text}\n{excerpt(lines[mark.line - 1], mark.column)}"


def excerpt(line: str, column: int) -> str:
    """Return a line of a program, and a caret under the place; columns count from 1.

    Characters that are not printable are shown as escapes, tabs as spaces. Of a long line only the
    part around the place is shown.
    """
    at = column - 1
    first = max(0, min(at, len(line)) - EXCERPT // 2)
    part = line[first : first + EXCERPT].replace("\t", " ")
    before, behind = printable(part[: at - first]), printable(part[at - first :])
    more, rest = "..." * (first > 0), "..." * (first + EXCERPT < len(line))
    caret = " " * (len(more) + len(before) + max(at - len(line), 0))
    return f"    {more}{before}{behind}{rest}\n    {caret}^"


def program_error(problems: Iterable[Problem], text: str, file: str | None = None) -> ProgramError:
    """Return the error with these problems of a program, in the order of its lines."""
    found = tuple(sorted(set(problems), key=lambda each: (each.mark.line, each.mark.column)))
    lines = lines_of(text)
    message = all_shown(found, lambda each: pointed(each, lines, file))
    return ProgramError(message, mark=found[0].mark, problems=found)


def all_shown(problems: Sequence[Problem], point: Callable[[Problem], str]) -> str:
    """Return the first problems of a program as text, and the number of the others."""
    shown = [point(each) for each in problems[:MOST_SHOWN]]
    more = len(problems) - MOST_SHOWN
    return "\n".join(shown + [f"and {more} more"] * (more > 0))
