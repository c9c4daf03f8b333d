"""A worked example in symbols: A matrices, their product, and the solutions step by step.

Made by running the very code that computes with numbers on symbols.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from kinematics.chains import Chain
from kinematics.frames import IN_PLACE, Transform
from kinematics.symbol_naming import Definition, definitions
from kinematics.symbol_text import Latex, Text, matrix_latex, matrix_text
from kinematics.symbolic_systems import (
    joint_symbols,
    symbolic_chain,
    symbolic_goal,
    symbolic_system,
)
from kinematics.systems import System
from kinematics.worked_text import Section


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


def symbolic_system_example(system: System) -> SymbolicExample:
    """Return a named system in symbols: its lengths and joints as its figure calls them."""
    plain, symbolic = system.chain(), symbolic_system(system)
    names = [Text().write(symbol) for symbol in joint_symbols(plain)]
    goal = symbolic_goal(system.coordinates)
    branches = []
    for name in system.signs:
        solved = symbolic.solution(goal, name)
        workings = [(quantity.symbol, quantity.value) for quantity in solved.workings]
        joints = zip(names, solved.joints, strict=True)
        branches.append(SymbolicBranch(name, definitions([*workings, *joints])))
    return _example(symbolic.chain(), tuple(branches))


def symbolic_chain_example(chain: Chain) -> SymbolicExample:
    """Return a chain in symbols: lengths a and d, angles theta, with the link's number."""
    return _example(symbolic_chain(chain), ())


def symbolic_sections(example: SymbolicExample, *, latex: bool = False) -> Iterator[Section]:
    """Return the symbolic example section by section, as text or as LaTeX displays."""
    yield Section("A matrices", tuple(_matrices(example, latex)))
    yield Section("Product", tuple(_product(example, latex)))
    if example.branches:
        yield Section("Solutions", tuple(_solutions(example.branches, latex)))


def equation(step: Definition, *, latex: bool = False) -> str:
    """Return a step as an equation."""
    writer = Latex() if latex else Text()
    return f"{writer.name(step.name)} = {writer.write(step.symbol)}"


def _example(chain: Chain, branches: tuple[SymbolicBranch, ...]) -> SymbolicExample:
    joints = joint_symbols(chain)
    matrices = chain.matrices(joints)
    return SymbolicExample(chain.base, matrices, chain.tool, chain.fk(joints), branches)


def _matrices(example: SymbolicExample, latex: bool) -> Iterator[str]:
    named = [(f"A{number}", one) for number, one in enumerate(example.matrices, 1)]
    if example.base != IN_PLACE:
        named.insert(0, ("base", example.base))
    if example.tool != IN_PLACE:
        named.append(("tool", example.tool))
    for index, (name, matrix) in enumerate(named):
        if index:
            yield ""
        yield from _matrix(name, matrix, latex)


def _product(example: SymbolicExample, latex: bool) -> Iterator[str]:
    factors = [f"A{number}" for number in range(1, len(example.matrices) + 1)]
    if example.base != IN_PLACE:
        factors.insert(0, "base")
    if example.tool != IN_PLACE:
        factors.append("tool")
    written = " ".join(map(Latex().name if latex else Text().name, factors))
    yield from _matrix("T", example.product, latex, f" = {written}")


def _matrix(name: str, matrix: Transform, latex: bool, made_of: str = "") -> list[str]:
    if latex:
        return [rf"\[ {Latex().name(name)}{made_of} =", *matrix_latex(matrix).splitlines(), r"\]"]
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
