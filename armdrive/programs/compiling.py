"""A checked tree becomes a flat list of instructions, the program's own first, then its parts'."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.programs.acts import Mark
from armdrive.programs.emitting import Scope
from armdrive.programs.instructions import Instruction, Op
from armdrive.programs.naming import own_names, subprograms
from armdrive.programs.syntax import (
    Assign,
    Call,
    Define,
    Do,
    Goto,
    If,
    Label,
    Remark,
    Repeat,
    Statement,
    Tree,
    While,
)
from armdrive.programs.terms import (
    NOWHERE,
)
from armdrive.programs.word_code import WORD_CODE, WordCode


@dataclass(frozen=True, slots=True)
class Code:
    """The instructions of a program, and where each subprogram begins, with its parameters."""

    instructions: tuple[Instruction, ...]
    entries: Mapping[str, int]


def compiled(tree: Tree, known: frozenset[str] = frozenset()) -> Code:
    """Return the instructions of a tree that has been checked; `known` have a value already."""
    return _Compiler(tree, known).whole()


class _Compiler(WordCode):
    def __init__(self, tree: Tree, known: frozenset[str]) -> None:
        super().__init__(tree, known)
        self._tree = tree
        self._calls: list[tuple[int, str]] = []

    def whole(self) -> Code:
        self._part(self._tree.body, None)
        entries = {}
        for name, define in subprograms(self._tree).items():
            entries[name] = len(self.code)
            self._part(define.body, define)
        for index, name in self._calls:
            self.aim(index, entries[name])
        return Code(tuple(self.code), MappingProxyType(entries))

    def _part(self, body: tuple[Statement, ...], define: Define | None) -> None:
        self.scope = Scope(own_names(define))
        mark = NOWHERE if define is None else define.mark
        for name in reversed(() if define is None else define.parameters):
            self.emit(Op.STORE_OWN, mark, name.lower())
        self._block(body)
        last = self.code[-1].mark if self.code else mark
        self.emit(Op.RETURN, last)
        for index, label in self.scope.jumps:
            self.aim(index, self.scope.labels[label])

    def _block(self, body: tuple[Statement, ...]) -> None:
        for statement in body:
            if not isinstance(statement, Define | Remark):
                _STATEMENTS[type(statement)](self, statement)

    def assign(self, line: Assign) -> None:
        self.value(line.value)
        self.store(line.name, line.mark)

    def call(self, line: Call) -> None:
        for value in line.arguments:
            self.value(value)
        name = line.name.lower()
        index = self.emit(Op.CALL, line.mark, name, count=len(line.arguments))
        self._calls.append((index, name))

    def label(self, line: Label) -> None:
        self.scope.labels[line.name.lower()] = len(self.code)

    def goto(self, line: Goto) -> None:
        self.scope.jumps.append((self.emit(Op.JUMP, line.mark), line.name.lower()))

    def if_(self, line: If) -> None:
        ends = []
        for branch in line.branches:
            miss = None
            if branch.condition is not None:
                self.value(branch.condition)
                miss = self.emit(Op.JUMP_UNLESS, branch.mark)
            self._block(branch.body)
            if branch is not line.branches[-1]:
                ends.append(self.emit(Op.JUMP, branch.mark))
            if miss is not None:
                self.aim(miss)
        for end in ends:
            self.aim(end)

    def while_(self, line: While) -> None:
        top = len(self.code)
        self.value(line.condition)
        miss = self.emit(Op.JUMP_UNLESS, line.mark)
        self._looped(line.body, top, miss, line.mark)

    def repeat(self, line: Repeat) -> None:
        name = f"@{len(self.code)}"
        if line.count is not None:
            self.value(line.count)
        self.emit(Op.FOREVER if line.count is None else Op.ROUNDS, line.mark, name)
        top = self.emit(Op.COUNT if line.count is None else Op.ROUND, line.mark, name)
        if line.variable:
            self.store(line.variable, line.mark)
        else:
            self.emit(Op.DROP, line.mark)
        self._looped(line.body, top, None if line.count is None else top, line.mark)

    def _looped(self, body: tuple[Statement, ...], top: int, miss: int | None, mark: Mark) -> None:
        breaks = [] if miss is None else [miss]
        self.scope.loops.append((top, breaks))
        self._block(body)
        self.scope.loops.pop()
        self.emit(Op.JUMP, mark, target=top)
        for index in breaks:
            self.aim(index)

    def do(self, line: Do) -> None:
        WORD_CODE.get(line.word, WordCode.act)(self, line)


_STATEMENTS: Mapping[type, Callable[..., None]] = MappingProxyType({
    Assign: _Compiler.assign, Call: _Compiler.call, Label: _Compiler.label,
    Goto: _Compiler.goto, If: _Compiler.if_, While: _Compiler.while_,
    Repeat: _Compiler.repeat, Do: _Compiler.do,
})  # fmt: skip
