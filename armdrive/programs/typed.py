"""The lines that were typed at a prompt, and how what is wrong with them is shown."""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.errors import ProgramError
from armdrive.programs.acts import Mark
from armdrive.programs.problems import MOST_TOLD, Problem, pointed


class Typed:
    """All lines, by the name of their text, as marks have it, and their numbers.

    `title` is the input's name where its lines are counted, as those of a pipe are. At a terminal,
    where people see what they typed last, that is shown without its place.
    """

    def __init__(self, title: str = "") -> None:
        self.title = title
        self._lines: dict[str, dict[int, str]] = {}
        self._latest = ""
        self._before = 0

    def add(self, name: str, lines: Sequence[str], begin: int = 1, before: int = 0) -> None:
        """Take lines; the first is number `begin`, and so many signs were put before it."""
        self._lines.setdefault(name, {}).update(enumerate(lines, begin))
        self._latest, self._before = name, before

    def shown(self, error: ProgramError) -> ProgramError:
        """Return an error with the lines as they were typed."""
        return self.error(error.problems) if error.problems else error

    def error(self, problems: Sequence[Problem]) -> ProgramError:
        """Return the error that tells of problems, at least one."""
        texts = [self._pointed(each) for each in problems[:MOST_TOLD]]
        if len(problems) > MOST_TOLD:
            texts.append(f"and {len(problems) - MOST_TOLD} more")
        mark = self._typed(problems[0].mark)
        return ProgramError("\n".join(texts), mark=mark, problems=tuple(problems))

    def line_at(self, mark: Mark) -> str:
        """Return the line that a mark points at; nothing where there is none."""
        return self._lines.get(mark.file, {}).get(mark.line, "")

    def _typed(self, mark: Mark) -> Mark:
        before = self._before if mark.file == self._latest else 0
        return Mark(mark.line, max(mark.column - before, 1), mark.file)

    def _pointed(self, problem: Problem) -> str:
        """Return what is wrong, the line, and a caret under the place."""
        mark, line = self._typed(problem.mark), self.line_at(problem.mark)
        alone = Mark(1, mark.column)
        told = pointed(Problem(alone, problem.text), [line] if line else [])
        told = told.removeprefix(f"{alone}: ")
        seen = mark.file == self._latest and not self.title
        return told if seen else f"{mark}: {told}"
