"""The lecture's worked example: a study of a posture or a goal, in numbers, words and symbols.

`sections` writes it in mm and degrees, and `symbolic_sections` in symbols. Lengths in mm, angles in
rad.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from kinematics.chains.chain import Chain, table_text
from kinematics.chains.closed_form import how_solved
from kinematics.chains.goals import ALL_PARTS, Part
from kinematics.chains.inverse import Solution, solve_frame_ik
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError
from kinematics.frames.numbers import as_list, goal_numbers
from kinematics.frames.orientations import RPY
from kinematics.frames.transforms import Transform, homogeneous, position_of
from kinematics.text import aligned, counted, plain
from kinematics.textbook.notation import (
    GREEK,
    PLAIN,
    Definition,
    definitions,
    matrix_latex,
    matrix_text,
    notation,
)
from kinematics.textbook.study import (
    FRAME_COORDINATES,
    ROW_NAMES,
    Study,
    Subject,
    example_posture,
    named_factors,
    study,
    table_branches,
)
from kinematics.textbook.symbols import coordinate, named
from kinematics.textbook.systems.named import NamedBranch, Quantity, System, frame_coordinates


def work(
    subject: Subject, joints: Sequence[float] | None = None, goal: Sequence[float] | None = None
) -> Study:
    """Return the worked example of a posture, or of a goal and a posture that meets it.

    Without either it is that of an example posture. The goal of a named system is in its own
    coordinates; of its branches the first within the limits is taken. A link table is solved
    numerically: its goal is x, y, z, or these with phi, theta, psi, by default the whole frame that
    the joints reach. Raises as `Chain.fk` and `System.ik` do, and `KinematicsError` for another
    number of goal coordinates.
    """
    if subject.system is None:
        return _work_numerically(subject, joints, goal)
    if goal is None:
        return study(subject, _posture(subject.chain, joints))
    found = subject.system.ik(goal, joints)
    taken = min(found, key=lambda branch: not branch.within_limits)
    posture = taken.joints if joints is None else subject.chain.checked(joints)
    return replace(study(subject, posture), goal=tuple(goal), branches=found, refusal="")


def _work_numerically(
    subject: Subject, joints: Sequence[float] | None, goal: Sequence[float] | None
) -> Study:
    chain = subject.chain
    if goal is None:
        posture = _posture(chain, joints)
        target = chain.fk(posture)
        solution = solve_frame_ik(chain, target)
        asked = frame_coordinates(target)
        found = table_branches(chain, target, posture)
    else:
        if len(as_list(goal) or ()) not in (3, 6):
            raise KinematicsError(
                f"a goal is x, y, z, or x, y, z, phi, theta, psi (mm and angles), not {goal!r}"
            )
        target, asked = frame_of(goal), tuple(goal)
        parts = ALL_PARTS if len(asked) > 3 else frozenset({Part.POSITION})
        solution = solve_frame_ik(chain, target, joints, parts=parts)
        posture = solution.joints if joints is None else chain.checked(joints)
        found = table_branches(chain, target, posture) if len(asked) > 3 else ()
    made = study(subject, posture)
    return replace(made, goal=asked, branches=found, refusal="", solution=solution)


def _posture(chain: Chain, joints: Sequence[float] | None) -> tuple[float, ...]:
    return example_posture(chain) if joints is None else chain.checked(joints)


def frame_of(goal: Sequence[float]) -> Transform:
    """Return the frame of a goal: x, y, z, or these with phi, theta, psi."""
    names = FRAME_COORDINATES[: len(goal)]
    given = goal_numbers("a goal", goal, names)
    x, y, z, phi, theta, psi = (*given, 0.0, 0.0, 0.0)[:6]
    return homogeneous(RPY(phi, theta, psi).rotation(), (x, y, z))


# A worked example in words and numbers, in mm and degrees: the text of `armdrive explain`.

# What the quantities of the elbow triangle are; the angles count in the arm's own plane.
TRIANGLE = (
    "triangle: two links and D, the line from the first joint to the end of the second link; "
    "bend is the angle by which the second link leaves the first, direction the one of D, "
    "lift the one of D beyond the first link"
)

DIGITS_MM, DIGITS_DEG, DIGITS_RATIO = 2, 2, 4


@dataclass(frozen=True, slots=True)
class ExampleSection:
    """A heading and the lines under it."""

    title: str
    lines: tuple[str, ...]


def sections(example: Study) -> Iterator[ExampleSection]:
    """Yield the sections of a worked example that have something to say."""
    system, solution = example.subject.system, example.solution
    pages: tuple[tuple[str, Iterable[str]], ...] = (
        ("Figure", system.figure().splitlines() if system else ()),
        ("Links", table_text(example.subject.chain).splitlines()),
        ("A matrices at this posture", _matrices(example)),
        ("Forward kinematics", _forward(example)),
        ("Jacobian", _jacobian(example)),
        ("Singularities", _singularities(example)),
        ("How it is solved", _how_solved(example.subject)),
        ("Inverse kinematics", () if solution else _inverse(example)),
        ("Inverse kinematics, by numbers", _solved(example, solution) if solution else ()),
        ("All solutions, in closed form", _all_solutions(example) if solution else ()),
    )
    for title, lines in pages:
        if said := tuple(lines):
            yield ExampleSection(title, said)


def joints_text(chain: Chain, joints: Sequence[float]) -> str:
    """Return joint values with their names and units."""
    return ", ".join(
        f"{name} {number_text(value, kind.unit)}"
        for name, value, kind in zip(chain.joint_names, joints, chain.kinds, strict=True)
    )


def number_text(value: float, unit: str) -> str:
    """Return a number with its unit: angles in degrees, lengths in mm, ratios bare."""
    if unit == JointKind.REVOLUTE.unit:
        return f"{plain(math.degrees(value), DIGITS_DEG)}°"
    if unit == JointKind.PRISMATIC.unit:
        return f"{plain(value, DIGITS_MM)} mm"
    return plain(value, DIGITS_RATIO)


def frame_text(frame: Transform) -> list[str]:
    """Return a frame's matrix: ratios with four digits, the position in mm."""
    cells = [
        [
            plain(entry, DIGITS_MM if column == 3 else DIGITS_RATIO)
            for column, entry in enumerate(row)
        ]
        for row in frame
    ]
    return [f"[ {row} ]" for row in aligned(cells)]


