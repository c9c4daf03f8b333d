"""The entries at a prompt. Each entry is a program that knows the entries before it.

A session is pure: it reads and remembers; shell.py carries out. An entry is a line or a whole
block. The entries that were carried out form a program, which can be listed and saved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from armdrive.programs.language.grammar import LineMistake, ProgramReader
from armdrive.programs.language.syntax import Call, Define, Statement, Tree, every
from armdrive.programs.problems import numbered_lines
from armdrive.programs.program import Context, Machine, Program, checked_program


@dataclass(frozen=True, slots=True)
class KeptEntry:
    """An entry that was carried out, as it was typed, and the subprograms that it defines."""

    text: str
    defines: frozenset[str]


class Session:
    """The entries of a prompt so far.

    `title` is the name of an input whose lines are counted, such as a pipe; without it, a person
    types. `kept` are the entries carried out.
    """

    def __init__(self, title: str = "") -> None:
        self.context = Context()
        self.title = title
        self.kept: list[KeptEntry] = []
        self._number = 1
        self._lines: list[str] = []
        self._begin = 1
        self._reader = ProgramReader()

    # -- reading ------------------------------------------------------------------------------

    @property
    def unfinished(self) -> bool:
        """Whether a block is still without its end."""
        return bool(self._lines)

    def take(self, line: str, position: int = 1) -> Program | None:
        """Take the next line; return the entry that it completes, if it does.

        `position` is the line's number in the input. An unreadable line is not taken. Raises
        `ProgramError`.
        """
        if not self._lines:
            self._begin = position if self.title else 1
            self._reader = ProgramReader(self._file)
        try:
            self._reader.take(line, self._begin + len(self._lines))
        except LineMistake as mistake:
            raise self._draft([*self._lines, line]).error([mistake.problem]) from None
        self._lines.append(line)
        return None if self._reader.unfinished else self._finished()

    def abandon(self) -> None:
        """Forget the lines of an unfinished block."""
        self._lines = []

    def end(self) -> None:
        """End the input. Raises `ProgramError` for an unfinished block."""
        if self._lines:
            self._finished()

    def _finished(self) -> Program | None:
        """Return the entry of the lines typed; None if there is nothing in them."""
        lines = self._lines
        self.abandon()
        tree, problems = self._reader.finish()
        if not any(each.strip() for each in lines):
            return None
        # a subprogram that is not called may name points that have been deleted since
        known = replace(self.context, defines=_needed(tree, self.context))
        return checked_program(replace(self._draft(lines), tree=tree, context=known), problems)

    def _draft(self, lines: Sequence[str]) -> Program:
        """Return lines as a program that has not been read."""
        known = {**self.context.lines, **numbered_lines(lines, self._file, self._begin)}
        text, near = "\n".join(lines), not self.title
        return Program(text, self._file, Tree(()), context=self.context, lines=known, near=near)

    @property
    def _file(self) -> str:
        return self.title or f"entry {self._number}"

    # -- remembering --------------------------------------------------------------------------

    def learn(self, entry: Program, machine: Machine, *, done: bool) -> None:
        """Learn the names that an entry has set so far; keep its lines if it came to its end."""
        own = entry.tree.defines
        defines = self.context.but(own) if done else self.context.defines
        self.context = replace(machine.context, defines=defines)
        if not done or machine.ended_by_stop:
            return  # a `stop` would end the program of all entries as well
        names = frozenset(define.name.lower() for define in own)
        self.kept = [each for each in self.kept if not each.defines & names]
        self.kept.append(KeptEntry(entry.text, names))
        self._number += 1

    @property
    def text(self) -> str:
        """The program of all that was carried out."""
        return "".join(f"{each.text}\n" for each in self.kept)


def _needed(tree: Tree, known: Context) -> tuple[Define, ...]:
    """Return the known subprograms that a program calls and does not replace."""
    there = {define.name.lower(): define for define in known.defines}
    for line in tree.defines:
        there.pop(line.name.lower(), None)
    waiting, found = [*tree.body], dict[str, Define]()
    while waiting:
        for name in _called(waiting.pop()):
            if name in there and name not in found:
                found[name] = there[name]
                waiting.append(there[name])
    return tuple(found.values())


def _called(line: Statement) -> list[str]:
    return [each.name.lower() for each in every((line,)) if isinstance(each, Call)]
