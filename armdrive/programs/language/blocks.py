"""Checks a program as a whole, and numbers its blocks, so that a run can say in which it is.

A block is a list of lines: the program itself, a subprogram, a branch of an `if`, the body of a
loop. Everything that is wrong is reported at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from armdrive.programs.language.checking import Fitting, Kinds
from armdrive.programs.language.grammar import unknown_word
from armdrive.programs.language.syntax import (
    Call,
    Define,
    Do,
    Expression,
    Goto,
    If,
    Label,
    Literal,
    Name,
    ProgramNames,
    Repeat,
    Statement,
    Tree,
    Use,
    While,
    bodies,
    names_of,
    own_names,
    set_by,
    slotted,
    within,
)
from armdrive.programs.language.words import HERE, RESERVED, SHAPES, WORDS, ValueKind
from armdrive.programs.problems import Problem, SourceMark
from kinematics.errors import suggestion


@dataclass(frozen=True, slots=True)
class Block:
    """The lines of a block; `inner` has the numbers of the blocks within the line at an index."""

    body: tuple[Statement, ...]
    labels: Mapping[str, int]
    inner: dict[int, tuple[int, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Subprogram:
    """The number of a subprogram's block, and its parameters in lower case."""

    block: int
    parameters: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class CheckedProgram:
    """The blocks of a program, the first of which is the program itself, and its subprograms.

    `points` are those of the arm's book that it needs, with the place where each is named first.
    """

    blocks: tuple[Block, ...] = ()
    subprograms: Mapping[str, Subprogram] = field(default_factory=dict)
    points: Mapping[str, SourceMark] = field(default_factory=dict)


def checked(
    tree: Tree, known: Mapping[str, ValueKind] = MappingProxyType({})
) -> tuple[CheckedProgram, list[Problem]]:
    """Return a program's blocks, and everything that is wrong with it.

    `known` are the kinds of the names that have a value already. The blocks of a wrong program are
    of no use.
    """
    names = names_of(tree, frozenset(known))
    checker = _Checker(names, Kinds(names, known))
    code = checker.whole(tree)
    problems = checker.problems or _Settled(names, frozenset(known)).problems(tree)
    return code, problems


def values_read(line: Statement) -> Iterator[Expression]:
    """Yield the values that a line itself reads, with all their parts."""
    shifts = isinstance(line, Do) and line.word == "shift"  # reads the point that it sets
    values = line.arguments if isinstance(line, Call) else ()
    for value in (*values, *(value for value, slot in slotted(line) if shifts or not slot.sets)):
        yield from within(value)


@dataclass(frozen=True, slots=True)
class _Scope:
    """What a line may refer to: its subprogram, the labels in sight, and whether a loop."""

    define: Define | None = None
    labels: frozenset[str] = frozenset()
    looped: bool = False


class _Checker:
    """The blocks as they are found, and what is wrong with the program."""

    def __init__(self, names: ProgramNames, kinds: Kinds) -> None:
        self.problems: list[Problem] = []
        self._names = names
        self._settled = names.variables - names.only_shifted
        self._kinds = kinds
        self._blocks: list[Block] = []
        self._points: dict[str, SourceMark] = {}
        self._labels: set[tuple[str, str]] = set()

    def whole(self, tree: Tree) -> CheckedProgram:
        """Check a program and its subprograms."""
        self._block(tree.body, _Scope())
        found: dict[str, Subprogram] = {}
        for define in tree.defines:
            self._heading(define, found)
            parameters = tuple(name.lower() for name in define.parameters)
            called = Subprogram(self._block(define.body, _Scope(define)), parameters)
            found.setdefault(define.name.lower(), called)
        return CheckedProgram(tuple(self._blocks), found, self._points)

    def _wrong(self, mark: SourceMark, text: str) -> None:
        self.problems.append(Problem(mark, text))

    def _heading(self, define: Define, known: Mapping[str, Subprogram]) -> None:
        """Check the names of a subprogram and of its parameters."""
        name, mark = define.name, define.mark
        if name.lower() in known:
            self._wrong(mark, f"there is already a subprogram {name!r}")
        if name.lower() in self._names.variables | own_names(define):
            self._wrong(mark, f"{name!r} is also the name of a value: choose another")
        low = [parameter.lower() for parameter in define.parameters]
        for index, parameter in enumerate(define.parameters):
            if low[index] in low[:index]:
                self._wrong(mark, f"two parameters are called {parameter!r}")
        for each in (name, *define.parameters):
            self._require_free(each, mark)

    def _require_free(self, name: str, mark: SourceMark) -> None:
        if name.lower() in RESERVED:
            self._wrong(mark, f"`{name.lower()}` is a word of the language: choose another name")

    def _block(self, body: tuple[Statement, ...], scope: _Scope) -> int:
        """Check a block and those within it; return its number."""
        labels: dict[str, int] = {}
        for index, line in enumerate(body):
            if isinstance(line, Label):
                label = (_name_of(scope.define), line.name.lower())
                if label in self._labels:
                    self._wrong(line.mark, f"there is already a label {line.name!r}")
                self._labels.add(label)
                labels[line.name.lower()] = index
        number, block = len(self._blocks), Block(body, labels)
        self._blocks.append(block)
        for index, line in enumerate(body):
            if isinstance(line, Define):
                continue
            inside = _Scope(
                scope.define,
                scope.labels | labels.keys(),
                scope.looped or isinstance(line, While | Repeat),
            )
            self._line(line, inside)
            block.inner[index] = tuple(self._block(each, inside) for each in bodies(line))
        return number

    def _line(self, line: Statement, scope: _Scope) -> None:
        self.problems += Fitting(self._kinds, scope.define).line(line)
        for each, _ in set_by(line):
            self._require_free(each.name, each.mark)
        own = own_names(scope.define)
        for value in values_read(line):
            self._note_point(value, own)
        match line:
            case Call(name=name) if name.lower() not in self._names.subprograms:
                subprograms = (each.name for each in self._names.subprograms.values())
                unknown = f"there is no word and no subprogram {name!r}"
                known = (*subprograms, *WORDS, *SHAPES)
                self._wrong(line.mark, unknown_word(name, known) or unknown)
            case Goto(name=name) if name.lower() not in scope.labels:
                self._wrong(line.mark, _no_label(name, scope.labels))
            case Do(word="break" | "continue" as word) if not scope.looped:
                self._wrong(line.mark, f"`{word}` is allowed in a loop only")
            case Do(word="return") if scope.define is None:
                text = "`return` is allowed in a subprogram only; `stop` ends the program"
                self._wrong(line.mark, text)

    def _note_point(self, value: Expression, own: frozenset[str]) -> None:
        """Note a point of the arm's book. One that only `shift` sets begins as such a point."""
        match value:
            case Use(name="taught", arguments=(Literal(value=str(name)) as text, *_)):
                self._points.setdefault(name, text.mark)
            case Name(name=name):
                low = name.lower()
                if low != HERE and low not in own and low not in self._settled:
                    self._points.setdefault(name, value.mark)


