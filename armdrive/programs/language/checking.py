"""Checks a whole program before it runs, and reports everything that is wrong at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import isfinite
from types import MappingProxyType

from armdrive.programs.language.compiling import CALL, RETURN, CompiledCode, Instruction, compiled
from armdrive.programs.language.grammar import unknown_word
from armdrive.programs.language.syntax import (
    Assign,
    Binary,
    Call,
    Define,
    Do,
    Expression,
    FieldOf,
    Goto,
    JointsOf,
    Label,
    Name,
    Number,
    ProgramNames,
    Repeat,
    Statement,
    TextValue,
    Tree,
    Truth,
    Unary,
    Use,
    While,
    bodies,
    every,
    names_of,
    own_names,
    set_by,
    slotted,
)
from armdrive.programs.language.values import OPERATORS, fewest, out_of_bounds, slot_of
from armdrive.programs.language.words import (
    FIELDS,
    FUNCTIONS,
    HERE,
    PLACE,
    RESERVED,
    SHAPES,
    WORDS,
    Slot,
    ValueKind,
)
from armdrive.programs.problems import Problem, SourceMark
from kinematics.errors import suggestion

# The kind of every name of a program, inferred from the lines that set it.


class Kinds:
    """The kinds of a program's names. The first value of a name decides its kind."""

    def __init__(
        self, names: ProgramNames, known: Mapping[str, ValueKind] = MappingProxyType({})
    ) -> None:
        self.variables = names.variables
        self.subprograms = names.subprograms
        self._kinds = {("", name): kind for name, kind in known.items()}
        setting = [
            (define, line)
            for define, line in names.lines
            if isinstance(line, Call) or any(set_by(line))
        ]
        while True:
            found = len(self._kinds)
            for define, line in setting:
                for name, kind, owner in self._given(define, line):
                    if kind is not None:
                        self._kinds.setdefault(_scope(name.lower(), owner), kind)
            if len(self._kinds) == found:
                return

    def _given(
        self, define: Define | None, line: Statement
    ) -> Iterator[tuple[str, ValueKind | None, Define | None]]:
        """Yield the names that a line sets, their kinds, and the subprogram that they belong to."""
        for value, kind in self.set_by(define, line):
            yield value.name, kind, define
        called = self.subprograms.get(line.name.lower()) if isinstance(line, Call) else None
        if called is not None and isinstance(line, Call):
            for name, argument in zip(called.parameters, line.arguments, strict=False):
                yield name, self.of(argument, define), called

    def set_by(
        self, define: Define | None, line: Statement
    ) -> Iterator[tuple[Name, ValueKind | None]]:
        """Yield the names that a line itself sets, with their kinds."""
        for name, kind in set_by(line):
            if isinstance(line, Assign) and kind is ValueKind.ANY:
                yield name, self.of(line.value, define)
            else:
                yield name, kind

    def of_name(self, name: str, define: Define | None) -> ValueKind | None:
        """Return the kind of a name, or None if it is unknown."""
        low = name.lower()
        if self.nowhere(name, define) or low == HERE:
            return ValueKind.PLACE
        return self._kinds.get(_scope(low, define))

    def nowhere(self, name: str, define: Define | None) -> bool:
        """Return whether the program never sets a name: then it is a point of the arm's book."""
        low = name.lower()
        return low != HERE and low not in own_names(define) and low not in self.variables

    def of(self, value: Expression, define: Define | None) -> ValueKind | None:
        """Return the kind of a value, or None if it is unknown."""
        match value:
            case Name():
                return self.of_name(value.name, define)
            case Unary() | Binary():
                return OPERATORS[value.sign].gives
            case Use():
                row = FUNCTIONS.get(value.name)
                return None if row is None else row.gives
            case _:
                return _KINDS[type(value)]


_KINDS: Mapping[type[Expression], ValueKind] = MappingProxyType({
    Number: ValueKind.NUMBER, FieldOf: ValueKind.NUMBER, Truth: ValueKind.TRUTH,
    TextValue: ValueKind.TEXT, JointsOf: ValueKind.PLACE,
})  # fmt: skip
"""The kinds of those values that are always of one kind."""


def _scope(name: str, define: Define | None) -> tuple[str, str]:
    """Parameters belong to their subprogram, all other names to the program."""
    own = define is not None and name in own_names(define)
    return (define.name.lower() if own and define is not None else "", name)


# Whether values fit: their number, kinds and bounds.