def coordinates_text(names: Sequence[str], values: Sequence[float]) -> str:
    """Return the coordinates of a goal with their units."""
    split = [name.rpartition("_") for name in names]
    return ", ".join(
        f"{name} {number_text(value, unit)}"
        for (name, _, unit), value in zip(split, values, strict=True)
    )


def _matrices(example: Study) -> Iterator[str]:
    chain = example.subject.chain
    yield joints_text(chain, example.values)
    about = {"base": "frame 0 in the world", "tool": "the tool in the last frame"}
    for number, (link, value) in enumerate(zip(chain.links, example.values, strict=True), 1):
        theta, distance, length, twist = link.parameters(value)
        about[f"A{number}"] = (
            f"theta {number_text(theta, 'rad')}, d {number_text(distance, 'mm')}, "
            f"a {number_text(length, 'mm')}, alpha {number_text(twist, 'rad')}"
        )
    for name, matrix in example.factors:
        yield from ("", f"{name}: {about[name]}", *frame_text(matrix))


def _forward(example: Study) -> Iterator[str]:
    yield f"T = {' '.join(name for name, _ in example.factors)}"
    yield from frame_text(example.frame)
    x, y, z = (number_text(each, "mm") for each in position_of(example.frame))
    angles = example.orientation.first
    phi, theta, psi = (
        number_text(each, "rad") for each in (angles.phi_rad, angles.theta_rad, angles.psi_rad)
    )
    yield f"position x {x}, y {y}, z {z}"
    yield f"orientation RPY: phi {phi}, theta {theta}, psi {psi}"
    if example.orientation.degeneracy is not None:
        yield f"  degenerate: {example.orientation.degeneracy.value}"
    for violation in example.violations:
        yield f"but: {violation}"
    system = example.subject.system
    if system is not None and system.space is not None:
        yield f"reach: {system.space(system)}"


def _jacobian(example: Study) -> Iterator[str]:
    """Write a line for each joint: how it moves the tip, and how it turns the hand."""
    chain, rows = example.subject.chain, example.subject.rows
    for title, unit, part in (
        ("move", "mm", [index for index, row in enumerate(rows) if row < 3]),
        ("turn", "rad", [index for index, row in enumerate(rows) if row >= 3]),
    ):
        if part:
            names = ", ".join(ROW_NAMES[rows[index]] for index in part)
            yield f"each joint's {title} of the hand, in {unit} per rad or mm: {names}"
            columns = zip(*(example.jacobian[index] for index in part), strict=True)
            digits = DIGITS_MM if unit == "mm" else DIGITS_RATIO
            cells = [[plain(entry, digits) for entry in column] for column in columns]
            named = zip(chain.joint_names, aligned(cells), strict=True)
            width = max(map(len, chain.joint_names))
            yield from (f"  {name:<{width}} [ {line} ]" for name, line in named)
    values = ", ".join(plain(value, DIGITS_RATIO) for value in example.condition.singular_values)
    yield f"singular values {values} (mm counted in the length of the arm)"
    yield measures(example)
    yield example.condition.sentence


def measures(example: Study) -> str:
    """Return manipulability and condition number in a line."""
    found = "infinite" if example.condition.is_singular else plain(example.conditioning, 2)
    size = plain(example.condition.manipulability, DIGITS_RATIO)
    return f"manipulability {size}, condition number {found}"


