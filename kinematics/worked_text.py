"""A worked example in words and numbers, in mm and degrees: the text of `armdrive explain`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from kinematics.chains import Chain, JointViolation
from kinematics.frames import IN_PLACE, Transform, position_of
from kinematics.links import JointKind
from kinematics.systems import Quantity
from kinematics.tables import table_text
from kinematics.worked_example import WorkedBranch, WorkedExample

TRIANGLE = (
    "triangle: two links and D, the line from the first joint to the end of the second link; "
    "bend is the angle by which the second link leaves the first, direction the one of D, "
    "lift the one of D beyond the first link"
)
"""What the quantities of the elbow triangle are; the angles count in the arm's own plane."""

DIGITS_MM, DIGITS_DEG, DIGITS_RATIO = 2, 2, 4


@dataclass(frozen=True, slots=True)
class Section:
    """A heading and the lines under it."""

    title: str
    lines: tuple[str, ...]


def sections(example: WorkedExample) -> Iterator[Section]:
    """Return the worked example section by section."""
    if example.figure:
        yield Section("Figure", tuple(example.figure.splitlines()))
    yield Section("Links", tuple(table_text(example.chain).splitlines()))
    yield Section("A matrices at this posture", tuple(_matrices(example)))
    yield Section("Forward kinematics", tuple(_forward(example)))
    if example.derivation:
        yield Section("How it is solved", tuple(_derivation(example)))
    if example.solution is None:
        yield Section("Inverse kinematics", tuple(_inverse(example)))
    else:
        yield Section("Inverse kinematics, by numbers", tuple(_solved(example)))


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


def plain(value: float, digits: int) -> str:
    """Format with so many digits at most, without trailing zeros, and no minus before a zero."""
    text = f"{value:.{digits}f}"
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def frame_text(frame: Transform) -> list[str]:
    """Return a frame's matrix: ratios with four digits, the position in mm."""
    cells = [
        [
            plain(entry, DIGITS_MM if column == 3 else DIGITS_RATIO)
            for column, entry in enumerate(row)
        ]
        for row in frame
    ]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [f"[ {'  '.join(map(str.rjust, row, widths))} ]" for row in cells]


def violation_text(violation: JointViolation) -> str:
    """Say by how much a joint would pass its limit."""
    excess = number_text(violation.excess, violation.unit)
    bound = number_text(violation.bound, violation.unit)
    return f"{violation.joint} {excess} beyond its limit of {bound}"


def coordinates_text(names: Sequence[str], values: Sequence[float]) -> str:
    """Return the coordinates of a goal with their units."""
    split = [name.rpartition("_") for name in names]
    return ", ".join(
        f"{name} {number_text(value, unit)}"
        for (name, _, unit), value in zip(split, values, strict=True)
    )


def _matrices(example: WorkedExample) -> Iterator[str]:
    chain = example.chain
    yield joints_text(example.chain, example.joints)
    if chain.base != IN_PLACE:
        yield from _titled("frame 0 in the world", chain.base)
    rows = zip(chain.links, example.joints, example.matrices, strict=True)
    for number, (link, value, matrix) in enumerate(rows, 1):
        theta, distance, length, twist = link.parameters(value)
        yield from _titled(
            f"A{number}: theta {number_text(theta, 'rad')}, d {number_text(distance, 'mm')}, "
            f"a {number_text(length, 'mm')}, alpha {number_text(twist, 'rad')}",
            matrix,
        )
    if chain.tool != IN_PLACE:
        yield from _titled("tool in the last frame", chain.tool)


def _titled(title: str, frame: Transform) -> Iterable[str]:
    return ["", title, *frame_text(frame)]


def _forward(example: WorkedExample) -> Iterator[str]:
    product = " ".join(f"A{number}" for number in range(1, len(example.chain) + 1))
    yield f"T = {product}" + ("" if example.chain.tool == IN_PLACE else " tool")
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
        yield f"but: {violation_text(violation)}"
    yield example.condition


def _derivation(example: WorkedExample) -> Iterator[str]:
    for number, step in enumerate(example.derivation, 1):
        yield f"{number}. {step.title}: {step.formula}"
        if step.why:
            yield f"   {step.why}"


def _inverse(example: WorkedExample) -> Iterator[str]:
    yield f"goal: {coordinates_text(example.coordinates, example.goal)}"
    count = len(example.branches)
    within = sum(each.branch.within_limits for each in example.branches)
    yield f"{count} solution{'' if count == 1 else 's'}, {within} within the joint limits"
    if any(one.symbol == "lift" for each in example.branches for one in each.branch.workings):
        yield TRIANGLE
    for each in example.branches:
        yield ""
        yield from _branch(example, each)


def _branch(example: WorkedExample, worked: WorkedBranch) -> Iterator[str]:
    branch = worked.branch
    yield branch.name
    if branch.workings:
        yield f"  {', '.join(map(_quantity, branch.workings))}"
    yield f"  {joints_text(example.chain, branch.joints)}"
    yield f"  comes to {coordinates_text(example.coordinates, worked.comes_to)}"
    if branch.free:
        yield f"  free: {', '.join(branch.free)}; any value serves, the one shown is the nearest"
    if branch.degenerate:
        yield f"  degenerate: {branch.degenerate}"
    if branch.violations:
        yield f"  not within the limits: {'; '.join(map(violation_text, branch.violations))}"


def _quantity(quantity: Quantity) -> str:
    return f"{quantity.symbol} = {number_text(quantity.value, quantity.unit)}"


def _solved(example: WorkedExample) -> Iterator[str]:
    solution = example.solution
    if solution is None:
        return
    yield f"goal: {coordinates_text(example.coordinates, example.goal)}"
    yield joints_text(example.chain, solution.joints)
    x, y, z = (number_text(each, "mm") for each in position_of(solution.frame))
    yield f"comes to x {x}, y {y}, z {z}"
    yield solution.sentence
