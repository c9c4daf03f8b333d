"""A study as text, section by section, in columns: matrices with three decimals, mm and degrees."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from kinematics.chains.closed_form import how_solved
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.transforms import Transform, position_of
from kinematics.text import aligned, folded, plain, rounded
from kinematics.textbook.study import ROW_NAMES, Study
from kinematics.textbook.systems.named import NamedSingularity
from kinematics.textbook.worked_example import (
    ExampleSection,
    joints_text,
    remarks,
    symbolic_example,
    symbolic_sections,
)

DIGITS = 3

STILL_SEARCHING = "searching: it takes a moment, while the arm rests"
"""Stands in the place of the singularities of a link table until the search ends."""


def sections(
    of: Study, width: int, searched: tuple[NamedSingularity, ...] | None = None
) -> tuple[ExampleSection, ...]:
    """Return a study in text no wider than `width` where words can be broken.

    `searched` is the singularity that was found nearest for a link table, None before it is.
    """
    found = (
        ExampleSection("link table", tuple(_links(of))),
        ExampleSection("A matrices", tuple(_matrices(of))),
        ExampleSection("T, the hand in the base's frame", tuple(_forward(of))),
        ExampleSection("Jacobian", tuple(_jacobian(of, width))),
        ExampleSection("how well it moves", tuple(_measures(of))),
        ExampleSection("singularities", tuple(_singularities(of, searched))),
        ExampleSection("solutions for this place of the hand", tuple(_branches(of))),
    )
    return tuple(ExampleSection(one.title, tuple(wrapped(one.lines, width))) for one in found)


def symbol_sections(of: Study, width: int) -> tuple[ExampleSection, ...]:
    """Return matrices, product and solutions in C1, S12. Takes up to seconds for six joints."""
    return tuple(
        ExampleSection(f"{one.title}, in symbols", tuple(wrapped(one.lines, width)))
        for one in symbolic_sections(symbolic_example(of.subject))
    )


def summary(of: Study, searched: tuple[NamedSingularity, ...] | None = None) -> str:
    """Return how well the posture moves and its nearest singularity, in one line."""
    near = nearest_of(of.singularities or searched or ())
    conditioning = "infinite: SINGULAR" if of.condition.is_singular else fixed(of.conditioning)
    moves = f"manipulability {fixed(of.condition.manipulability)}, condition {conditioning}"
    return moves if near is None else f"{moves}; singular {distance_text(near)} away: {near.reason}"


def nearest_of(found: Sequence[NamedSingularity]) -> NamedSingularity | None:
    """Return the nearest singularity: by joint moves where there are any, else by mm."""
    turning = [one for one in found if one.distance_rad is not None]
    if turning:
        return min(turning, key=lambda one: one.distance_rad or 0.0)
    return min(found, key=lambda one: one.distance_mm or 0.0, default=None)


def distance_text(singularity: NamedSingularity) -> str:
    """Say how far away a singularity is."""
    measures = []
    if singularity.distance_rad is not None:
        measures.append(f"{math.degrees(singularity.distance_rad):.1f}°")
    if singularity.distance_mm is not None:
        measures.append(f"{singularity.distance_mm:.1f} mm")
    return ", ".join(measures)


def fixed(value: float) -> str:
    """Format with three decimals, without the minus of a zero that was rounded."""
    return rounded(value, DIGITS)


def rows_text(rows: Sequence[Sequence[float]], names: Sequence[str] = ()) -> list[str]:
    """Return the rows of a matrix, columns in line, each after its name."""
    lines = aligned([[fixed(entry) for entry in row] for row in rows], gap=" ")
    first = max(map(len, names), default=0)
    heads = [f"{name:<{first}} " for name in names] or [""] * len(lines)
    return [f"{head}[ {line} ]" for head, line in zip(heads, lines, strict=True)]


def wrapped(lines: Sequence[str], width: int) -> Iterator[str]:
    """Yield the lines, those of words broken to the width; rows of matrices stay as they are."""
    for line in lines:
        if len(line) <= width or "[" in line:
            yield line
        else:
            yield from folded(line, max(width, 1))


def _links(of: Study) -> Iterator[str]:
    """Write the four parameters of each link in this posture, what its joint varies marked."""
    chain = of.subject.chain
    craig = chain.convention is Convention.CRAIG
    yield f"{chain.convention.value} convention, * varies; mm, degrees"
    if craig:
        yield "a and alpha are those of the link before"
    cells = [("joint", "theta", "d", "a", "alpha")]
    for name, link, value in zip(chain.joint_names, chain.links, of.values, strict=True):
        theta, distance, length, twist = link.parameters(value)
        turns = link.kind is JointKind.REVOLUTE
        angles = [plain(math.degrees(each), DIGITS) for each in (theta, twist)]
        lengths = [plain(each, DIGITS) for each in (distance, length)]
        theta_text = angles[0] + ("*" if turns else " ")
        cells.append(
            (name, theta_text, lengths[0] + (" " if turns else "*"), lengths[1], angles[1])
        )
    yield from aligned(cells, left=1, gap=" ")


def _matrices(of: Study) -> Iterator[str]:
    for name, matrix in of.factors:
        yield from _matrix(name, matrix)


def _matrix(name: str, matrix: Transform) -> Iterator[str]:
    yield f"{name} ="
    yield from rows_text(matrix)


def _forward(of: Study) -> Iterator[str]:
    yield from rows_text(of.frame)
    x, y, z = map(fixed, position_of(of.frame))
    yield f"x {x}, y {y}, z {z} mm"
    angles = of.orientation.first
    turns = (angles.phi_rad, angles.theta_rad, angles.psi_rad)
    phi, theta, psi = (fixed(math.degrees(each)) for each in turns)
    yield f"phi {phi}°, theta {theta}°, psi {psi}°"
    if of.orientation.degeneracy is not None:
        yield f"  degenerate: {of.orientation.degeneracy.value}"


def _jacobian(of: Study, width: int) -> Iterator[str]:
    names = [ROW_NAMES[row] for row in of.subject.rows]
    rows = rows_text(of.jacobian, names)
    joints = of.subject.chain.joint_names
    if max(map(len, rows)) <= width:
        yield f"columns: {', '.join(joints)}"
        yield from rows
        return
    places = [index for index, row in enumerate(of.subject.rows) if row < 3]
    turns = [index for index in range(len(names)) if index not in places]
    for part in (places, turns):  # too wide for this place: a line for each column
        if part:
            yield f"columns, a line each: {', '.join(names[index] for index in part)}"
            columns = zip(*(of.jacobian[index] for index in part), strict=True)
            yield from rows_text(tuple(columns), joints)


def _measures(of: Study) -> Iterator[str]:
    values = " ".join(map(fixed, of.condition.singular_values))
    yield f"singular values {values}"
    yield f"condition {'infinite' if of.condition.is_singular else fixed(of.conditioning)}"
    yield f"manipulability {fixed(of.condition.manipulability)}"
    yield "(mm counted in the length of the arm)"
    yield of.condition.sentence


def _singularities(of: Study, searched: tuple[NamedSingularity, ...] | None) -> Iterator[str]:
    found = searched if of.subject.system is None else of.singularities
    if found is None:
        yield STILL_SEARCHING
    elif not found:
        yield "none: no posture loses a direction" if of.subject.system else "none was found"
    for one in found or ():
        yield f"{distance_text(one)} away: {one.reason}"


def _branches(of: Study) -> Iterator[str]:
    if of.refusal:
        yield of.refusal
    found = how_solved(of.subject.chain)
    yield f"class: {found.structure}"
    if of.subject.system is None:
        yield f"solved {found.solved}"
    for index, branch in enumerate(of.branches):
        yield f"{'>' if index == of.here else ' '} {branch.name}"
        yield f"    {joints_text(of.subject.chain, branch.joints)}"
        yield from (f"    {line}" for line in remarks(branch))


# Sections laid in columns of a given height, as a newspaper's.

Column = tuple[str, ...]

RULE = "\N{BOX DRAWINGS LIGHT HORIZONTAL}"
PLAIN_RULE = "-"


def laid(
    sections: Iterable[ExampleSection], width: int, height: int, *, plain: bool = False
) -> tuple[Column, ...]:
    """Return the columns that hold all sections in order, none higher than `height` lines.

    A section that does not fit in what is left begins a column of its own, unless it would not
    fit in a whole one either: then it begins at once and goes on in the next.
    """
    height = max(height, 2)
    columns: list[list[str]] = [[]]
    for section in sections:
        lines = [heading(section.title, width, plain=plain), *section.lines]
        if len(columns[-1]) + len(lines) > height and columns[-1]:
            left = height - len(columns[-1])
            if len(lines) <= height or left < height // 2:
                columns.append([])
        for line in lines:
            if len(columns[-1]) == height:
                columns.append([])
            columns[-1].append(line)
    return tuple(map(tuple, columns))


def heading(title: str, width: int, *, plain: bool = False) -> str:
    """Return a title with a rule to the end of its line."""
    rule = PLAIN_RULE if plain else RULE
    return f"{rule}{rule} {title} ".ljust(width, rule)[:width]