def _singularities(example: Study) -> Iterator[str]:
    for one in example.singularities:
        away = [number_text(one.distance_rad, "rad")] if one.distance_rad is not None else []
        away += [number_text(one.distance_mm, "mm")] if one.distance_mm is not None else []
        yield f"{', '.join(away)} away: {one.reason}"


def _how_solved(subject: Subject) -> Iterator[str]:
    found = how_solved(subject.chain)
    yield f"class: {found.structure}"
    if subject.system is None:
        yield f"solved {found.solved}"
        return
    yield "solved in closed form, by the steps of its own build:"
    for number, step in enumerate(subject.system.notes.derivation, 1):
        yield f"{number}. {step.title}: {step.formula}"
        if step.why:
            yield f"   {step.why}"


def _inverse(example: Study) -> Iterator[str]:
    yield f"goal: {coordinates_text(example.coordinates, example.goal)}"
    count = len(example.branches)
    within = sum(each.within_limits for each in example.branches)
    yield f"{counted(count, 'solution')}, {within} within the joint limits"
    if any(one.symbol == "lift" for each in example.branches for one in each.workings):
        yield TRIANGLE
    for each in example.branches:
        yield ""
        yield from _branch(example, each)


def _branch(example: Study, branch: NamedBranch) -> Iterator[str]:
    yield branch.name
    if branch.workings:
        yield f"  {', '.join(map(_quantity, branch.workings))}"
    yield f"  {joints_text(example.subject.chain, branch.joints)}"
    if example.subject.system is not None:
        yield f"  comes to {coordinates_text(example.coordinates, example.comes_to(branch))}"
    yield from (f"  {line}" for line in remarks(branch))


def remarks(branch: NamedBranch) -> Iterator[str]:
    """Say what of a solution is free or lost, and which limits it breaks."""
    if branch.free:
        yield f"free: {', '.join(branch.free)}; any value serves, the one shown is the nearest"
    if branch.degenerate:
        yield f"degenerate: {branch.degenerate}"
    for violation in branch.violations:
        yield f"not within the limits: {violation}"


def _all_solutions(example: Study) -> Iterator[str]:
    """List the solutions of a link table."""
    for number, branch in enumerate(example.branches):
        if number:
            yield ""
        yield from _branch(example, branch)


def _quantity(quantity: Quantity) -> str:
    return f"{quantity.symbol} = {number_text(quantity.value, quantity.unit)}"


def _solved(example: Study, solution: Solution) -> Iterator[str]:
    yield f"goal: {coordinates_text(example.coordinates, example.goal)}"
    yield joints_text(example.subject.chain, solution.joints)
    x, y, z = (number_text(each, "mm") for each in position_of(solution.frame))
    yield f"comes to x {x}, y {y}, z {z}"
    yield solution.sentence


# The worked example in symbols: chains and named systems whose numbers are symbols.
#
# Lengths become names (d1, a2), and so do joint variables: a joint that is not named as a symbol
# already becomes theta or d with its number, as in the notes. Lengths that are zero stay zero, and
# constant angles stay numbers, so that what the notes leave out is left out here too.

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

    @property
    def factors(self) -> list[tuple[str, Transform]]:
        """What the product is made of, by name."""
        return named_factors(self.base, self.matrices, self.tool)


def symbolic_example(subject: Subject) -> SymbolicExample:
    """Return a subject in symbols: a named system's lengths and joints as its figure calls them.

    A chain that is no named system has lengths a and d and angles theta, with the link's number,
    and no solutions.
    """
    system = subject.system
    chain = symbolic_chain(subject.chain) if system is None else symbolic_system(system).chain()
    joints = joint_symbols(chain)
    branches = () if system is None else tuple(_symbolic_branches(system))
    return SymbolicExample(
        chain.base, chain.matrices(joints), chain.tool, chain.fk(joints), branches
    )


def _symbolic_branches(system: System) -> Iterator[SymbolicBranch]:
    symbolic, goal = symbolic_system(system), symbolic_goal(system.coordinates)
    names = [PLAIN.write(symbol) for symbol in joint_symbols(system.chain())]
    for name in system.signs:
        solved = symbolic.solution(goal, name)
        workings = [(quantity.symbol, quantity.value) for quantity in solved.workings]
        joints = zip(names, solved.joints, strict=True)
        yield SymbolicBranch(name, definitions([*workings, *joints]))


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


def _symbolic_matrices(example: SymbolicExample, latex: bool) -> Iterator[str]:
    for index, (name, matrix) in enumerate(example.factors):
        if index:
            yield ""
        yield from _matrix(name, matrix, latex)


def _product(example: SymbolicExample, latex: bool) -> Iterator[str]:
    written = " ".join(notation(latex=latex).name(name) for name, _ in example.factors)
    yield from _matrix("T", example.product, latex, f" = {written}")


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
