"""Checks a program as a whole, and numbers its blocks, so that a run can say in which it is.

A block is a list of lines: the program itself, a subprogram, a branch of an `if`, the body of a
loop. Everything that is wrong is reported at once. Of a name, only a run can tell what kind of
value it holds: a wrong one ends the rehearsal, or the run, in that line.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite

from armdrive.programs.language.syntax import (
    Assign,
    Call,
    Define,
    Do,
    Expression,
    Goto,
    If,
    JointsOf,
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
from armdrive.programs.language.values import fewest, kind_of, out_of_bounds, slot_of
from armdrive.programs.language.words import (
    ANY_VALUE,
    CALLABLE,
    COMPARABLE,
    FUNCTIONS,
    HERE,
    RESERVED,
    SHAPES,
    WORDS,
    Slot,
    ValueKind,
)
from armdrive.programs.problems import Problem, SourceMark
from kinematics.errors import suggestion
from kinematics.spaces import POSE_FIELDS
from kinematics.text import counted


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
    tree: Tree, known: frozenset[str] = frozenset()
) -> tuple[CheckedProgram, list[Problem]]:
    """Return a program's blocks, and everything that is wrong with it.

    `known` are the names that have a value already. The blocks of a wrong program are of no use.
    """
    checker = _Checker(names_of(tree, known))
    code = checker.whole(tree)
    return code, checker.problems


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

    def __init__(self, names: ProgramNames) -> None:
        self.problems: list[Problem] = []
        self._names = names
        # the parameters of the subprogram at work
        self._own: frozenset[str] = frozenset()
        self._blocks: list[Block] = []
        self._points: dict[str, SourceMark] = {}
        self._labels: set[tuple[str, str]] = set()

    def whole(self, tree: Tree) -> CheckedProgram:
        """Check a program and its subprograms."""
        self._block(tree.body, _Scope())
        found: dict[str, Subprogram] = {}
        for define in tree.defines:
            self._own = own_names(define)
            self._heading(define, found)
            parameters = tuple(name.lower() for name in define.parameters)
            called = Subprogram(self._block(define.body, _Scope(define)), parameters)
            found.setdefault(define.name.lower(), called)
        return CheckedProgram(tuple(self._blocks), found, self._points)

    def _wrong(self, mark: SourceMark, text: str) -> None:
        self.problems.append(Problem(mark, text))

    # -- names and blocks --------------------------------------------------------------------

    def _heading(self, define: Define, known: Mapping[str, Subprogram]) -> None:
        """Check the names of a subprogram and of its parameters."""
        name, mark = define.name, define.mark
        if name.lower() in known:
            self._wrong(mark, f"there is already a subprogram {name!r}")
        if name.lower() in self._names.variables | self._own:
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
        """Check a line, without the lines within it."""
        for each in set_by(line):
            self._require_free(each.name, each.mark)
        for value in values_read(line):
            self._note_point(value)
        match line:
            case Do():
                self._do(line, scope)
            case Assign():
                self._assign(line)
            case Call():
                self._call(line)
            case Goto(name=name) if name.lower() not in scope.labels:
                self._wrong(line.mark, _no_label(name, scope.labels))
            case If() | While() | Repeat():
                for value, slot in slotted(line):
                    if not slot.sets:
                        self._value(value, slot)

    def _note_point(self, value: Expression) -> None:
        """Note a point of the arm's book. One that only `shift` sets begins as such a point."""
        match value:
            case Use(name="taught", arguments=(Literal(value=str(name)) as text, *_)):
                self._points.setdefault(name, text.mark)
            case Name(name=name) if (
                self._unset(name) or name.lower() in self._names.only_shifted - self._own
            ):
                self._points.setdefault(name, value.mark)

    def _unset(self, name: str) -> bool:
        """Return whether the program never sets a name: then it is a point of the arm's book."""
        low = name.lower()
        return low != HERE and low not in self._own and low not in self._names.variables

    # -- lines -------------------------------------------------------------------------------

    def _do(self, line: Do, scope: _Scope) -> None:
        word = WORDS[line.word]
        example = f": `{word.example}`"
        self._many(line.arguments, word.slots, line.word, line.mark, example)
        known = dict(word.links)
        links = [link for link, _ in line.links]
        for link, values in line.links:
            if link not in known or links.count(link) > 1:
                self._wrong(line.mark, f"`{link}` does not belong to `{line.word}` here{example}")
            else:
                self._many(values, known[link], link, line.mark, example)
        for link in word.needs:
            if link not in links:
                self._wrong(line.mark, f"`{line.word}` needs `{link}`{example}")
        if line.word in ("break", "continue") and not scope.looped:
            self._wrong(line.mark, f"`{line.word}` is allowed in a loop only")
        if line.word == "return" and scope.define is None:
            text = "`return` is allowed in a subprogram only; `stop` ends the program"
            self._wrong(line.mark, text)

    def _assign(self, line: Assign) -> None:
        (value, slot), *_ = slotted(line)
        kind = self._kind(value)
        if line.point:
            self._value(value, slot)
        elif isinstance(value, Name) and self._unset(value.name):
            self._undefined(value)
        elif kind is ValueKind.TEXT:
            self._wrong(value.mark, "a text cannot have a name")
        else:
            if kind is ValueKind.PLACE:
                self._wrong(line.mark, f"to name a place, write `point {line.name} = ...`")
            self._value(value, slot)

    def _call(self, line: Call) -> None:
        called = self._names.subprograms.get(line.name.lower())
        if called is None:
            subprograms = (each.name for each in self._names.subprograms.values())
            near = suggestion(line.name.lower(), (*subprograms, *WORDS, *SHAPES))
            self._wrong(line.mark, f"there is no word and no subprogram {line.name!r}{near}")
            return
        for value in line.arguments[: len(called.parameters)]:
            if self._kind(value) is ValueKind.TEXT:
                self._wrong(value.mark, "a subprogram takes no text")
            self._value(value, ANY_VALUE)
        if len(called.parameters) != len(line.arguments):
            takes = ", ".join(called.parameters) or "nothing"
            values = counted(len(called.parameters), "value")
            text = f"`{called.name}` takes {takes}: {values}, not {len(line.arguments)}"
            self._wrong(line.mark, text)

    # -- values ------------------------------------------------------------------------------

    def _kind(self, value: Expression) -> ValueKind | None:
        """Return the kind of a value, or None if only a run can tell."""
        match value:
            case Name(name=name):
                return ValueKind.PLACE if name.lower() == HERE or self._unset(name) else None
            case Literal():
                return kind_of(value.value)
            case JointsOf():
                return ValueKind.PLACE
            case Use():
                return CALLABLE[value.name].gives if value.name in CALLABLE else None

    def _many(
        self,
        values: Sequence[Expression],
        slots: Sequence[Slot],
        what: str,
        mark: SourceMark,
        hint: str,
    ) -> None:
        """Check the values of a word, a link or a function: `what`."""
        if len(values) < fewest(slots):
            missing = slots[len(values)].title
            self._wrong(mark, f"`{what}` needs the {missing}{hint}")
        for index, value in enumerate(values):
            slot = slot_of(slots, index)
            if slot is None:
                count = counted(len(slots), "value") if slots else "nothing"
                self._wrong(value.mark, f"`{what}` takes {count}, this is too many{hint}")
                return
            if not slot.sets:
                self._value(value, slot)
            elif not isinstance(value, Name):
                self._wrong(value.mark, f"`{what}` needs a name here{hint}")

    def _value(self, value: Expression, slot: Slot) -> None:
        """Check a value and its parts."""
        match value:
            case JointsOf():
                self._joints(value)
            case Use():
                self._use(value)
        kind, computed = self._kind(value), slot.kind in (*COMPARABLE, ValueKind.COMPARABLE)
        if isinstance(value, Name) and computed and self._unset(value.name):
            self._undefined(value)
        elif kind is not None and not _fits(kind, slot.kind):
            self._wrong(value.mark, f"{slot.kind.value} is needed here, not {kind.value}")
        elif isinstance(value, Literal) and type(value.value) is float:
            wrong = (
                out_of_bounds(slot, value.value, percent=value.percent)
                if isfinite(value.value)
                else "this number is too large"
            )
            if wrong is not None:
                self._wrong(value.mark, wrong)

    def _undefined(self, value: Name) -> None:
        near = suggestion(value.name.lower(), self._names.variables)
        self._wrong(value.mark, f"{value.name!r} is not defined{near}")

    def _joints(self, value: JointsOf) -> None:
        names = [name for name, _ in value.angles]
        for name, angle in value.angles:
            self._value(angle, Slot(name))
        for name in sorted({name for name in names if names.count(name) > 1}):
            self._wrong(value.mark, f"{name} has two angles")

    def _use(self, value: Use) -> None:
        row = CALLABLE.get(value.name)
        if row is None:
            self._wrong(value.mark, _no_function(value.name))
        else:
            self._many(value.arguments, row.slots, value.name, value.mark, f": `{row.example}`")


def _fits(kind: ValueKind, wanted: ValueKind) -> bool:
    comparable = wanted is ValueKind.COMPARABLE and kind in COMPARABLE
    return comparable or wanted in (kind, ValueKind.ANY)


def _name_of(define: Define | None) -> str:
    return "" if define is None else define.name.lower()


def _no_function(name: str) -> str:
    if name.startswith("."):
        return f"a place has {', '.join(POSE_FIELDS)}, no {name[1:]}"
    return f"there is no function {name!r}{suggestion(name, FUNCTIONS)}"


def _no_label(name: str, labels: frozenset[str]) -> str:
    low = name.lower()
    if low in RESERVED:
        return f"`{low}` is no label: the lines of an `if` follow it and end with `end`"
    near = suggestion(low, labels)
    return f"there is no label {name!r} in this block or in one around it{near}"
