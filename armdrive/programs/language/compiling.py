"""Compiles a checked tree to a flat list of instructions: the program's, then its subprograms'.

Each line is one instruction; blocks add instructions that jump. So a single number says where a run
is, whatever blocks it is in, and can be written down. Values stay trees.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

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
    Name,
    ProgramNames,
    Remark,
    Repeat,
    Statement,
    TextValue,
    Tree,
    Use,
    While,
    own_names,
    within,
)
from armdrive.programs.language.words import HERE
from armdrive.programs.language.writing import written
from armdrive.programs.problems import SourceMark

ASSIGN, UNLESS, JUMP, ROUNDS, ROUND, CALL = "=", "unless", "jump", "rounds", "round", "call"
"""The instructions that are not words: set a name; jump if a condition is off; jump in any case;
begin to count a loop's rounds; begin the next round, or leave the loop; call a subprogram with
values for its parameters.
"""

RETURN, STOP = "return", "stop"
"""Words after which no other instruction follows."""


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


NO_CODE = CompiledCode((), {}, {})
"""The instructions of a program that has not been checked yet."""


def compiled(tree: Tree, names: ProgramNames) -> CompiledCode:
    """Return the instructions of a tree that has been checked, and whose names are known."""
    return _Compiler(tree, names).whole()


@dataclass(slots=True)
class _Scope:
    """What the lines being compiled can refer to: parameters, labels, loops."""

    own: frozenset[str]
    labels: dict[str, int] = field(default_factory=dict)
    jumps: list[tuple[int, str]] = field(default_factory=list)
    loops: list[tuple[int, list[int]]] = field(default_factory=list)
    """For each loop its first instruction, and those that lead out of it."""


class _Compiler:
    """The list of instructions as it grows."""

    def __init__(self, tree: Tree, names: ProgramNames) -> None:
        self._tree = tree
        self._subprograms = names.subprograms
        self._code: list[Instruction] = []
        self._scope = _Scope(frozenset())
        self._calls: list[tuple[int, str]] = []
        self._points: dict[str, SourceMark] = {}
        self._variables = names.variables - names.only_shifted

    def whole(self) -> CompiledCode:
        self._part(self._tree.body, None)
        entries = {}
        for name, define in self._subprograms.items():
            entries[name] = len(self._code)
            self._part(define.body, define)
        for index, name in self._calls:
            self._aim(index, entries[name])
        entered, points = MappingProxyType(entries), MappingProxyType(self._points)
        return CompiledCode(tuple(self._code), entered, points)

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
            case Use(name="taught", arguments=(TextValue() as text, *_)):
                self._points.setdefault(text.value, text.mark)
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
        self._scope = _Scope(own_names(define))
        mark = NOWHERE if define is None else define.mark
        self._block(body)
        last = self._code[-1].mark if self._code else mark
        self._emit(RETURN, last)
        for index, label in self._scope.jumps:
            self._aim(index, self._scope.labels[label])

    def _block(self, body: tuple[Statement, ...]) -> None:
        for statement in body:
            self._line(statement)

    def _line(self, line: Statement) -> None:
        match line:
            case Define() | Remark():
                pass
            case Do():
                self._do(line)
            case Assign():
                self._emit(ASSIGN, line.mark, (line.value,), [line.name])
            case Call():
                define = self._subprograms[line.name.lower()]
                called = self._emit(CALL, line.mark, line.arguments, define.parameters)
                self._calls.append((called, line.name.lower()))
            case Label():
                self._scope.labels[line.name.lower()] = len(self._code)
            case Goto():
                self._scope.jumps.append((self._emit(JUMP, line.mark), line.name.lower()))
            case If():
                self._if(line)
            case While():
                top = len(self._code)
                miss = self._emit(UNLESS, line.mark, (line.condition,))
                self._looped(line, top, [miss])
            case Repeat():
                self._emit(ROUNDS, line.mark, _maybe(line.count))
                top = self._emit(ROUND, line.mark, into=[line.variable] * bool(line.variable))
                self._looped(line, top, [top] * (line.count is not None))

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
        links = dict(line.links)
        into = [value.name for value in links.get("into", ()) if isinstance(value, Name)]
        match line.word:
            case "break":
                self._scope.loops[-1][1].append(self._emit(JUMP, line.mark))
            case "continue":
                self._emit(JUMP, line.mark, target=self._scope.loops[-1][0])
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
