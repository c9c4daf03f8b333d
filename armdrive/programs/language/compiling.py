"""Checks a program as a whole, and compiles it to a flat list of instructions.

The program's instructions come first, then those of its subprograms. Everything that is wrong is
reported at once.

Each line is one instruction; blocks add instructions that jump. So a single number says where a run
is, whatever blocks it is in, and can be written down. Values stay trees. For example:

    repeat 2 as i           0  rounds 2          the rounds in all
                            1  round into i      the next round, or on at 6 after the last one
      if i > 1              2  unless i > 1      on at 4
        fetch(i)            3  call i into x     on at 7, and back to 4
      end
      ready                 4  ready
    end                     5  jump              to 1
                            6  return            ends the program
    define fetch(x)
      type x                7  type x
    end                     8  return            to the line after the call
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from armdrive.programs.language.checking import Fitting, Kinds
from armdrive.programs.language.grammar import unknown_word
from armdrive.programs.language.syntax import (
    NOWHERE,
    Assign,
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
    names_of,
    own_names,
    set_by,
    within,
)
from armdrive.programs.language.words import HERE, RESERVED, SHAPES, WORDS, ValueKind
from armdrive.programs.language.writing import written
from armdrive.programs.problems import Problem, SourceMark
from kinematics.errors import suggestion

# The instructions that are not words: set a name; jump if a condition is off; jump in any case;
# begin to count a loop's rounds; begin the next round, or leave the loop; call a subprogram with
# values for its parameters.
ASSIGN, UNLESS, JUMP, ROUNDS, ROUND, CALL = "=", "unless", "jump", "rounds", "round", "call"

# Words after which no other instruction follows.
RETURN, STOP = "return", "stop"


@dataclass(frozen=True, slots=True)
class Instruction:
    """One instruction: a word or one of the above, and its place in the program.

    `into` are the names, in lower case, that it sets; `limit` is the time limit of `wait_input`;
    `target` is the instruction that it may jump to. `reads` and `sets` are the program's own names
    that it uses and sets, without parameters.
    """

    word: str
    mark: SourceMark
    values: tuple[Expression, ...] = ()
    into: tuple[str, ...] = ()
    limit: Expression | None = None
    target: int = 0
    reads: tuple[Name, ...] = ()
    sets: frozenset[str] = frozenset()

    @property
    def plain(self) -> tuple[object, ...]:
        """The instruction without its place."""
        limit = None if self.limit is None else written(self.limit)
        return (self.word, [*map(written, self.values)], self.into, limit, self.target)


@dataclass(frozen=True, slots=True)
class CompiledCode:
    """The instructions of a program, where each subprogram begins, and the points that it needs.

    `points` are those of the arm's book, with the place where each is named first.
    """

    instructions: tuple[Instruction, ...]
    entries: Mapping[str, int]
    points: Mapping[str, SourceMark]


# The instructions of a program that has not been checked yet.
NO_CODE = CompiledCode((), {}, {})


def checked(
    tree: Tree, known: Mapping[str, ValueKind] = MappingProxyType({})
) -> tuple[CompiledCode, list[Problem]]:
    """Return a program's code, and everything that is wrong with it.

    `known` are the kinds of the names that have a value already. The code of a wrong program is of
    no use.
    """
    names = names_of(tree, frozenset(known))
    compiler = _Compiler(names, Kinds(names, known))
    code = compiler.whole(tree)
    problems = compiler.problems or [*_Settled(code, frozenset(known)).problems()]
    return code, problems


@dataclass(slots=True)
class _Scope:
    """What the lines being compiled can refer to: parameters, labels, loops.

    `visible` are the labels of the present block and of those around it.
    """

    define: Define | None = None
    own: frozenset[str] = frozenset()
    visible: frozenset[str] = frozenset()
    labels: dict[str, int] = field(default_factory=dict)
    jumps: list[tuple[int, str]] = field(default_factory=list)
    loops: list[tuple[int, list[int]]] = field(default_factory=list)
    """For each loop its first instruction, and those that lead out of it."""


class _Compiler:
    """The list of instructions as it grows, and what is wrong with the program."""

    def __init__(self, names: ProgramNames, kinds: Kinds) -> None:
        self.problems: list[Problem] = []
        self._subprograms = names.subprograms
        self._kinds = kinds
        self._code: list[Instruction] = []
        self._scope = _Scope()
        self._calls: list[tuple[int, str]] = []
        self._points: dict[str, SourceMark] = {}
        self._all_variables = names.variables
        self._variables = names.variables - names.only_shifted

    def whole(self, tree: Tree) -> CompiledCode:
        """Compile a program and its subprograms."""
        self._part(tree.body, None)
        entries: dict[str, int] = {}
        for define in tree.body:
            if isinstance(define, Define):
                self._heading(define, entries)
                entries.setdefault(define.name.lower(), len(self._code))
                self._part(define.body, define)
        # a subprogram may be called before its definition, so calls are aimed last
        for index, name in self._calls:
            self._aim(index, entries[name])
        entered, points = MappingProxyType(entries), MappingProxyType(self._points)
        return CompiledCode(tuple(self._code), entered, points)

    def _wrong(self, mark: SourceMark, text: str) -> None:
        self.problems.append(Problem(mark, text))

    def _heading(self, define: Define, entries: Mapping[str, int]) -> None:
        """Check the names of a subprogram and of its parameters."""
        name, mark = define.name, define.mark
        if name.lower() in entries:
            self._wrong(mark, f"there is already a subprogram {name!r}")
        if name.lower() in self._all_variables | own_names(define):
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

    # -- instructions ------------------------------------------------------------------------

    def _emit(
        self,
        word: str,
        mark: SourceMark,
        values: tuple[Expression, ...] = (),
        into: Iterable[str] = (),
        limit: Expression | None = None,
        target: int = 0,
    ) -> int:
        """Append an instruction, and return its number."""
        used = (each for value in (*values, *_maybe(limit)) for each in within(value))
        reads = tuple(each for each in used if self._needs(each) and isinstance(each, Name))
        names = tuple(name.lower() for name in into)
        sets = frozenset(() if word == CALL else names) - self._scope.own
        self._code.append(Instruction(word, mark, values, names, limit, target, reads, sets))
        return len(self._code) - 1

    def _needs(self, value: Expression) -> bool:
        """Return whether a value is one of the program's names; note a point of the arm's book."""
        match value:
            case Use(name="taught", arguments=(Literal(value=str(name)) as text, *_)):
                self._points.setdefault(name, text.mark)
            case Name(name=name) if name.lower() not in (HERE, *self._scope.own):
                if name.lower() in self._variables:
                    return True
                self._points.setdefault(name, value.mark)
        return False

    def _aim(self, index: int, target: int | None = None) -> None:
        """Set where an instruction jumps to; without a target to the next instruction."""
        aimed = len(self._code) if target is None else target
        self._code[index] = replace(self._code[index], target=aimed)

    # -- lines -------------------------------------------------------------------------------

    def _part(self, body: tuple[Statement, ...], define: Define | None) -> None:
        self._scope = _Scope(define, own_names(define))
        mark = NOWHERE if define is None else define.mark
        self._block(body)
        last = self._code[-1].mark if self._code else mark
        # also after the program itself, where it ends the run
        self._emit(RETURN, last)
        for index, label in self._scope.jumps:
            self._aim(index, self._scope.labels[label])

    def _block(self, body: tuple[Statement, ...]) -> None:
        scope, outer = self._scope, self._scope.visible
        scope.visible |= {line.name.lower() for line in body if isinstance(line, Label)}
        for line in body:
            if not isinstance(line, Define):
                self._line(line)
        scope.visible = outer

    def _line(self, line: Statement) -> None:
        wrong = list(Fitting(self._kinds, self._scope.define).line(line))
        self.problems += wrong
        for each, _ in set_by(line):
            self._require_free(each.name, each.mark)
        match line:
            case Do() if not wrong:
                self._do(line)
            case Assign():
                self._emit(ASSIGN, line.mark, (line.value,), [line.name])
            case Call():
                self._call(line)
            case Label(name=name):
                if name.lower() in self._scope.labels:
                    self._wrong(line.mark, f"there is already a label {name!r}")
                self._scope.labels[name.lower()] = len(self._code)
            case Goto(name=name):
                if name.lower() in self._scope.visible:
                    self._scope.jumps.append((self._emit(JUMP, line.mark), name.lower()))
                else:
                    self._wrong(line.mark, _no_label(name, self._scope.visible))
            case If():
                self._if(line)
            case While():
                top = len(self._code)
                miss = self._emit(UNLESS, line.mark, (line.condition,))
                self._looped(line, top, [miss])
            case Repeat():
                self._emit(ROUNDS, line.mark, _maybe(line.count))
                top = self._emit(ROUND, line.mark, into=[line.variable] * bool(line.variable))
                # without a count only `break`, `goto` and `return` lead out of it
                self._looped(line, top, [top] * (line.count is not None))

    def _call(self, line: Call) -> None:
        define = self._subprograms.get(line.name.lower())
        if define is None:
            names = (*(each.name for each in self._subprograms.values()), *WORDS, *SHAPES)
            unknown = f"there is no word and no subprogram {line.name!r}"
            self._wrong(line.mark, unknown_word(line.name, names) or unknown)
            return
        called = self._emit(CALL, line.mark, line.arguments, define.parameters)
        self._calls.append((called, line.name.lower()))

    def _if(self, line: If) -> None:
        ends = []
        for branch in line.branches:
            miss = None
            if branch.condition is not None:
                miss = self._emit(UNLESS, branch.mark, (branch.condition,))
            self._block(branch.body)
            if branch is not line.branches[-1]:
                ends.append(self._emit(JUMP, branch.mark))
            if miss is not None:
                self._aim(miss)
        # each branch but the last ends with a jump over those after it
        for end in ends:
            self._aim(end)

    def _looped(self, line: While | Repeat, top: int, exits: list[int]) -> None:
        self._scope.loops.append((top, exits))
        self._block(line.body)
        self._scope.loops.pop()
        self._emit(JUMP, line.mark, target=top)
        for index in exits:
            self._aim(index)

    def _do(self, line: Do) -> None:
        loops, links = self._scope.loops, dict(line.links)
        into = [value.name for value in links.get("into", ()) if isinstance(value, Name)]
        match line.word:
            case "break" | "continue" if not loops:
                self._wrong(line.mark, f"`{line.word}` is allowed in a loop only")
            case "break":
                loops[-1][1].append(self._emit(JUMP, line.mark))
            case "continue":
                self._emit(JUMP, line.mark, target=loops[-1][0])
            case "return" if self._scope.define is None:
                text = "`return` is allowed in a subprogram only; `stop` ends the program"
                self._wrong(line.mark, text)
            case "here" | "remember":
                (name,) = line.arguments
                self._emit("here", line.mark, into=[written(name)])
                if line.word == "remember":
                    self._emit(line.word, line.mark, (name,))
            case "shift":
                (name,) = line.arguments
                self._emit(line.word, line.mark, (name, *links["by"]), [written(name)])
            case _:
                (limit,) = links.get("within", (None,))
                self._emit(line.word, line.mark, line.arguments, into, limit)


def _maybe(value: Expression | None) -> tuple[Expression, ...]:
    return () if value is None else (value,)


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

# Names without a value where they are used, to the line of a call that leads there.
_Needs = dict[tuple[str, SourceMark], int | None]


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
        # begin with all names, and take away what some path does not set, until nothing changes
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
        # a subprogram may be called from anywhere: where it begins, nothing is certain
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
