"""The lines of a program that runs, with the current one lit."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from armdrive.errors import ArmError, BadRequest
from armdrive.text.reading import read_text
from tui.conduct import View
from tui.painting import Span

CURRENT_STYLE = "bold reverse $primary"
DONE_STYLE = "dim"
LINES_SHOWN = 12


def lit_lines(lines: Sequence[str], at: int, height: int = LINES_SHOWN) -> list[Span]:
    """Return the lines around the current one, which has a sign and is lit; `at` counts from 0."""
    first = max(min(at - height // 2, len(lines) - height), 0)
    return [
        (f"{'>' if number == at else ' '}{number + 1:>4}  {line}", _style(number, at))
        for number, line in enumerate(lines[first : first + height], first)
    ]


def _style(number: int, at: int) -> str:
    return CURRENT_STYLE if number == at else DONE_STYLE if number < at else ""


class WatchedProgram:
    """The program that another process runs, read from its file where that can be read here."""

    def __init__(self) -> None:
        self._file = ""
        self._lines: tuple[str, ...] = ()

    def lines(self, program: object, height: int = LINES_SHOWN) -> list[Span]:
        """Return its lines with the current one lit; only that one where the file is not here."""
        if not isinstance(program, dict) or not program.get("line"):
            return []
        at = int(program["line"]) - 1
        self._read(program)
        if 0 <= at < len(self._lines):
            return lit_lines(self._lines, at, height)
        return [(f">{at + 1:>4}  {program.get('text') or program.get('act') or ''}", CURRENT_STYLE)]

    def _read(self, program: View) -> None:
        file = str(program.get("file", ""))
        if file == self._file:
            return
        self._file = file
        try:
            self._lines = tuple(read_text(Path(file), "the program", BadRequest).splitlines())
        except (ArmError, OSError):
            self._lines = ()