class Fitting:
    """Checks the lines of one subprogram, or of the program itself."""

    def __init__(self, kinds: Kinds, define: Define | None) -> None:
        self._kinds = kinds
        self._define = define

    def line(self, line: Statement) -> Iterator[Problem]:
        """Yield what is wrong in a line, without the lines within it."""
        match line:
            case Do():
                yield from self._do(line)
            case Assign():
                yield from self._assign(line)
            case Call():
                yield from self._call(line)
            case _:
                for value, slot in slotted(line):
                    if not slot.sets:
                        yield from self._value(value, slot)
        for name, kind in self._kinds.set_by(self._define, line):
            known = self._kinds.of_name(name.name, self._define)
            if kind is not None and known is not None and kind is not known:
                text = f"{name.name!r} is {known.value} elsewhere, and cannot become {kind.value}"
                yield Problem(name.mark, text)

    # -- lines -------------------------------------------------------------------------------

    def _do(self, line: Do) -> Iterator[Problem]:
        word = WORDS[line.word]
        example = f": `{word.example}`"
        yield from self._many(line.arguments, word.slots, line.word, line.mark, example)
        known = dict(word.links)
        links = [link for link, _ in line.links]
        for link, values in line.links:
            if link not in known or links.count(link) > 1:
                yield Problem(line.mark, f"`{link}` does not belong to `{line.word}` here{example}")
            else:
                yield from self._many(values, known[link], link, line.mark, example)
        for link in word.needs:
            if link not in links:
                yield Problem(line.mark, f"`{line.word}` needs `{link}`{example}")

    def _assign(self, line: Assign) -> Iterator[Problem]:
        (value, slot), *_ = slotted(line)
        kind = self._kinds.of(value, self._define)
        if line.point:
            yield from self._value(value, slot)
        elif isinstance(value, Name) and self._kinds.nowhere(value.name, self._define):
            yield self._nowhere(value)
        elif kind is ValueKind.TEXT:
            yield Problem(value.mark, "a text cannot have a name")
        else:
            if kind is ValueKind.PLACE:
                text = f"to name a place, write `point {line.name} = ...`"
                yield Problem(line.mark, text)
            yield from self._value(value, slot)

    def _call(self, line: Call) -> Iterator[Problem]:
        called = self._kinds.subprograms.get(line.name.lower())
        if called is None:
            return
        for name, value in zip(called.parameters, line.arguments, strict=False):
            kind = self._kinds.of_name(name, called)
            if isinstance(value, TextValue):
                yield Problem(value.mark, "a subprogram takes no text")
            else:
                yield from self._value(value, Slot(name, kind or ValueKind.ANY))
        if len(called.parameters) != len(line.arguments):
            takes = ", ".join(called.parameters) or "nothing"
            text = f"`{called.name}` takes {takes}: {len(called.parameters)} values, "
            yield Problem(line.mark, f"{text}not {len(line.arguments)}")

    # -- values ------------------------------------------------------------------------------

    def _many(
        self,
        values: Sequence[Expression],
        slots: Sequence[Slot],
        what: str,
        mark: SourceMark,
        hint: str,
    ) -> Iterator[Problem]:
        if len(values) < fewest(slots):
            missing = slots[len(values)].title
            yield Problem(mark, f"`{what}` needs the {missing}{hint}")
        for index, value in enumerate(values):
            slot = slot_of(slots, index)
            if slot is None:
                count = f"{len(slots)} value{'s' * (len(slots) != 1)}" if slots else "nothing"
                yield Problem(value.mark, f"`{what}` takes {count}, this is too many{hint}")
                return
            if not slot.sets:
                yield from self._value(value, slot)
            elif not isinstance(value, Name):
                yield Problem(value.mark, f"`{what}` needs a name here{hint}")

    def _value(self, value: Expression, slot: Slot) -> Iterator[Problem]:
        found = list(self._inside(value))
        yield from found
        kind = self._kinds.of(value, self._define)
        computed = slot.kind in (ValueKind.NUMBER, ValueKind.TRUTH)
        if isinstance(value, Name) and computed and self._kinds.nowhere(value.name, self._define):
            yield self._nowhere(value)
        elif kind is not None and slot.kind not in (kind, ValueKind.ANY):
            yield Problem(value.mark, f"{slot.kind.value} is needed here, not {kind.value}")
        elif isinstance(value, Number) and isfinite(value.value):
            wrong = out_of_bounds(slot, value.value, percent=value.percent)
            if wrong is not None:
                yield Problem(value.mark, wrong)

    def _nowhere(self, value: Name) -> Problem:
        known = self._kinds.variables
        text = f"{value.name!r} is not defined{suggestion(value.name.lower(), known)}"
        return Problem(value.mark, text)

    def _inside(self, value: Expression) -> Iterator[Problem]:
        match value:
            case Number() if not isfinite(value.value):
                yield Problem(value.mark, "this number is too large")
            case Unary():
                taken = OPERATORS[value.sign].takes
                yield from self._value(value.value, Slot("value", taken))
            case Binary():
                yield from self._binary(value)
            case FieldOf():
                yield from self._value(value.value, PLACE)
                if value.name not in FIELDS:
                    text = f"a place has {', '.join(FIELDS)}, no {value.name}"
                    yield Problem(value.mark, text)
            case JointsOf():
                yield from self._joints(value)
            case Use():
                yield from self._use(value)

    def _binary(self, value: Binary) -> Iterator[Problem]:
        sides, kind = (value.left, value.right), OPERATORS[value.sign].takes
        if kind is ValueKind.ANY:  # both are of the kind that one of them shows
            kinds = [self._kinds.of(side, self._define) for side in sides]
            shown = (each for each in kinds if each in (ValueKind.NUMBER, ValueKind.TRUTH))
            kind = next(shown, ValueKind.ANY)
            if kind is ValueKind.ANY and ValueKind.PLACE in kinds:
                yield Problem(value.mark, "places cannot be compared: compare their x, y and z")
            if kind is ValueKind.ANY and ValueKind.TEXT in kinds:
                yield Problem(value.mark, "texts cannot be compared")
        for side in sides:
            yield from self._value(side, Slot("value", kind))

    def _joints(self, value: JointsOf) -> Iterator[Problem]:
        names = [name for name, _ in value.angles]
        for name, angle in value.angles:
            yield from self._value(angle, Slot(name))
        for name in sorted({name for name in names if names.count(name) > 1}):
            yield Problem(value.mark, f"{name} has two angles")

    def _use(self, value: Use) -> Iterator[Problem]:
        row = FUNCTIONS.get(value.name)
        if row is None:
            near = suggestion(value.name, FUNCTIONS)
            yield Problem(value.mark, f"there is no function {value.name!r}{near}")
            return
        hint = f": `{row.example}`"
        yield from self._many(value.arguments, row.slots, value.name, value.mark, hint)


