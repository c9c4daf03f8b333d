"""A checked tree becomes a flat list of instructions, the program's own first, then its parts'."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from armdrive.programs.acts import Mark
from armdrive.programs.instructions import Instruction, Op
from armdrive.programs.naming import only_shifted, own_names, subprograms, variables
from armdrive.programs.syntax import (
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
    Text,
    Tree,
    Truth,
    Unary,
    Use,
    While,
)
from armdrive.programs.vocabulary import HERE
from armdrive.programs.writing import written

LOOKING = ("depart", "depart_line", "draw")
"""Words that first have to know where the arm stands."""

GOING = ("move", "move_line", "move_with", "move_line_with", "approach", "approach_line",
         "depart", "depart_line", "draw", "ready")  # fmt: skip
"""Words that take what `open` and `close` said along."""

_NAMED = GOING[:6]
_SIGNS = {"-": Op.NEGATE, "not": Op.NOT}
_KEEPS = {"and": Op.KEEP_OFF, "or": Op.KEEP_ON}


@dataclass(frozen=True, slots=True)
class Code:
    """The instructions of a program, and where each subprogram begins, with its parameters."""

    instructions: tuple[Instruction, ...]
    entries: Mapping[str, int]


@dataclass(slots=True)
class _Scope:
    """Where the lines stand that are compiled now."""

    own: frozenset[str]
    labels: dict[str, int] = field(default_factory=dict)
    jumps: list[tuple[int, str]] = field(default_factory=list)
    loops: list[tuple[int, list[int]]] = field(default_factory=list)


def compiled(tree: Tree) -> Code:
    """Return the instructions of a tree that has been checked."""
    return _Compiler(tree).whole()


class _Compiler:
    def __init__(self, tree: Tree) -> None:
        self._tree = tree
        self._variables = variables(tree)
        self._shifted = only_shifted(tree)
        self._code: list[Instruction] = []
        self._calls: list[tuple[int, str]] = []
        self._scope = _Scope(frozenset())

    def whole(self) -> Code:
        self._part(self._tree.body, None)
        entries = {}
        for name, define in subprograms(self._tree).items():
            entries[name] = len(self._code)
            self._part(define.body, define)
        for index, name in self._calls:
            self._aim(index, entries[name])
        return Code(tuple(self._code), MappingProxyType(entries))

    def _part(self, body: tuple[Statement, ...], define: Define | None) -> None:
        self._scope = _Scope(own_names(define))
        mark = NOWHERE if define is None else define.mark
        for name in reversed(() if define is None else define.parameters):
            self._emit(Op.STORE_OWN, mark, name.lower())
        self._block(body)
        last = self._code[-1].mark if self._code else mark
        self._emit(Op.RETURN, last)
        for index, label in self._scope.jumps:
            self._aim(index, self._scope.labels[label])

    # -- the list ----------------------------------------------------------------------------

    def _emit(self, op: Op, mark: Mark, name: str = "", **more: object) -> int:
        self._code.append(Instruction(op, mark, name, **more))  # type: ignore[arg-type]
        return len(self._code) - 1

    def _aim(self, index: int, target: int | None = None) -> None:
        aimed = len(self._code) if target is None else target
        self._code[index] = replace(self._code[index], target=aimed)

    # -- lines -------------------------------------------------------------------------------

    def _block(self, body: tuple[Statement, ...]) -> None:
        for statement in body:
            if not isinstance(statement, Define | Remark):
                _STATEMENTS[type(statement)](self, statement)

    def _assign(self, line: Assign) -> None:
        self.value(line.value)
        self._store(line.name, line.mark)

    def _store(self, name: str, mark: Mark) -> None:
        low = name.lower()
        self._emit(Op.STORE_OWN if low in self._scope.own else Op.STORE, mark, low)

    def _call(self, line: Call) -> None:
        for value in line.arguments:
            self.value(value)
        name = line.name.lower()
        index = self._emit(Op.CALL, line.mark, name, count=len(line.arguments))
        self._calls.append((index, name))

    def _label(self, line: Label) -> None:
        self._scope.labels[line.name.lower()] = len(self._code)

    def _goto(self, line: Goto) -> None:
        self._scope.jumps.append((self._emit(Op.JUMP, line.mark), line.name.lower()))

    def _if(self, line: If) -> None:
        ends = []
        for branch in line.branches:
            miss = None
            if branch.condition is not None:
                self.value(branch.condition)
                miss = self._emit(Op.JUMP_UNLESS, branch.mark)
            self._block(branch.body)
            if branch is not line.branches[-1]:
                ends.append(self._emit(Op.JUMP, branch.mark))
            if miss is not None:
                self._aim(miss)
        for end in ends:
            self._aim(end)

    def _while(self, line: While) -> None:
        top = len(self._code)
        self.value(line.condition)
        miss = self._emit(Op.JUMP_UNLESS, line.mark)
        self._looped(line.body, top, miss, line.mark)

    def _repeat(self, line: Repeat) -> None:
        name = f"@{len(self._code)}"
        if line.count is None:
            self._emit(Op.FOREVER, line.mark, name)
        else:
            self.value(line.count)
            self._emit(Op.ROUNDS, line.mark, name)
        top = self._emit(Op.ROUND, line.mark, name)
        if line.variable:
            self._store(line.variable, line.mark)
        else:
            self._emit(Op.DROP, line.mark)
        self._looped(line.body, top, top, line.mark)

    def _looped(self, body: tuple[Statement, ...], top: int, miss: int, mark: Mark) -> None:
        breaks = [miss]
        self._scope.loops.append((top, breaks))
        self._block(body)
        self._scope.loops.pop()
        self._emit(Op.JUMP, mark, target=top)
        for index in breaks:
            self._aim(index)

    # -- words -------------------------------------------------------------------------------

    def _do(self, line: Do) -> None:
        _WORDS.get(line.word, _Compiler._act)(self, line)

    def _values(self, line: Do) -> int:
        for value in line.arguments:
            self.value(value)
        return len(line.arguments)

    def _act(self, line: Do) -> None:
        looking = line.word in LOOKING
        if looking:
            self._emit(Op.LOOK, line.mark)
        count = self._values(line) + looking
        if line.word in GOING:
            self._emit(Op.FINGERS, line.mark, line.word)
        about = written(line.arguments[0]) if line.word in _NAMED else ""
        self._emit(Op.ACT, line.mark, line.word, count=count, about=about)

    def _speed(self, line: Do) -> None:
        self._values(line)
        self._emit(Op.SPEED, line.mark)

    def _opening(self, line: Do) -> None:
        if line.word == "close":
            self._emit(Op.PUSH, line.mark, value=0.0)
        shut = line.word == "close"
        self._emit(Op.OPENING, line.mark, line.word, count=self._values(line) + shut)

    def _grasp(self, line: Do) -> None:
        self._emit(Op.ACT, line.mark, line.word, value=True)
        self._into(line)

    def _into(self, line: Do) -> None:
        name = dict(line.links).get("into")
        if name is not None and isinstance(name[0], Name):
            self._store(name[0].name, name[0].mark)
        else:
            self._emit(Op.DROP, line.mark)

    def _wait(self, line: Do) -> None:
        links = dict(line.links)
        limit = links.get("within", ())
        count = self._values(line)
        for value in limit:
            self.value(value)
        word = "wait within" if limit else line.word
        self._emit(Op.ACT, line.mark, word, value=True, count=count + len(limit))
        if "into" in links or not limit:
            self._into(line)
            return
        met = self._emit(Op.JUMP_IF, line.mark)
        wanted = ", ".join(written(value) for value in line.arguments)
        text = f"the inputs were not {wanted} within {written(limit[0])} s"
        self._emit(Op.FAIL, line.mark, value=text)
        self._aim(met)

    def _here(self, line: Do) -> None:
        self._emit(Op.LOOK, line.mark)
        name = line.arguments[0]
        if isinstance(name, Name):
            self._store(name.name, name.mark)
            if line.word == "remember":
                self.value(name)
                self._emit(Op.ACT, line.mark, line.word, count=1, about=name.name)

    def _shift(self, line: Do) -> None:
        count = self._values(line)
        for value in dict(line.links)["by"]:
            self.value(value)
        self._emit(Op.USE, line.mark, "shifted", count=count + 3)
        name = line.arguments[0]
        if isinstance(name, Name):
            self._store(name.name, name.mark)

    def _expect(self, line: Do) -> None:
        condition, *rest = line.arguments
        self.value(condition)
        met = self._emit(Op.JUMP_IF, line.mark)
        for value in rest:
            self.value(value)
        text = "" if rest else f"it was expected that {written(condition)}"
        self._emit(Op.FAIL, line.mark, value=text, count=len(rest))
        self._aim(met)

    def _stop(self, line: Do) -> None:
        count = self._values(line)
        if count:
            self._emit(Op.ACT, line.mark, "type", count=count)
        self._emit(Op.END, line.mark)

    def _return(self, line: Do) -> None:
        self._emit(Op.RETURN, line.mark)

    def _break(self, line: Do) -> None:
        self._scope.loops[-1][1].append(self._emit(Op.JUMP, line.mark))

    def _continue(self, line: Do) -> None:
        self._emit(Op.JUMP, line.mark, target=self._scope.loops[-1][0])

    # -- values ------------------------------------------------------------------------------

    def value(self, value: Expression) -> None:
        """Emit what pushes a value."""
        match value:
            case Number() | Truth() | Text():
                self._emit(Op.PUSH, value.mark, value=value.value)
            case Name():
                self._name(value)
            case Unary():
                self.value(value.value)
                self._emit(_SIGNS[value.sign], value.mark)
            case Binary():
                self._binary(value)
            case FieldOf():
                self.value(value.value)
                self._emit(Op.PART, value.mark, value.name)
            case Use():
                self._use(value)
            case JointsOf():
                for _, angle in value.angles:
                    self.value(angle)
                names = ",".join(name for name, _ in value.angles)
                self._emit(Op.JOINTS, value.mark, names, count=len(value.angles))

    def _name(self, value: Name) -> None:
        low = value.name.lower()
        if low == HERE:
            self._emit(Op.LOOK, value.mark)
        elif low in self._scope.own:
            self._emit(Op.LOAD_OWN, value.mark, low)
        elif low in self._shifted:
            self._emit(Op.LOAD_SHIFTED, value.mark, value.name)
        elif low in self._variables:
            self._emit(Op.LOAD, value.mark, low)
        else:
            self._emit(Op.LOAD_POINT, value.mark, value.name)

    def _binary(self, value: Binary) -> None:
        self.value(value.left)
        keep = _KEEPS.get(value.sign)
        if keep is None:
            self.value(value.right)
            self._emit(Op.BINARY, value.mark, value.sign)
        else:
            kept = self._emit(keep, value.mark)
            self.value(value.right)
            self._aim(kept)

    def _use(self, value: Use) -> None:
        (first, *_) = (*value.arguments, None)
        if value.name == "taught" and isinstance(first, Text):
            self._emit(Op.LOAD_POINT, value.mark, first.value)
            return
        for argument in value.arguments:
            self.value(argument)
        op = Op.INPUT if value.name == "input" else Op.USE
        self._emit(op, value.mark, value.name, count=len(value.arguments))


_STATEMENTS: Mapping[type, Callable[..., None]] = MappingProxyType({
    Assign: _Compiler._assign, Call: _Compiler._call, Label: _Compiler._label,
    Goto: _Compiler._goto, If: _Compiler._if, While: _Compiler._while,
    Repeat: _Compiler._repeat, Do: _Compiler._do,
})  # fmt: skip

_WORDS: Mapping[str, Callable[[_Compiler, Do], None]] = MappingProxyType({
    "speed": _Compiler._speed, "open": _Compiler._opening, "close": _Compiler._opening,
    "grasp": _Compiler._grasp, "wait": _Compiler._wait, "here": _Compiler._here,
    "remember": _Compiler._here, "shift": _Compiler._shift, "expect": _Compiler._expect,
    "stop": _Compiler._stop, "return": _Compiler._return, "break": _Compiler._break,
    "continue": _Compiler._continue,
})  # fmt: skip
