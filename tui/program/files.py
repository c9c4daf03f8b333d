"""The program files that can be run, and the chosen one as it was read and checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from armdrive.config.arm import ArmConfig
from armdrive.errors import ArmError, BadRequest
from armdrive.errors.printable import reason_of
from armdrive.programs.problems import ProgramError, lines_of
from armdrive.programs.program import ENDING, ArmProgram, Program, read_program
from armdrive.storage.files import stamp_of
from armdrive.text.reading import read_text
from tui.desk import Desk


@dataclass(frozen=True, slots=True)
class CheckedProgram:
    """A program file as it was read. `error` says what is wrong, in the lines `wrong` (from 1)."""

    path: Path
    lines: tuple[str, ...] = ()
    program: Program | None = None
    error: str = ""
    wrong: frozenset[int] = frozenset()


def check_file(path: Path, config: ArmConfig) -> CheckedProgram:
    """Read a program file, and check it for this arm and its points."""
    lines: tuple[str, ...] = ()
    try:
        text = read_text(path, "the program", BadRequest)
        lines = tuple(lines_of(text.rstrip("\r\n")))
        program = read_program(text, str(path))
        ArmProgram(program, config).machine()  # raises for a point that this arm does not have
    except ProgramError as error:
        wrong = frozenset(each.mark.line for each in error.problems)
        return CheckedProgram(path, lines, None, str(error), wrong)
    except ArmError as error:
        return CheckedProgram(path, lines, None, str(error))
    return CheckedProgram(path, lines, program)


class ProgramFiles:
    """Lists the programs of a folder, and reads the chosen one again whenever it has changed."""

    def __init__(
        self, desk: Desk, folder: Path, named: Path | None, changed: Callable[[], None]
    ) -> None:
        """`named` is chosen at first. `changed` is called when another program is shown."""
        self.folder = folder
        self.paths: tuple[Path, ...] = ()
        self.checked: CheckedProgram | None = None
        """The chosen program; None until it has been read."""
        self._desk = desk
        self._named = named
        self._chosen = named
        self._changed = changed
        self._read_as: object = None
        self._reading = False

    @property
    def at(self) -> int:
        """The chosen row; the first one if the chosen file is gone."""
        return self.paths.index(self._chosen) if self._chosen in self.paths else 0

    @property
    def chosen(self) -> Path | None:
        """The chosen file; None if there is no program file."""
        return self.paths[self.at] if self.paths else None

    def look(self) -> None:
        """List the files again."""
        try:
            found = sorted(each for each in self.folder.iterdir() if each.suffix == ENDING)
        except OSError as error:
            self._desk.message = f"{self.folder} cannot be read: {reason_of(error)}"
            found = []
        named = [] if self._named is None or self._named in found else [self._named]
        self.paths = (*named, *found)

    def choose(self, row: int) -> None:
        """Choose a row; after the last one comes the first."""
        if self.paths:
            self._chosen = self.paths[row % len(self.paths)]
            self.follow()

    def follow(self) -> None:
        """Read the chosen file in a thread if it, or the arm's points, have changed."""
        path = self.chosen
        stamp = None if path is None else (path, stamp_of(path), self._desk.arm.points.stamp)
        if self._reading or stamp == self._read_as:
            return
        self._read_as = stamp
        self._changed()
        self.checked = None
        if path is not None:
            self._reading = True
            work = partial(check_file, path, self._desk.arm.config)
            self._desk.calls.work_out(work, self._keep)

    def _keep(self, checked: CheckedProgram | None) -> bool:
        self._reading = False
        if checked is not None and checked.path == self.chosen:
            self.checked = checked
        return True
