"""Chains and named systems whose numbers are symbols: the same code, seen as formulas.

Lengths become names (d1, a2), and so do joint variables: a joint that is not named as a symbol
already becomes theta or d with its number, as in the notes. Lengths that are zero stay zero, and
constant angles stay numbers, so that what the notes leave out is left out here too.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from kinematics.chains.chain import Chain
from kinematics.chains.links import JointKind
from kinematics.frames.transforms import Transform
from kinematics.textbook.notation import (
    GREEK,
    PLAIN,
    Definition,
    definitions,
    matrix_latex,
    matrix_text,
    notation,
)
from kinematics.textbook.study import Subject, named_factors
from kinematics.textbook.symbols import coordinate, named
from kinematics.textbook.systems.named import System
from kinematics.textbook.worked_example import ExampleSection

_SYMBOL = re.compile(rf"(?:[a-z]|{'|'.join(sorted(GREEK))})_?\d*")


def joint_symbols(chain: Chain) -> tuple[Any, ...]:
    """Return a symbol for each joint's value: its own name, or theta and d with its number."""
    if all(_SYMBOL.fullmatch(name) for name in chain.joint_names):
        return tuple(map(named, chain.joint_names))
    return tuple(
        named(f"{'theta' if kind is JointKind.REVOLUTE else 'd'}{number}")
        for number, kind in enumerate(chain.kinds, 1)
    )


def symbolic_chain(chain: Chain) -> Chain:
    """Return the chain with its constant lengths as names: d1, a2 and so on.

    A revolute joint's distance is d with the link's number, a prismatic one's constant part D.
    In Craig's convention the length in a row is the one of the link before, and numbered so.
    """
    shift = 0 if chain.convention.value == "standard" else 1
    links = tuple(
        replace(
            link,
            a_mm=_name(link.a_mm, f"a{number - shift}"),
            d_mm=_name(
                link.d_mm, f"d{number}" if link.kind is JointKind.REVOLUTE else f"D{number}"
            ),
        )
        for number, link in enumerate(chain.links, 1)
    )
    return replace(chain, links=links)


def symbolic_system(system: System) -> System:
    """Return the system with its lengths as the names that its figure and derivation use."""
    names = map(_name, system.sizes, system.length_names)
    return replace(system, sizes=tuple(names))


def symbolic_goal(coordinates: Sequence[str]) -> tuple[Any, ...]:
    """Return the coordinates of a goal as symbols, their units left out: x, y, phi."""
    return tuple(coordinate(name.rpartition("_")[0] or name) for name in coordinates)


def _name(value: float, name: str) -> Any:
    return named(name) if value != 0.0 else 0.0


# A worked example in symbols: A matrices, their product, and the solutions step by step. Made by
# running the very code that computes with numbers on symbols.


@dataclass(frozen=True, slots=True)
class SymbolicBranch:
    """A branch's name, and the steps that lead to its joint values."""

    name: str
    steps: tuple[Definition, ...]


@dataclass(frozen=True, slots=True)
class SymbolicExample:
    """The A matrices of a chain's links and the tool's frame, entries of which are symbols."""

    base: Transform
    matrices: tuple[Transform, ...]
    tool: Transform
    product: Transform
    branches: tuple[SymbolicBranch, ...] = ()


def symbolic_example(subject: Subject) -> SymbolicExample:
    """Return a subject in symbols, with its solutions where it is a named system."""
    if subject.system is None:
        return symbolic_chain_example(subject.chain)
    return symbolic_system_example(subject.system)


def symbolic_system_example(system: System) -> SymbolicExample:
    """Return a named system in symbols: its lengths and joints as its figure calls them."""
    plain, symbolic = system.chain(), symbolic_system(system)
    names = [PLAIN.write(symbol) for symbol in joint_symbols(plain)]
    goal = symbolic_goal(system.coordinates)
    branches = []
    for name in system.signs:
        solved = symbolic.solution(goal, name)
        workings = [(quantity.symbol, quantity.value) for quantity in solved.workings]
        joints = zip(names, solved.joints, strict=True)
        branches.append(SymbolicBranch(name, definitions([*workings, *joints])))
    return _symbolic_example(symbolic.chain(), tuple(branches))


def symbolic_chain_example(chain: Chain) -> SymbolicExample:
    """Return a chain in symbols: lengths a and d, angles theta, with the link's number."""
    return _symbolic_example(symbolic_chain(chain), ())


def symbolic_sections(example: SymbolicExample, *, latex: bool = False) -> Iterator[ExampleSection]:
    """Return the symbolic example section by section, as text or as LaTeX displays."""
    yield ExampleSection("A matrices", tuple(_symbolic_matrices(example, latex)))
    yield ExampleSection("Product", tuple(_product(example, latex)))
    if example.branches:
        yield ExampleSection("Solutions", tuple(_solutions(example.branches, latex)))


def equation(step: Definition, *, latex: bool = False) -> str:
    """Return a step as an equation."""
    writer = notation(latex=latex)
    return f"{writer.name(step.name)} = {writer.write(step.symbol)}"


def _symbolic_example(chain: Chain, branches: tuple[SymbolicBranch, ...]) -> SymbolicExample:
    joints = joint_symbols(chain)
    matrices = chain.matrices(joints)
    return SymbolicExample(chain.base, matrices, chain.tool, chain.fk(joints), branches)


def _symbolic_matrices(example: SymbolicExample, latex: bool) -> Iterator[str]:
    for index, (name, matrix) in enumerate(_factors(example)):
        if index:
            yield ""
        yield from _matrix(name, matrix, latex)


def _product(example: SymbolicExample, latex: bool) -> Iterator[str]:
    written = " ".join(notation(latex=latex).name(name) for name, _ in _factors(example))
    yield from _matrix("T", example.product, latex, f" = {written}")


def _factors(example: SymbolicExample) -> list[tuple[str, Transform]]:
    return named_factors(example.base, example.matrices, example.tool)


def _matrix(name: str, matrix: Transform, latex: bool, made_of: str = "") -> list[str]:
    if latex:
        return [
            rf"\[ {notation(latex=True).name(name)}{made_of} =",
            *matrix_latex(matrix).splitlines(),
            r"\]",
        ]
    return [f"{name}{made_of} =", *matrix_text(matrix).splitlines()]


def _solutions(branches: tuple[SymbolicBranch, ...], latex: bool) -> Iterator[str]:
    """Write the first branch in full, of the others what differs from it."""
    first = branches[0]
    for branch in branches:
        known = first.steps if branch is not first else ()
        if branch is not first:
            yield ""
        yield f"% {branch.name}" if latex else branch.name
        changed = [step for step in branch.steps if step not in known]
        if known and len(changed) < len(branch.steps):
            yield f"{'% ' if latex else '  '}as {first.name}, but"
        for step in changed:
            written = equation(step, latex=latex)
            yield rf"\[ {written} \]" if latex else f"  {written}"
