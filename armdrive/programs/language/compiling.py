"""A checked tree becomes a flat list of instructions, the program's own first, then its parts'."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from types import MappingProxyType

from armdrive.programs.language.syntax import (
    NOWHERE,
    Assign,
    Binary,
    Call,
    Define,
    Do,
    Expression,
    FieldOf,
    Goto,
    If,
    JointsOf,
    Label,
    Name,
    Number,
    Remark,
    Repeat,
    Statement,
    TextValue,
    Tree,
    Truth,
    Unary,
    Use,
    While,
    only_shifted,
    own_names,
    subprograms,
    variables,
)
from armdrive.programs.language.values import Value
from armdrive.programs.language.words import HERE
from armdrive.programs.language.writing import written
from armdrive.programs.problems import SourceMark

# What a program is compiled to: a flat list of small instructions over a stack of values.


class OpCode(Enum):
    """What an instruction does; in brackets what it finds in `name`, `value`, `target`, `count`."""

    PUSH = "push a constant (value)"
    LOAD = "push a variable (name)"
    LOAD_OWN = "push a parameter (name)"
    LOAD_POINT = "push a point of the arm's own book (name)"
    LOAD_SHIFTED = "push a variable, or the book's point while it has not been shifted (name)"
    STORE = "pop into a variable (name)"
    STORE_OWN = "pop into a parameter (name)"
    DROP = "pop"
    NEGATE = "the other sign"
    NOT = "the other truth"
    BINARY = "two values and what stands between them (name)"
    USE = "a function (name) of so many values (count)"
    PART = "a part of a place (name)"
    JOINTS = "a place of so many angles (count), their joints between commas (name)"
    JUMP = "go on elsewhere (target)"
    JUMP_UNLESS = "pop, and go on elsewhere if it is off (target)"
    JUMP_IF = "pop, and go on elsewhere if it is on (target)"
    KEEP_OFF = "go on elsewhere if it is off, else pop (target)"
    KEEP_ON = "go on elsewhere if it is on, else pop (target)"
    ROUNDS = "pop how many rounds a loop (name) has"
    FOREVER = "a loop (name) has no end"
    COUNT = "push the round's number of a loop without an end (name)"
    ROUND = "push the round's number (name), or go on behind the loop (target)"
    CALL = "call a subprogram (target) with so many values (count)"
    RETURN = "leave a subprogram; in the program itself, end it"
    END = "end the program"
    FAIL = "end the program with an error of so many values (count), or of a text (value)"
    SPEED = "pop the speed"
    OPENING = "the fingers' opening with the next move: pop it (count 1), or all the way"
    FINGERS = "the act of that opening, where the next move (name) cannot have it along"
    LOOK = "the act of looking: push the place"
    INPUT = "the act of reading an input: pop its number, push on or off"
    ACT = "the act of a word (name) of so many values (count); pushes its answer if (value)"


@dataclass(frozen=True, slots=True)
class Instruction:
    """One instruction, and where in the program it comes from."""

    op: OpCode
    mark: SourceMark
    name: str = ""
    value: Value | None = None
    target: int = 0
    count: int = 0
    about: str = ""
    """What the program calls the place that an act goes to."""


# Emitting instructions: the list, the names in sight, and what pushes a value.

_SIGNS = {"-": OpCode.NEGATE, "not": OpCode.NOT}
_KEEPS = {"and": OpCode.KEEP_OFF, "or": OpCode.KEEP_ON}


@dataclass(slots=True)
class Scope:
    """What can be seen from the lines that are compiled now: parameters, labels, loops."""

    own: frozenset[str]
    labels: dict[str, int] = field(default_factory=dict)
    jumps: list[tuple[int, str]] = field(default_factory=list)
    loops: list[tuple[int, list[int]]] = field(default_factory=list)


class Emitter:
    """The list of instructions as it grows."""

    def __init__(self, tree: Tree, known: frozenset[str] = frozenset()) -> None:
        self.code: list[Instruction] = []
        self.scope = Scope(frozenset())
        self._variables = variables(tree) | known
        self._shifted = only_shifted(tree) - known

    def emit(self, op: OpCode, mark: SourceMark, name: str = "", **more: object) -> int:
        """Put an instruction behind the others, and return its number."""
        self.code.append(Instruction(op, mark, name, **more))  # type: ignore[arg-type]
        return len(self.code) - 1

    def aim(self, index: int, target: int | None = None) -> None:
        """Say where an instruction leads; without a target to what comes next."""
        aimed = len(self.code) if target is None else target
        self.code[index] = replace(self.code[index], target=aimed)

    def store(self, name: str, mark: SourceMark) -> None:
        """Emit what pops a value into a name."""
        low = name.lower()
        self.emit(OpCode.STORE_OWN if low in self.scope.own else OpCode.STORE, mark, low)

    def values(self, line: Do) -> int:
        """Emit what pushes the values of a word, and return how many there are."""
        for value in line.arguments:
            self.value(value)
        return len(line.arguments)

    def value(self, value: Expression) -> None:
        """Emit what pushes a value."""
        match value:
            case Number() | Truth() | TextValue():
                self.emit(OpCode.PUSH, value.mark, value=value.value)
            case Name():
                self._name(value)
            case Unary():
                self.value(value.value)
                self.emit(_SIGNS[value.sign], value.mark)
            case Binary():
                self._binary(value)
            case FieldOf():
                self.value(value.value)
                self.emit(OpCode.PART, value.mark, value.name)
            case Use():
                self._use(value)
            case JointsOf():
                for _, angle in value.angles:
                    self.value(angle)
                names = ",".join(name for name, _ in value.angles)
                self.emit(OpCode.JOINTS, value.mark, names, count=len(value.angles))

    def _name(self, value: Name) -> None:
        low = value.name.lower()
        if low == HERE:
            self.emit(OpCode.LOOK, value.mark)
        elif low in self.scope.own:
            self.emit(OpCode.LOAD_OWN, value.mark, low)
        elif low in self._shifted:
            self.emit(OpCode.LOAD_SHIFTED, value.mark, value.name)
        elif low in self._variables:
            self.emit(OpCode.LOAD, value.mark, low)
        else:
            self.emit(OpCode.LOAD_POINT, value.mark, value.name)

    def _binary(self, value: Binary) -> None:
        self.value(value.left)
        keep = _KEEPS.get(value.sign)
        if keep is None:
            self.value(value.right)
            self.emit(OpCode.BINARY, value.mark, value.sign)
        else:
            kept = self.emit(keep, value.mark)
            self.value(value.right)
            self.aim(kept)

    def _use(self, value: Use) -> None:
        (first, *_) = (*value.arguments, None)
        if value.name == "taught" and isinstance(first, TextValue):
            self.emit(OpCode.LOAD_POINT, value.mark, first.value)
            return
        for argument in value.arguments:
            self.value(argument)
        op = OpCode.INPUT if value.name == "input" else OpCode.USE
        self.emit(op, value.mark, value.name, count=len(value.arguments))


# What each word is compiled to.

# ruff: noqa: D102 - the methods are named for the words


LOOKING = ("depart", "depart_line", "draw")
"""Words that first have to know where the arm stands."""

GOING = ("move", "move_line", "move_with", "move_line_with", "approach", "approach_line",
         "depart", "depart_line", "draw", "ready")  # fmt: skip
"""Words that take what `open` and `close` said along."""

_NAMED = GOING[:6]


class WordCode(Emitter):
    """Emits the words; most are an act of their values, see `act`."""

    def act(self, line: Do) -> None:
        looking = line.word in LOOKING
        if looking:
            self.emit(OpCode.LOOK, line.mark)
        count = self.values(line) + looking
        if line.word in GOING:
            self.emit(OpCode.FINGERS, line.mark, line.word)
        about = written(line.arguments[0]) if line.word in _NAMED else ""
        self.emit(OpCode.ACT, line.mark, line.word, count=count, about=about)

    def speed(self, line: Do) -> None:
        self.values(line)
        self.emit(OpCode.SPEED, line.mark)

    def opening(self, line: Do) -> None:
        if line.word == "close":
            self.emit(OpCode.PUSH, line.mark, value=0.0)
        shut = line.word == "close"
        self.emit(OpCode.OPENING, line.mark, line.word, count=self.values(line) + shut)

    def grasp(self, line: Do) -> None:
        self.emit(OpCode.ACT, line.mark, line.word, value=True)
        self.into(line)

    def into(self, line: Do) -> None:
        name = dict(line.links).get("into")
        if name is not None and isinstance(name[0], Name):
            self.store(name[0].name, name[0].mark)
        else:
            self.emit(OpCode.DROP, line.mark)

    def wait(self, line: Do) -> None:
        links = dict(line.links)
        limit = links.get("within", ())
        count = self.values(line)
        for value in limit:
            self.value(value)
        word = "wait within" if limit else line.word
        self.emit(OpCode.ACT, line.mark, word, value=True, count=count + len(limit))
        if "into" in links or not limit:
            self.into(line)
            return
        met = self.emit(OpCode.JUMP_IF, line.mark)
        wanted = ", ".join(written(value) for value in line.arguments)
        text = f"the inputs were not {wanted} within {written(limit[0])} s"
        self.emit(OpCode.FAIL, line.mark, value=text)
        self.aim(met)

    def here(self, line: Do) -> None:
        self.emit(OpCode.LOOK, line.mark)
        name = line.arguments[0]
        if isinstance(name, Name):
            self.store(name.name, name.mark)
            if line.word == "remember":
                self.value(name)
                self.emit(OpCode.ACT, line.mark, line.word, count=1, about=name.name)

    def shift(self, line: Do) -> None:
        count = self.values(line)
        for value in dict(line.links)["by"]:
            self.value(value)
        self.emit(OpCode.USE, line.mark, "shifted", count=count + 3)
        name = line.arguments[0]
        if isinstance(name, Name):
            self.store(name.name, name.mark)

    def expect(self, line: Do) -> None:
        condition, *rest = line.arguments
        self.value(condition)
        met = self.emit(OpCode.JUMP_IF, line.mark)
        for value in rest:
            self.value(value)
        text = "" if rest else f"it was expected that {written(condition)}"
        self.emit(OpCode.FAIL, line.mark, value=text, count=len(rest))
        self.aim(met)

    def stop(self, line: Do) -> None:
        count = self.values(line)
        if count:
            self.emit(OpCode.ACT, line.mark, "type", count=count)
        self.emit(OpCode.END, line.mark)

    def return_(self, line: Do) -> None:
        self.emit(OpCode.RETURN, line.mark)

    def break_(self, line: Do) -> None:
        self.scope.loops[-1][1].append(self.emit(OpCode.JUMP, line.mark))

    def continue_(self, line: Do) -> None:
        self.emit(OpCode.JUMP, line.mark, target=self.scope.loops[-1][0])


WORD_CODE: Mapping[str, Callable[[WordCode, Do], None]] = MappingProxyType({
    "speed": WordCode.speed, "open": WordCode.opening, "close": WordCode.opening,
    "grasp": WordCode.grasp, "wait": WordCode.wait, "here": WordCode.here,
    "remember": WordCode.here, "shift": WordCode.shift, "expect": WordCode.expect,
    "stop": WordCode.stop, "return": WordCode.return_, "break": WordCode.break_,
    "continue": WordCode.continue_,
})  # fmt: skip
"""The words that are more than an act of their values."""


@dataclass(frozen=True, slots=True)
class CompiledCode:
    """The instructions of a program, and where each subprogram begins, with its parameters."""

    instructions: tuple[Instruction, ...]
    entries: Mapping[str, int]


def compiled(tree: Tree, known: frozenset[str] = frozenset()) -> CompiledCode:
    """Return the instructions of a tree that has been checked; `known` have a value already."""
    return _Compiler(tree, known).whole()


class _Compiler(WordCode):
    def __init__(self, tree: Tree, known: frozenset[str]) -> None:
        super().__init__(tree, known)
        self._tree = tree
        self._calls: list[tuple[int, str]] = []

    def whole(self) -> CompiledCode:
        self._part(self._tree.body, None)
        entries = {}
        for name, define in subprograms(self._tree).items():
            entries[name] = len(self.code)
            self._part(define.body, define)
        for index, name in self._calls:
            self.aim(index, entries[name])
        return CompiledCode(tuple(self.code), MappingProxyType(entries))

    def _part(self, body: tuple[Statement, ...], define: Define | None) -> None:
        self.scope = Scope(own_names(define))
        mark = NOWHERE if define is None else define.mark
        for name in reversed(() if define is None else define.parameters):
            self.emit(OpCode.STORE_OWN, mark, name.lower())
        self._block(body)
        last = self.code[-1].mark if self.code else mark
        self.emit(OpCode.RETURN, last)
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
        index = self.emit(OpCode.CALL, line.mark, name, count=len(line.arguments))
        self._calls.append((index, name))

    def label(self, line: Label) -> None:
        self.scope.labels[line.name.lower()] = len(self.code)

    def goto(self, line: Goto) -> None:
        self.scope.jumps.append((self.emit(OpCode.JUMP, line.mark), line.name.lower()))

    def if_(self, line: If) -> None:
        ends = []
        for branch in line.branches:
            miss = None
            if branch.condition is not None:
                self.value(branch.condition)
                miss = self.emit(OpCode.JUMP_UNLESS, branch.mark)
            self._block(branch.body)
            if branch is not line.branches[-1]:
                ends.append(self.emit(OpCode.JUMP, branch.mark))
            if miss is not None:
                self.aim(miss)
        for end in ends:
            self.aim(end)

    def while_(self, line: While) -> None:
        top = len(self.code)
        self.value(line.condition)
        miss = self.emit(OpCode.JUMP_UNLESS, line.mark)
        self._looped(line.body, top, miss, line.mark)

    def repeat(self, line: Repeat) -> None:
        name = f"@{len(self.code)}"
        if line.count is not None:
            self.value(line.count)
        self.emit(OpCode.FOREVER if line.count is None else OpCode.ROUNDS, line.mark, name)
        top = self.emit(OpCode.COUNT if line.count is None else OpCode.ROUND, line.mark, name)
        if line.variable:
            self.store(line.variable, line.mark)
        else:
            self.emit(OpCode.DROP, line.mark)
        self._looped(line.body, top, None if line.count is None else top, line.mark)

    def _looped(
        self, body: tuple[Statement, ...], top: int, miss: int | None, mark: SourceMark
    ) -> None:
        breaks = [] if miss is None else [miss]
        self.scope.loops.append((top, breaks))
        self._block(body)
        self.scope.loops.pop()
        self.emit(OpCode.JUMP, mark, target=top)
        for index in breaks:
            self.aim(index)

    def do(self, line: Do) -> None:
        WORD_CODE.get(line.word, WordCode.act)(self, line)


_STATEMENTS: Mapping[type, Callable[..., None]] = MappingProxyType({
    Assign: _Compiler.assign, Call: _Compiler.call, Label: _Compiler.label,
    Goto: _Compiler.goto, If: _Compiler.if_, While: _Compiler.while_,
    Repeat: _Compiler.repeat, Do: _Compiler.do,
})  # fmt: skip
