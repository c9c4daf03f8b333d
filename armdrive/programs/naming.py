"""Which names a program's lines set, and which values they use: from the table of words alone."""

from __future__ import annotations

from collections.abc import Iterator

from armdrive.programs.acts import Mark
from armdrive.programs.bounds import slot_of
from armdrive.programs.syntax import (
    Assign,
    Call,
    Define,
    Do,
    If,
    Repeat,
    Statement,
    Tree,
    While,
    bodies,
)
from armdrive.programs.terms import (
    Expression,
    Name,
)
from armdrive.programs.vocabulary import WORDS, Kind, Slot


def slotted(do: Do) -> Iterator[tuple[Expression, Slot]]:
    """Yield the values of a word with their slots; those that belong to none are left out."""
    word = WORDS[do.word]
    known = dict(word.links)
    rows = [(do.arguments, word.slots)]
    rows += [(values, known.get(link, ())) for link, values in do.links]
    for values, slots in rows:
        for index, value in enumerate(values):
            slot = slot_of(slots, index)
            if slot is not None:
                yield value, slot


def set_by(statement: Statement) -> Iterator[tuple[str, Mark, Kind | None]]:
    """Yield the names that a line itself sets, in lower case, and of which kind it makes them.

    None is the kind of the value that is assigned.
    """
    match statement:
        case Assign():
            yield statement.name.lower(), statement.mark, None
        case Repeat():
            if statement.variable:
                yield statement.variable.lower(), statement.mark, Kind.NUMBER
        case Do():
            for value, slot in slotted(statement):
                if slot.sets and isinstance(value, Name):
                    yield value.name.lower(), value.mark, slot.kind


def used_by(statement: Statement) -> Iterator[Expression]:
    """Yield the values that a line itself uses, without the lines within it."""
    match statement:
        case Assign():
            yield statement.value
        case Call():
            yield from statement.arguments
        case While():
            yield statement.condition
        case Repeat():
            if statement.count is not None:
                yield statement.count
        case If():
            for branch in statement.branches:
                if branch.condition is not None:
                    yield branch.condition
        case Do():
            yield from (value for value, slot in slotted(statement) if not slot.sets)


def every(body: tuple[Statement, ...]) -> Iterator[Statement]:
    """Yield every statement of a body and of the blocks within it, in the order of lines."""
    for statement in body:
        yield statement
        for block in bodies(statement):
            yield from every(block)


def subprograms(tree: Tree) -> dict[str, Define]:
    """Return the subprograms by their names in lower case, the first of each name."""
    found: dict[str, Define] = {}
    for statement in tree.body:
        if isinstance(statement, Define):
            found.setdefault(statement.name.lower(), statement)
    return found


def own_names(define: Define | None) -> frozenset[str]:
    """Return the parameters of a subprogram in lower case; none of the program itself."""
    return frozenset(() if define is None else (name.lower() for name in define.parameters))


def scoped(tree: Tree) -> Iterator[tuple[Define | None, Statement]]:
    """Yield every statement with the subprogram that it stands in, None for the program itself."""
    for statement in tree.body:
        define = statement if isinstance(statement, Define) else None
        inner = every((statement,) if define is None else define.body)
        yield from ((define, each) for each in inner if not isinstance(each, Define))


def variables(tree: Tree) -> frozenset[str]:
    """Return the names that the program sets anywhere, parameters left out."""
    return frozenset(
        name
        for define, statement in scoped(tree)
        for name, _, _ in set_by(statement)
        if name not in own_names(define)
    )


def only_shifted(tree: Tree) -> frozenset[str]:
    """Return the names that nothing sets but `shift`: they begin as points of the arm's book."""
    by_others = {
        name
        for define, statement in scoped(tree)
        if not (isinstance(statement, Do) and statement.word == "shift")
        for name, _, _ in set_by(statement)
        if name not in own_names(define)
    }
    return variables(tree) - by_others
