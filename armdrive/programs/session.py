"""The entries at a prompt. Each entry is a program that knows the entries before it.

A session is pure: it reads and remembers; shell.py carries out. An entry is a line, a whole block,
or values alone, which are shown. The entries that were carried out form a program, which can be
listed and saved.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from armdrive.errors import BadRequest
from armdrive.programs.language.compiling import NO_CODE
from armdrive.programs.language.grammar import LineMistake, ProgramReader, read_values
from armdrive.programs.language.syntax import (
    NAME,
    Assign,
    Call,
    Define,
    Do,
    Expression,
    Name,
    Statement,
    Tree,
    Use,
    every,
    within,
)
from armdrive.programs.language.words import FUNCTIONS, HERE, OPERATORS, RESERVED
from armdrive.programs.language.writing import unparse
from armdrive.programs.problems import Problem, numbered_lines
from armdrive.programs.program import (
    Context,
    Machine,
    Program,
    checked_program,
)

# Values that only an arm can give.
OF_THE_ARM = (HERE, "input")

# `width = 3` names a value; it could also be read as a comparison.
_NAMING = re.compile(r"\s*\w+\s*=(?!=)")


@dataclass(frozen=True, slots=True)
class PromptEntry:
    """One entry that was read and checked; `says` if it only shows values."""

    program: Program
    says: bool = False


class Session:
    """The entries of a prompt so far.

    `title` is the name of an input whose lines are counted, such as a pipe; without it, a person
    types. `book` has the names of the points in the arm's book. `kept` has the lines carried out,
    by the numbers of their entries.
    """

    def __init__(self, title: str = "") -> None:
        self.context = Context()
        self.title = title
        self.book: frozenset[str] = frozenset()
        self.kept: dict[int, tuple[Statement, ...]] = {}
        self.number = 1
        self._lines: list[str] = []
        self._begin = 1
        self._reader = ProgramReader()

    # -- reading ------------------------------------------------------------------------------

    @property
    def unfinished(self) -> bool:
        """Whether a block is still without its end."""
        return bool(self._lines)

    def take(self, line: str, position: int = 1) -> PromptEntry | None:
        """Take the next line; return the entry that it completes, if it does.

        `position` is the line's number in the input. An unreadable line is not taken. Raises
        `ProgramError`.
        """
        wrong = None
        if not self._lines:
            self._begin = position if self.title else 1
            self._reader = ProgramReader(self._file)
            try:
                values = read_values(line, self._begin, self._file)
                if self._meant(values, line):
                    say = Do("type", values, mark=values[0].mark)
                    return PromptEntry(self._checked(Tree((say,)), [line]), says=True)
            except LineMistake as mistake:
                wrong = mistake if self._like_values(line) else None
        try:
            self._reader.take(line, self._begin + len(self._lines))
        except LineMistake as mistake:
            raise self._draft([*self._lines, line]).error([(wrong or mistake).problem]) from None
        self._lines.append(line)
        return None if self._reader.open_blocks else self._finished()

    def abandon(self) -> None:
        """Forget the lines of an unfinished block."""
        self._lines = []

    def end(self) -> None:
        """End the input. Raises `ProgramError` for an unfinished block."""
        if self._lines:
            self._finished()

    def load(self, program: Program, name: str) -> PromptEntry:
        """Return the subprograms and values of another program as an entry.

        Lines that move, wait, or ask the arm are left out. Raises `ProgramError`.
        """
        body = tuple(line for line in program.tree.body if _given(line))
        if not body:
            raise BadRequest(f"{name} has no subprograms, points or values to take")
        tree, lines = Tree(body), {**self.context.lines, **program.lines}
        known = replace(self.context, defines=_needed(tree, self.context))
        return PromptEntry(checked_program(replace(program, tree=tree, context=known, lines=lines)))

    def _finished(self) -> PromptEntry | None:
        """Return the entry of the lines typed; None if there is nothing in them."""
        lines = self._lines
        self.abandon()
        tree, problems = self._reader.finish()
        if not any(each.strip() for each in lines):
            return None
        return PromptEntry(self._checked(tree, lines, problems))

    def _checked(
        self, tree: Tree, lines: Sequence[str], problems: Iterable[Problem] = ()
    ) -> Program:
        # a subprogram that is not called may name points that have been deleted since
        known = replace(self.context, defines=_needed(tree, self.context))
        return checked_program(replace(self._draft(lines), tree=tree, context=known), problems)

    def _draft(self, lines: Sequence[str]) -> Program:
        """Return lines as a program that has not been read."""
        known = {**self.context.lines, **numbered_lines(lines, self._file, self._begin)}
        text, near = "\n".join(lines), not self.title
        return Program(text, self._file, Tree(()), NO_CODE, self.context, known, near)

    def _meant(self, values: tuple[Expression, ...], line: str) -> bool:
        """Return whether a line is meant as values, if it could also be a statement."""
        match values:
            case (Name(name=name),):
                return self._has_value(name)
            case (Use(name=name),) if name not in OPERATORS and not name.startswith("."):
                return name in FUNCTIONS  # otherwise it may be the call of a subprogram
            case _:
                return _NAMING.match(line) is None

    def _has_value(self, name: str) -> bool:
        low = name.lower()
        if low in RESERVED or any(low == each.name.lower() for each in self.context.defines):
            return low == HERE
        return low in self.context.variables or low in map(str.lower, self.book)

    def _like_values(self, line: str) -> bool:
        """Return whether an unreadable line is meant to be values, such as `width +`."""
        first = NAME.match(line.lstrip())
        return first is None or self._has_value(first[0]) or first[0].lower() in FUNCTIONS

    @property
    def _file(self) -> str:
        return self.title or f"entry {self.number}"

    # -- remembering --------------------------------------------------------------------------

    def learn(self, entry: PromptEntry, machine: Machine, *, done: bool) -> None:
        """Learn the names that an entry has set so far; keep its lines if it came to its end."""
        body = entry.program.tree.body
        own = tuple(line for line in body if isinstance(line, Define))
        defines = self.context.but(own) if done else self.context.defines
        self.context = replace(machine.context, defines=defines)
        if not done or entry.says or machine.ended_by_stop:
            return  # a `stop` would end the program of all entries as well
        replaced = {line.name.lower() for line in own}
        left = {
            number: tuple(line for line in lines if not _defines(line, replaced))
            for number, lines in self.kept.items()
        }
        self.kept = {number: lines for number, lines in left.items() if lines}
        self.kept[self.number] = body
        self.number += 1

    def drop(self, number: str) -> None:
        """Remove an entry from the program. Raises `BadRequest` for an unknown number."""
        listed = {str(each): each for each in self.kept}
        if number not in listed:
            raise BadRequest(
                f"there is no entry {number!r}: write it like `drop 3`, with a number that "
                "`list` shows"
            )
        del self.kept[listed[number]]

    @property
    def text(self) -> str:
        """The program of all that was carried out."""
        return unparse(Tree(tuple(line for lines in self.kept.values() for line in lines)))


def _needed(tree: Tree, known: Context) -> tuple[Define, ...]:
    """Return the known subprograms that a program calls and does not replace."""
    there = {define.name.lower(): define for define in known.defines}
    for line in tree.body:
        if isinstance(line, Define):
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


def _defines(line: Statement, names: set[str]) -> bool:
    return isinstance(line, Define) and line.name.lower() in names


def _given(line: Statement) -> bool:
    """Return whether a line only defines a name, without asking the arm."""
    if isinstance(line, Assign):
        return not any(
            isinstance(each, Name | Use) and each.name.lower() in OF_THE_ARM
            for each in within(line.value)
        )
    return isinstance(line, Define)
