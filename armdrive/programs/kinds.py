"""Of which kind every name of a program is: found out from the lines that give it a value."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from armdrive.programs.naming import own_names, scoped, set_by, subprograms, variables
from armdrive.programs.syntax import Assign, Call, Define, Tree
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
from armdrive.programs.vocabulary import FUNCTIONS, HERE, Kind

ARITHMETIC = ("+", "-", "*", "/")
"""What gives a number of two numbers; all else that stands between two values gives on or off."""


class Kinds:
    """The kinds of a program's names. A name has one kind, which its first value decides."""

    def __init__(self, tree: Tree, known: Mapping[str, Kind] = MappingProxyType({})) -> None:
        self.variables = variables(tree) | known.keys()
        self.subprograms = subprograms(tree)
        self._kinds = {("", name): kind for name, kind in known.items()}
        lines = list(scoped(tree))
        while True:
            found = len(self._kinds)
            for define, line in lines:
                self._learn(define, line)
            if len(self._kinds) == found:
                return

    def _learn(self, define: Define | None, line: object) -> None:
        if isinstance(line, Call):
            self._learn_call(define, line)
            return
        for name, _, kind in set_by(line):  # type: ignore[arg-type]
            if kind is None and isinstance(line, Assign):
                kind = Kind.PLACE if line.point else self.of(line.value, define)
            if kind is not None:
                self._kinds.setdefault(_scope(name, define), kind)

    def _learn_call(self, define: Define | None, line: Call) -> None:
        called = self.subprograms.get(line.name.lower())
        if called is None:
            return
        for name, value in zip(called.parameters, line.arguments, strict=False):
            kind = self.of(value, define)
            if kind is not None:
                self._kinds.setdefault(_scope(name.lower(), called), kind)

    def of_name(self, name: str, define: Define | None) -> Kind | None:
        """Return the kind of a name; None where nothing tells."""
        low = name.lower()
        if self.nowhere(name, define) or low == HERE:
            return Kind.PLACE
        return self._kinds.get(_scope(low, define))

    def nowhere(self, name: str, define: Define | None) -> bool:
        """Say whether the program itself sets a name nowhere: then it is a point of the book."""
        low = name.lower()
        return low != HERE and low not in own_names(define) and low not in self.variables

    def of(self, value: Expression, define: Define | None) -> Kind | None:
        """Return the kind of a value; None where nothing tells."""
        match value:
            case Number() | FieldOf():
                return Kind.NUMBER
            case Truth():
                return Kind.TRUTH
            case Text():
                return Kind.TEXT
            case JointsOf():
                return Kind.PLACE
            case Name():
                return self.of_name(value.name, define)
            case Unary():
                return Kind.NUMBER if value.sign == "-" else Kind.TRUTH
            case Binary():
                return Kind.NUMBER if value.sign in ARITHMETIC else Kind.TRUTH
            case Use():
                row = FUNCTIONS.get(value.name)
                return None if row is None else row.gives


def _scope(name: str, define: Define | None) -> tuple[str, str]:
    """Parameters belong to their subprogram, all other names to the program."""
    own = define is not None and name in own_names(define)
    return (define.name.lower() if own and define is not None else "", name)