# The shape of a program: names that clash, calls and labels that lead nowhere.


def shape_problems(tree: Tree, names: ProgramNames) -> Iterator[Problem]:
    """Yield what keeps a program from being compiled."""
    defines = [line for line in tree.body if isinstance(line, Define)]
    called = [(line.name, line.mark) for line in defines]
    yield from _twice(called, "there is already a subprogram {!r}")
    for define in defines:
        parameters = [(name, define.mark) for name in define.parameters]
        yield from _twice(parameters, "two parameters are called {!r}")
        for name, mark in ((define.name, define.mark), *parameters):
            yield from _reserved(name, mark)
        if define.name.lower() in names.variables | own_names(define):
            yield Problem(
                define.mark, f"{define.name!r} is also the name of a value: choose another"
            )
    main = tuple(line for line in tree.body if not isinstance(line, Define))
    for body in (main, *(define.body for define in defines)):
        labels = [(line.name, line.mark) for line in every(body) if isinstance(line, Label)]
        yield from _twice(labels, "there is already a label {!r}")
        yield from _Placing(names.subprograms, within=body is not main).problems(body)


def _twice(named: list[tuple[str, SourceMark]], text: str) -> Iterator[Problem]:
    seen: set[str] = set()
    for name, mark in named:
        if name.lower() in seen:
            yield Problem(mark, text.format(name))
        seen.add(name.lower())


def _reserved(name: str, mark: SourceMark) -> Iterator[Problem]:
    if name.lower() in RESERVED:
        yield Problem(mark, f"`{name.lower()}` is a word of the language: choose another name")


class _Placing:
    """Checks whether lines may stand where they do; `within` a subprogram."""

    def __init__(self, known: Mapping[str, Define], *, within: bool) -> None:
        self._known = known
        self._within = within

    def problems(
        self,
        body: tuple[Statement, ...],
        looped: bool = False,
        labels: frozenset[str] = frozenset(),
    ) -> Iterator[Problem]:
        """Yield what is wrong in a block; `labels` are those of the blocks around it."""
        labels |= {line.name.lower() for line in body if isinstance(line, Label)}
        for line in body:
            for name, _ in set_by(line):
                yield from _reserved(name.name, name.mark)
            match line:
                case Goto() if line.name.lower() not in labels:
                    yield Problem(line.mark, _no_label(line.name, labels))
                case Call() if line.name.lower() not in self._known:
                    yield Problem(line.mark, self._no_subprogram(line.name))
                case Do(word="return") if not self._within:
                    text = "`return` is allowed in a subprogram only; `stop` ends the program"
                    yield Problem(line.mark, text)
                case Do(word="break" | "continue") if not looped:
                    yield Problem(line.mark, f"`{line.word}` is allowed in a loop only")
            for block in bodies(line):
                yield from self.problems(block, looped or isinstance(line, While | Repeat), labels)

    def _no_subprogram(self, name: str) -> str:
        names = (*(define.name for define in self._known.values()), *WORDS, *SHAPES)
        return unknown_word(name, names) or f"there is no word and no subprogram {name!r}"