def _name_of(define: Define | None) -> str:
    return "" if define is None else define.name.lower()


def _no_label(name: str, labels: frozenset[str]) -> str:
    low = name.lower()
    if low in RESERVED:
        return f"`{low}` is no label: the lines of an `if` follow it and end with `end`"
    near = suggestion(low, labels)
    return f"there is no label {name!r} in this block or in one around it{near}"


# Whether every name certainly has a value where it is used.
#
# This is the analysis of definite assignment: going forward, it finds the names that are set on
# every path to a line (Aho, Lam, Sethi and Ullman, Compilers, section 9.2.5). Where a line can be
# reached by a `goto`, and in subprograms, any name may have a value: there, the run tells.

# The set of all names: what is certain behind a line that nothing follows.
_ALL = -1


class _Settled:
    """Finds the names that may have no value where they are used; `known` names have one already.

    A set of names is a whole number with a bit for each, since a program of thousands of lines has
    thousands of such sets.
    """

    def __init__(self, names: ProgramNames, known: frozenset[str]) -> None:
        settable = sorted(names.variables - names.only_shifted)
        self._bits = {name: 1 << index for index, name in enumerate(settable)}
        self._known = sum(self._bits.get(name, 0) for name in known)
        called = (line for define, line in names.lines if define is not None)
        self._called = 0
        for line in called:
            self._called |= self._set_in(line)
        self._breaks: list[int] = []

    def problems(self, tree: Tree) -> list[Problem]:
        """Return a problem for each such use in the program itself."""
        self._found: list[Problem] = []
        self._block(tree.body, self._known)
        return self._found

    def _block(self, body: tuple[Statement, ...], have: int) -> int:
        for line in body:
            have = self._line(line, have)
        return have

    def _line(self, line: Statement, have: int) -> int:
        """Return what is set after a line, if `have` is set before it."""
        for value in () if isinstance(line, Define) else values_read(line):
            if isinstance(value, Name) and self._bits.get(value.name.lower(), 0) & ~have:
                text = f"{value.name!r} may have no value yet here: set it before"
                self._found.append(Problem(value.mark, text))
        match line:
            case Label() | Goto() | Do(word="stop" | "continue"):
                return _ALL
            case Do(word="break"):
                self._breaks[-1] &= have
                return _ALL
            case Call():
                return have | self._called
            case If(branches=branches):
                after = _ALL if branches[-1].condition is None else have
                for branch in branches:
                    after &= self._block(branch.body, have)
                return after
            case While() | Repeat():
                self._breaks.append(_ALL)
                self._block(line.body, have | self._set_in(line))
                broken = self._breaks.pop()
                return broken if isinstance(line, Repeat) and line.count is None else broken & have
            case _:
                return have | self._set_in(line)

    def _set_in(self, line: Statement) -> int:
        bits = 0
        for name, _ in set_by(line):
            bits |= self._bits.get(name.name.lower(), 0)
        return bits
