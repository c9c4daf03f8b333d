"""The entries at a prompt. Each entry is a program that knows the entries before it.

A session is pure: it reads and remembers; shell.py carries out. An entry is a line, a whole block,
or values alone, which are shown. The entries that were carried out form a program, which can be
listed and saved.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

from armdrive.errors import BadRequest
from armdrive.programs.language.grammar import LineMistake, ProgramReader, read_values
from armdrive.programs.language.syntax import (
    NAME,
    Assign,
    Call,
    Define,
    Do,
    Label,
    Name,
    Statement,
    Tree,
    Use,
    every,
    within,
)
from armdrive.programs.language.words import FUNCTIONS, HERE, RESERVED
from armdrive.programs.problems import Problem, numbered_lines
from armdrive.programs.program import (
    Context,
    Machine,
    Program,
    checked_program,
)

# Values that only an arm can give.
OF_THE_ARM = (HERE, "input")


@dataclass(frozen=True, slots=True)
class PromptEntry:
    """One entry that was read and checked; `says` if it only shows values.

    `texts` are its parts as they were typed, with the subprogram that each defines.
    """

    program: Program
    says: bool = False
    texts: tuple[tuple[str, str], ...] = ()


class Session:
    """The entries of a prompt so far.

    `title` is the name of an input whose lines are counted, such as a pipe; without it, a person
    types. `book` has the names of the points in the arm's book. `kept` has the
    texts of the entries carried out, by their numbers.
    """

    def __init__(self, title: str = "") -> None:
        self.context = Context()
        self.title = title
        self.book: frozenset[str] = frozenset()
        self.kept: dict[int, tuple[tuple[str, str], ...]] = {}
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
        if not self._lines:
            self._begin = position if self.title else 1
            self._reader = ProgramReader(self._file)
        wrong: LineMistake | None = None
        read: Statement | None = None
        try:
            read = self._reader.take(line, self._begin + len(self._lines))
        except LineMistake as mistake:
            wrong = mistake
        if not self._lines and (wrong or self._shows(read)):
            try:
                values = read_values(line, self._begin, self._file)
                say = Do("type", values, mark=values[0].mark)
                return PromptEntry(self._checked(Tree((say,)), [line]), says=True)
            except LineMistake as mistake:
                wrong = mistake if self._like_values(line) else wrong
        if wrong:
            raise self._draft([*self._lines, line]).error([wrong.problem])
        self._lines.append(line)
        return None if self._reader.unfinished else self._finished()

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
        body, texts = list[Statement](), list[tuple[str, str]]()
        whole, source = program.tree.body, program.text.splitlines()
        for line, following in zip_longest(whole, whole[1:]):
            if _given(line):
                end = None if following is None else following.mark.line - 1
                texts.append((_defined(line), "\n".join(source[line.mark.line - 1 : end])))
                body.append(line)
        if not body:
            raise BadRequest(f"{name} has no subprograms, points or values to take")
        tree, lines = Tree(tuple(body)), {**self.context.lines, **program.lines}
        known = replace(self.context, defines=_needed(tree, self.context))
        taken = checked_program(replace(program, tree=tree, context=known, lines=lines))
        return PromptEntry(taken, texts=tuple(texts))

    def _finished(self) -> PromptEntry | None:
        """Return the entry of the lines typed; None if there is nothing in them."""
        lines = self._lines
        self.abandon()
        tree, problems = self._reader.finish()
        if not any(each.strip() for each in lines):
            return None
        program = self._checked(tree, lines, problems)
        return PromptEntry(program, texts=((_defined(*tree.body[:1]), program.text),))

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
        return Program(text, self._file, Tree(()), context=self.context, lines=known, near=near)

    def _shows(self, line: Statement | None) -> bool:
        """Return whether a line that could be a statement is meant as a value, to be shown."""
        match line:
            case Call(name=name, arguments=()):
                return self._has_value(name)
            case Call(name=name):
                return name.lower() in FUNCTIONS
            case Do(word="here", arguments=()) | Label(name=_):
                return True
            case _:
                return False

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
        own = entry.program.tree.defines
        defines = self.context.but(own) if done else self.context.defines
        self.context = replace(machine.context, defines=defines)
        if not done or entry.says or machine.ended_by_stop:
            return  # a `stop` would end the program of all entries as well
        replaced = {line.name.lower() for line in own}
        left = {
            number: tuple(each for each in texts if each[0] not in replaced)
            for number, texts in self.kept.items()
        }
        self.kept = {number: texts for number, texts in left.items() if texts}
        self.kept[self.number] = entry.texts
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
        return "".join(f"{text}\n" for texts in self.kept.values() for _, text in texts)


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


def _defined(line: Statement | None = None) -> str:
    """Return the subprogram that a line defines, "" if it is none."""
    return line.name.lower() if isinstance(line, Define) else ""


def _given(line: Statement) -> bool:
    """Return whether a line only defines a name, without asking the arm."""
    if isinstance(line, Assign):
        return not any(
            isinstance(each, Name | Use) and each.name.lower() in OF_THE_ARM
            for each in within(line.value)
        )
    return isinstance(line, Define)