def _no_label(name: str, labels: frozenset[str]) -> str:
    low = name.lower()
    if low in RESERVED:
        return f"`{low}` is no label: the lines of an `if` follow it and end with `end`"
    near = suggestion(low, labels)
    return f"there is no label {name!r} in this block or in one around it{near}"


# Whether every name certainly has a value where it is used.
#
# This is the analysis of definite assignment over the flat code: going forward, it finds the names
# that are set on every path to an instruction. For each subprogram it finds the names that a call
# certainly sets, and those that must be set before it (Aho, Lam, Sethi and Ullman, Compilers,
# section 9.2.5, with summaries for calls).

_Needs = dict[tuple[str, SourceMark], int | None]
"""Names without a value where they are used, to the line of a call that leads there."""


class _Settled:
    """Finds the names that may have no value where they are used; `known` names have one already.

    A set of names is a whole number with a bit for each, since a program of thousands of lines has
    thousands of such sets.
    """

    def __init__(self, code: CompiledCode, known: frozenset[str]) -> None:
        self._rows = code.instructions
        names = known.union(*(row.sets for row in self._rows))
        self._bits = {name: 1 << index for index, name in enumerate(names)}
        self._adds = [self._as_bits(row.sets) for row in self._rows]
        self._known = self._as_bits(known)
        starts = (0, *code.entries.values())
        self._sets = dict.fromkeys(starts, self._as_bits(names))
        self._needs: dict[int, _Needs] = {start: {} for start in starts}
        self._repeat(self._learn_sets)
        self._repeat(self._learn_needs)

    def problems(self) -> Iterator[Problem]:
        for (name, mark), line in self._needs[0].items():
            called = "" if line is None else f" when this is called in line {line}"
            yield Problem(mark, f"{name!r} may have no value yet here{called}: set it before")

    def _as_bits(self, names: frozenset[str]) -> int:
        return sum(self._bits[name] for name in names)

    def _lacks(self, known: int, name: str) -> bool:
        return not known & self._bits.get(name, 0)

    def _repeat(self, learn: Callable[[int], bool]) -> None:
        changed = True
        while changed:
            changed = False
            for start in self._sets:
                changed |= learn(start)

    def _learn_sets(self, start: int) -> bool:
        found = ~0  # a subprogram without an end sets everything: nothing comes after it
        for at, known in self._ways(start).items():
            if self._rows[at].word == RETURN:
                found &= known
        found &= self._sets[start]
        changed = found != self._sets[start]
        self._sets[start] = found
        return changed

    def _learn_needs(self, start: int) -> bool:
        needs = self._needs[start]
        before = len(needs)
        for at, known in self._ways(start).items():
            row = self._rows[at]
            for name in row.reads:
                if self._lacks(known, name.name.lower()):
                    needs.setdefault((name.name.lower(), name.mark), None)
            if row.word == CALL:
                for (called, mark), _ in list(self._needs[row.target].items()):
                    if self._lacks(known, called):
                        needs.setdefault((called, mark), row.mark.line)
        return len(needs) != before

    def _ways(self, start: int) -> dict[int, int]:
        """Return the names certainly set before each instruction that can be reached."""
        known = {start: 0 if start else self._known}
        waiting = [start]
        while waiting:
            at = waiting.pop()
            for following, adds in self._following(at, self._rows[at]):
                before, after = known.get(following), known[at] | adds
                met = after if before is None else before & after
                if met != before:
                    known[following] = met
                    waiting.append(following)
        return known

    def _following(self, at: int, row: Instruction) -> list[tuple[int, int]]:
        """Return the possible next instructions, and what is certainly set before each."""
        match row.word:
            case "return" | "stop":
                return []
            case "jump":
                return [(row.target, self._adds[at])]
            case "call":
                return [(at + 1, self._sets[row.target])]
            case "unless" | "round" if row.target:
                return [(at + 1, self._adds[at]), (row.target, 0)]
            case _:
                return [(at + 1, self._adds[at])]


def checked(
    tree: Tree, known: Mapping[str, ValueKind] = MappingProxyType({})
) -> tuple[CompiledCode | None, list[Problem]]:
    """Return a program's code, and everything that is wrong with it.

    `known` are the kinds of the names that have a value already. There is no code if the program
    has a wrong shape or a value does not fit.
    """
    names = names_of(tree, frozenset(known))
    problems = list(shape_problems(tree, names))
    kinds = Kinds(names, known)
    for define, line in names.lines:
        problems += Fitting(kinds, define).line(line)
    if problems:
        return None, problems
    code = compiled(tree, names)
    return code, list(_Settled(code, frozenset(known)).problems())
