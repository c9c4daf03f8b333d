"""The lines of a program, with the one that runs lit: one panel for the desk and for watching."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from armdrive.errors import ArmError, BadRequest
from armdrive.text.reading import read_text
from tui.safety import View
from tui.widgets import PlainText, Span

CURRENT_STYLE = "bold reverse $primary"
DONE_STYLE = "dim"
WRONG_STYLE = "bold $error"
LINES_SHOWN = 12


@dataclass(frozen=True, slots=True)
class LinesToShow:
    """Lines of a program. `current` and `wrong` count from 1, as people count lines.

    `current` is the line that runs, if any; `wrong` are lines with mistakes. `first` is the number
    of the first of these lines. Without a current line, the lines are shown from `top` on.
    """

    lines: Sequence[str] = ()
    current: int | None = None
    wrong: Collection[int] = ()
    first: int = 1
    top: int = 0

    def spans(self, height: int) -> list[Span]:
        """Return as many lines as fit: about the current one, else from `top` on."""
        before = self.top if self.current is None else self.current - self.first - height // 2
        begin = max(min(before, len(self.lines) - height), 0)
        shown = self.lines[begin : begin + height]
        return [self._span(number, line) for number, line in enumerate(shown, begin + self.first)]

    def _span(self, number: int, line: str) -> Span:
        if number == self.current:
            mark, style = ">", WRONG_STYLE if number in self.wrong else CURRENT_STYLE
        elif number in self.wrong:
            mark, style = "!", WRONG_STYLE
        else:
            done = self.current is not None and number < self.current
            mark, style = " ", DONE_STYLE if done else ""
        return f"{mark}{number:>4}  {line}", style


class ProgramLines(PlainText):
    """A panel of program lines, hidden while there are none.

    It shows `rows` lines; without that number, as many as the panel has room for.
    """

    def __init__(self, *, id: str, rows: int | None = None) -> None:  # noqa: A002
        super().__init__(id=id, classes="panel")
        self._rows = rows
        self._program = LinesToShow()

    def show_program(self, program: LinesToShow) -> None:
        """Show these lines from now on."""
        self._program = program
        self.display = bool(program.lines)
        self._fill()

    def on_resize(self) -> None:
        """Show as many lines as fit now."""
        self._fill()

    def _fill(self) -> None:
        self.show_lines(self._program.spans(self._rows or self.content_size.height))


class WatchedProgram:
    """The program that another process runs, read from its file where that can be read here."""

    def __init__(self) -> None:
        self._file = ""
        self._lines: tuple[str, ...] = ()

    def lines(self, program: object) -> LinesToShow:
        """Return its lines; only the current one if the file cannot be read here."""
        if not isinstance(program, dict) or not program.get("line"):
            return LinesToShow()
        current = int(program["line"])
        self._read(program)
        if 1 <= current <= len(self._lines):
            return LinesToShow(self._lines, current)
        line = str(program.get("text") or program.get("act") or "")
        return LinesToShow((line,), current, first=current)

    def _read(self, program: View) -> None:
        file = str(program.get("file", ""))
        if file == self._file:
            return
        self._file = file
        try:
            self._lines = tuple(read_text(Path(file), "the program", BadRequest).splitlines())
        except (ArmError, OSError):
            self._lines = ()
