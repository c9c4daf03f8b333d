"""What is typed at a prompt, entry by entry. Each entry is a program that knows those before it.

A `Session` is pure: it reads and remembers; an `ArmSession` carries out. An entry is a line, a
whole block, or values alone, which are shown. The entries that were carried out form a program,
which can be listed and saved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from armdrive.arm import Arm
from armdrive.blocking import run_blocking
from armdrive.errors import BadRequest
from armdrive.programs.language.grammar import End, Item, LineMistake, opens, read_line, read_tree
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
from armdrive.programs.language.words import FUNCTIONS, HERE, OVER
from armdrive.programs.language.writing import unparse
from armdrive.programs.problems import Problem, ProgramError, SourceMark, all_shown, excerpt
from armdrive.programs.program import ArmProgram, Context, Machine, Program, read_program
from armdrive.programs.running import (
    Onlooker,
    Performer,
    ProgramRun,
    RunPerson,
    RunPlan,
    RunStep,
)
from armdrive.storage.files import DISK, replace_durably

# The lines that were typed at a prompt, and how their problems are shown.


class Typed:
    """All lines by their file, as marks name it, and their numbers.

    `title` is the name of an input whose lines are counted, such as a pipe. At a terminal people
    see what they have just typed, so its problems are shown without a place.
    """

    def __init__(self, title: str = "") -> None:
        self.title = title
        self._lines: dict[str, dict[int, str]] = {}
        self._latest = ""
        self._before = 0

    def add(self, name: str, lines: Sequence[str], begin: int = 1, before: int = 0) -> None:
        """Add lines; the first is number `begin`, and `before` characters were put before it."""
        self._lines.setdefault(name, {}).update(enumerate(lines, begin))
        self._latest, self._before = name, before

    def shown(self, error: ProgramError) -> ProgramError:
        """Return an error with the lines as they were typed."""
        return self.error(error.problems) if error.problems else error

    def error(self, problems: Sequence[Problem]) -> ProgramError:
        """Return the error with these problems, at least one."""
        text, mark = all_shown(problems, self._pointed), self._typed(problems[0].mark)
        return ProgramError(text, mark=mark, problems=tuple(problems))

    def line_at(self, mark: SourceMark) -> str:
        """Return the line that a mark points at, "" if there is none."""
        return self._lines.get(mark.file, {}).get(mark.line, "")

    def _typed(self, mark: SourceMark) -> SourceMark:
        before = self._before if mark.file == self._latest else 0
        return SourceMark(mark.line, max(mark.column - before, 1), mark.file)

    def _pointed(self, problem: Problem) -> str:
        """Return the text of a problem, its line, and a caret under the place."""
        mark, line = self._typed(problem.mark), self.line_at(problem.mark)
        text = problem.text + (f"\n{excerpt(line, mark.column)}" if line else "")
        seen = mark.file == self._latest and not self.title
        return text if seen else f"{mark}: {text}"


SAYING = "type "
"""The word put before values that stand alone, so that they are shown."""

OF_THE_ARM = (HERE, "input")
"""Values that only an arm can give."""


@dataclass(frozen=True, slots=True)
class PromptEntry:
    """One entry that was read and checked; `says` if it only shows values."""

    program: Program
    says: bool = False
    lines: int = 1
    """The number of lines typed."""


class Session:
    """The entries of a prompt so far. `title` is the name of an input whose lines are counted.

    `book` has the names of the points in the arm's book. `kept` has the lines carried out, by the
    numbers of their entries.
    """

    def __init__(self, title: str = "") -> None:
        self.context = Context()
        self.typed = Typed(title)
        self.book: frozenset[str] = frozenset()
        self.kept: dict[int, tuple[Statement, ...]] = {}
        self.number = 1
        self._block: list[str] = []
        self._depth = 0
        self._begin = 1

    # -- reading ------------------------------------------------------------------------------

    @property
    def unfinished(self) -> bool:
        """Whether a block is still without its end."""
        return bool(self._block)

    def take(self, line: str, position: int = 1) -> PromptEntry | None:
        """Take the next line; return the entry that it completes, if it does.

        `position` is the line's number in the input. An unreadable line is not taken. Raises
        `ProgramError`.
        """
        if not self._block:
            self._begin = position if self.typed.title else 1
        items = self._items(line)
        if items is None:
            return self._values(line)
        self._block.append(line)
        self._depth += sum(opens(item) - isinstance(item, End) for item in items)
        if self._depth > 0:
            return None
        lines = list(self._block)
        self.abandon()
        return self._read(lines) if any(each.strip() for each in lines) else None

    def abandon(self) -> None:
        """Forget the lines of an unfinished block."""
        self._block, self._depth = [], 0

    def end(self) -> None:
        """End the input. Raises `ProgramError` for an unfinished block."""
        lines = list(self._block)
        self.abandon()
        if lines:
            self._read(lines)

    def load(self, program: Program, name: str) -> PromptEntry:
        """Return the subprograms and values of another program as an entry.

        Lines that move, wait, or ask the arm are left out. Raises `ProgramError`.
        """
        body = tuple(line for line in program.tree.body if _given(line))
        if not body:
            raise BadRequest(f"{name} has no subprograms, points or values to take")
        lines = unparse(Tree(body)).splitlines()
        self.typed.add(name, lines)
        return self._checked(lines, name)

    def _items(self, line: str) -> list[Item] | None:
        """Return the items of a line, or None for values alone. Raises `ProgramError`."""
        try:
            items = read_line(line, self._begin + len(self._block), self._file)
        except LineMistake as mistake:
            if not self._block and self._like_values(line):
                return None
            self.typed.add(self._file, (*self._block, line), self._begin)
            raise self.typed.error([mistake.problem]) from None
        return None if not self._block and items and self._is_value(items, line) else items

    def _is_value(self, items: list[Item], line: str) -> bool:
        """Return whether a readable statement is meant to be a value, such as a bare name."""
        match items[0]:
            case Do(word="here", arguments=()):
                return True
            case Label():
                return len(items) == 1 and not line.rstrip().endswith(":")
            case Call(name=name, arguments=arguments):
                return name.lower() in FUNCTIONS or (not arguments and self._has_value(name))
            case _:
                return False

    def _has_value(self, name: str) -> bool:
        low = name.lower()
        if any(each.name.lower() == low for each in self.context.defines):
            return False
        return low in self.context.variables or low in map(str.lower, self.book)

    def _like_values(self, line: str) -> bool:
        """Return whether an unreadable line is meant to be values, such as `2 * 3` or `width +`."""
        try:
            read_line(SAYING + line)
        except LineMistake:
            first = NAME.match(line.lstrip())
            return first is None or self._has_value(first[0]) or first[0].lower() in FUNCTIONS
        return True

    @property
    def _file(self) -> str:
        return self.typed.title or f"entry {self.number}"

    def _values(self, line: str) -> PromptEntry:
        self.typed.add(self._file, [line], self._begin, before=len(SAYING))
        return replace(self._checked([SAYING + line], self._file, self._begin), says=True)

    def _read(self, lines: list[str]) -> PromptEntry:
        self.typed.add(self._file, lines, self._begin)
        return self._checked(lines, self._file, self._begin)

    def _checked(self, lines: list[str], file: str, begin: int = 1) -> PromptEntry:
        text = "\n".join(lines)
        tree, _ = read_tree(text, file, begin)
        known = replace(self.context, defines=_needed(tree, self.context))
        try:
            program = read_program(text, file, known, begin)
        except ProgramError as error:
            raise self.typed.shown(error) from None
        return PromptEntry(program, lines=len(lines))

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

    def drop(self, number: int) -> None:
        """Remove an entry from the program. Raises `BadRequest` for an unknown number."""
        if number not in self.kept:
            raise BadRequest(f"there is no entry {number} in the list")
        del self.kept[number]

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


# A session on one arm: carries out its entries, and saves them as a program.

INPUT = "standard input"
"""The name of a pipe in places."""


class ArmSession:
    """A session whose entries are carried out on one arm; `typing` if a person types them.

    `at` is the step at which the last entry was interrupted, if it was.
    """

    def __init__(self, arm: Arm, *, typing: bool) -> None:
        self.arm = arm
        self.typing = typing
        self.done = 0
        self.at: RunStep | None = None
        self._saved: set[Path] = set()
        self._stops = arm.stops
        self._outputs = 0
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget everything typed. The arm stays as it is."""
        self.session = Session("" if self.typing else INPUT)

    def machine(self, entry: PromptEntry) -> Machine:
        """Return the machine of an entry, with the arm's present points."""
        return ArmProgram(entry.program, self.arm.config).machine()

    def carry_out(
        self,
        entry: PromptEntry,
        machine: Machine,
        person: RunPerson,
        onlookers: Sequence[Onlooker],
    ) -> None:
        """Carry out an entry, and learn the names that it sets, even if it is interrupted."""
        self.at = None
        self._forget_stops()
        performer = Performer(self.arm, person, since=self._stops, outputs=self._outputs)
        run = ProgramRun(RunPlan(lambda: machine), performer, onlookers)
        done = False
        try:
            run.carry_out()
            done = True
        finally:
            self.at = run.at
            self.session.learn(entry, machine, done=done)
            self.arm.program = None
        self._outputs = performer.outputs
        self.done += 1

    def _forget_stops(self) -> None:
        """Ignore a stop between two typed entries; it does end the input of a pipe."""
        if self.typing and self.arm.stops != self._stops:
            # otherwise a stop that the engine has not seen yet would end the next motion
            run_blocking(self.arm.runner.stand_still())
            self._stops = self.arm.stops

    def save(self, path: Path, *, over: bool) -> int:
        """Save the entries carried out as a program; return how many lines. Raises `BadRequest`.

        Another file is replaced only with `over`.
        """
        text = self.session.text
        if not text.strip():
            raise BadRequest("there is nothing to save: no line has run yet")
        if path.exists() and not over and path.absolute() not in self._saved:
            raise BadRequest(
                f"{path} exists already: choose another name, or type `save {path} {OVER}`"
            )
        program = read_program(text, str(path))
        ArmProgram(program, self.arm.config).machine()  # what is written can be run here
        replace_durably(DISK, path.absolute(), text.encode("utf-8"))
        self._saved.add(path.absolute())
        return len(text.splitlines())
