"""Emitting instructions: the list, the names in sight, and what pushes a value."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from armdrive.programs.acts import Mark
from armdrive.programs.instructions import Instruction, Op
from armdrive.programs.naming import only_shifted, variables
from armdrive.programs.syntax import (
    Do,
    Tree,
)
from armdrive.programs.terms import (
    Binary,
    Expression,
    FieldOf,
    JointsOf,
    Name,
    Number,
    Text,
    Truth,
    Unary,
    Use,
)
from armdrive.programs.vocabulary import HERE

_SIGNS = {"-": Op.NEGATE, "not": Op.NOT}
_KEEPS = {"and": Op.KEEP_OFF, "or": Op.KEEP_ON}


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

    def emit(self, op: Op, mark: Mark, name: str = "", **more: object) -> int:
        """Put an instruction behind the others, and return its number."""
        self.code.append(Instruction(op, mark, name, **more))  # type: ignore[arg-type]
        return len(self.code) - 1

    def aim(self, index: int, target: int | None = None) -> None:
        """Say where an instruction leads; without a target to what comes next."""
        aimed = len(self.code) if target is None else target
        self.code[index] = replace(self.code[index], target=aimed)

    def store(self, name: str, mark: Mark) -> None:
        """Emit what pops a value into a name."""
        low = name.lower()
        self.emit(Op.STORE_OWN if low in self.scope.own else Op.STORE, mark, low)

    def values(self, line: Do) -> int:
        """Emit what pushes the values of a word, and return how many there are."""
        for value in line.arguments:
            self.value(value)
        return len(line.arguments)

    def value(self, value: Expression) -> None:
        """Emit what pushes a value."""
        match value:
            case Number() | Truth() | Text():
                self.emit(Op.PUSH, value.mark, value=value.value)
            case Name():
                self._name(value)
            case Unary():
                self.value(value.value)
                self.emit(_SIGNS[value.sign], value.mark)
            case Binary():
                self._binary(value)
            case FieldOf():
                self.value(value.value)
                self.emit(Op.PART, value.mark, value.name)
            case Use():
                self._use(value)
            case JointsOf():
                for _, angle in value.angles:
                    self.value(angle)
                names = ",".join(name for name, _ in value.angles)
                self.emit(Op.JOINTS, value.mark, names, count=len(value.angles))

    def _name(self, value: Name) -> None:
        low = value.name.lower()
        if low == HERE:
            self.emit(Op.LOOK, value.mark)
        elif low in self.scope.own:
            self.emit(Op.LOAD_OWN, value.mark, low)
        elif low in self._shifted:
            self.emit(Op.LOAD_SHIFTED, value.mark, value.name)
        elif low in self._variables:
            self.emit(Op.LOAD, value.mark, low)
        else:
            self.emit(Op.LOAD_POINT, value.mark, value.name)

    def _binary(self, value: Binary) -> None:
        self.value(value.left)
        keep = _KEEPS.get(value.sign)
        if keep is None:
            self.value(value.right)
            self.emit(Op.BINARY, value.mark, value.sign)
        else:
            kept = self.emit(keep, value.mark)
            self.value(value.right)
            self.aim(kept)

    def _use(self, value: Use) -> None:
        (first, *_) = (*value.arguments, None)
        if value.name == "taught" and isinstance(first, Text):
            self.emit(Op.LOAD_POINT, value.mark, first.value)
            return
        for argument in value.arguments:
            self.value(argument)
        op = Op.INPUT if value.name == "input" else Op.USE
        self.emit(op, value.mark, value.name, count=len(value.arguments))
