"""Problems of a program, and how they are shown: the line, and a caret under the place."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from armdrive.errors import ArmError
from armdrive.errors.printable import printable

# The most characters of a line that are shown.
EXCERPT = 200

# The most problems of a program that are shown: more are consequences of the first.
MOST_SHOWN = 20


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


def mark_of(error: BaseException, otherwise: SourceMark | None) -> SourceMark | None:
    """Return the place of an error; `otherwise` if the error does not say it."""
    mark = error.mark if isinstance(error, ProgramError) else None
    return mark or otherwise


# The lines of programs, by their file and number.
SourceLines: TypeAlias = Mapping[tuple[str, int], str]


def numbered_lines(lines: Iterable[str], file: str = "", first: int = 1) -> SourceLines:
    """Return lines by their file and number."""
    return {(file, number): line for number, line in enumerate(lines, first)}


def pointed(problem: Problem, lines: SourceLines, near: str | None = None) -> str:
    """Return the text of a problem, its line, and a caret under the place.

    `near` is the file that a person has before their eyes: a place there is not named.
    """
    mark = problem.mark
    line = lines.get((mark.file, mark.line))
    text = problem.text if mark.file == near else f"{mark}: {problem.text}"
    return text if line is None else f"{text}\n{excerpt(line, mark.column)}"


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


def program_error(
    problems: Iterable[Problem], lines: SourceLines, near: str | None = None
) -> ProgramError:
    """Return the error with these problems of a program, in the order of its lines."""
    found = tuple(sorted(set(problems), key=lambda each: (each.mark.line, each.mark.column)))
    shown = [pointed(each, lines, near) for each in found[:MOST_SHOWN]]
    more = len(found) - MOST_SHOWN
    message = "\n".join(shown + [f"and {more} more"] * (more > 0))
    return ProgramError(message, mark=found[0].mark, problems=found)
