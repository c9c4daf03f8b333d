"""The lecture's worked example of any arm's posture, in numbers and in words.

The example is a value; `sections` writes it in mm and degrees, and `symbolic_systems` in symbols.
Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from kinematics.chains.chain import Chain, JointViolation
from kinematics.chains.goals import ALL_PARTS, Part
from kinematics.chains.inverse import Solution, solve_frame_ik
from kinematics.chains.jacobians import condition
from kinematics.chains.links import DHLink, JointKind
from kinematics.chains.tables import aligned, table_text
from kinematics.errors import KinematicsError
from kinematics.frames.numbers import as_list, goal_numbers
from kinematics.frames.orientations import RPY, OrientationSolution, solve_rpy
from kinematics.frames.transforms import IN_PLACE, Transform, homogeneous, position_of, rotation_of
from kinematics.textbook.systems.named import NamedBranch, NamedStep, Quantity, System

FRAME_COORDINATES = ("x_mm", "y_mm", "z_mm", "phi_rad", "theta_rad", "psi_rad")
"""The goal of a chain that is no named system: a position, or a position and an orientation."""

_EXAMPLE_DEG = (30.0, 40.0, -60.0, -20.0, 45.0, 60.0)
_TRAVEL = 0.4
_FREE_TRAVEL_MM = 100.0


@dataclass(frozen=True, slots=True)
class WorkedBranch:
    """A branch of the inverse solution, and the goal's coordinates that its posture gives."""

    branch: NamedBranch
    comes_to: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class WorkedExample:
    """An arm, a posture, and all that follows from it.

    `matrices` are the A matrices of the posture, `frame` the tool's frame. `condition` says how
    well the posture can move. A named system has `branches` for the `goal`, in `coordinates`;
    any other chain has the `solution` of the numerical solver.
    """

    name: str
    title: str
    source: str
    figure: str
    derivation: tuple[NamedStep, ...]
    chain: Chain
    joints: tuple[float, ...]
    matrices: tuple[Transform, ...]
    frame: Transform
    orientation: OrientationSolution[RPY]
    violations: tuple[JointViolation, ...]
    condition: str
    coordinates: tuple[str, ...]
    goal: tuple[float, ...]
    branches: tuple[WorkedBranch, ...] = ()
    solution: Solution | None = None


def work_system(
    system: System, joints: Sequence[float] | None = None, goal: Sequence[float] | None = None
) -> WorkedExample:
    """Return the worked example of a named system.

    Without joints, the first branch of the goal within the limits is taken, or an example
    posture. Without a goal, the one that the joints reach. Raises as `System.fk` and `System.ik`
    do.
    """
    chain = system.chain()
    if goal is None:
        posture = example_posture(chain) if joints is None else chain.checked(joints)
        asked = system.goal_of(system.fk(posture))
        found = system.ik(asked, posture)
    else:
        found = system.ik(goal, joints)
        asked = tuple(goal)
        taken = min(found, key=lambda branch: not branch.within_limits)
        posture = taken.joints if joints is None else chain.checked(joints)
    frame = system.fk(posture)
    return WorkedExample(
        system.name,
        system.title,
        system.source,
        system.figure(),
        system.derivation,
        chain,
        posture,
        chain.matrices(posture),
        frame,
        solve_rpy(rotation_of(frame)),
        chain.violations(posture),
        condition(chain, posture).sentence,
        system.coordinates,
        asked,
        branches=tuple(
            WorkedBranch(branch, system.goal_of(system.fk(branch.joints))) for branch in found
        ),
    )


def work_chain(
    chain: Chain,
    title: str = "",
    source: str = "",
    joints: Sequence[float] | None = None,
    goal: Sequence[float] | None = None,
) -> WorkedExample:
    """Return the worked example of any chain, solved numerically.

    A goal is x, y, z, or these with phi, theta, psi; without one it is the whole frame that the
    joints reach, asked from the middle of the joints' ranges. Raises as `Chain.fk` does, and
    `KinematicsError` for another number of goal coordinates.
    """
    parts = ALL_PARTS
    if goal is None:
        posture = example_posture(chain) if joints is None else chain.checked(joints)
        target = chain.fk(posture)
    else:
        if len(as_list(goal) or ()) not in (3, 6):
            raise KinematicsError(
                f"a goal is x, y, z, or x, y, z, phi, theta, psi (mm and angles), not {goal!r}"
            )
        if len(goal) == 3:
            parts = frozenset({Part.POSITION})
        target = _frame_of(goal)
    solution = solve_frame_ik(chain, target, joints if goal is not None else None, parts=parts)
    if goal is not None:
        posture = solution.joints if joints is None else chain.checked(joints)
    frame = chain.fk(posture)
    asked = FRAME_COORDINATES if parts == ALL_PARTS else FRAME_COORDINATES[:3]
    return WorkedExample(
        chain.name,
        title,
        source,
        "",
        (),
        chain,
        tuple(posture),
        chain.matrices(posture),
        frame,
        solve_rpy(rotation_of(frame)),
        chain.violations(posture),
        condition(chain, posture).sentence,
        asked,
        frame_coordinates(target)[: len(asked)],
        solution=solution,
    )


def example_posture(chain: Chain) -> tuple[float, ...]:
    """Return a posture to show: round numbers within the limits, degenerate in no way."""
    return tuple(
        _example_value(link, _EXAMPLE_DEG[index % len(_EXAMPLE_DEG)])
        for index, link in enumerate(chain.links)
    )


def frame_coordinates(frame: Transform) -> tuple[float, ...]:
    """Return x, y, z, phi, theta and psi of a frame."""
    angles = solve_rpy(rotation_of(frame)).first
    return *position_of(frame), angles.phi_rad, angles.theta_rad, angles.psi_rad


def _frame_of(goal: Sequence[float]) -> Transform:
    names = FRAME_COORDINATES[: len(goal)]
    given = goal_numbers("a goal", goal, names)
    x, y, z, phi, theta, psi = (*given, 0.0, 0.0, 0.0)[:6]
    return homogeneous(RPY(phi, theta, psi).rotation(), (x, y, z))


def _example_value(link: DHLink, angle_deg: float) -> float:
    """Return a joint's example value: the angle, or as far into the range as it is of a turn."""
    if link.kind is JointKind.REVOLUTE:
        angle = math.radians(angle_deg)
        for value in (angle, -angle):
            if link.low <= value <= link.high:
                return value
    elif not (math.isfinite(link.low) and math.isfinite(link.high)):
        return min(max(_FREE_TRAVEL_MM, link.low), link.high)
    return link.low + _TRAVEL * (link.high - link.low)


# A worked example in words and numbers, in mm and degrees: the text of `armdrive explain`.

TRIANGLE = (
    "triangle: two links and D, the line from the first joint to the end of the second link; "
    "bend is the angle by which the second link leaves the first, direction the one of D, "
    "lift the one of D beyond the first link"
)
"""What the quantities of the elbow triangle are; the angles count in the arm's own plane."""

DIGITS_MM, DIGITS_DEG, DIGITS_RATIO = 2, 2, 4


@dataclass(frozen=True, slots=True)
class ExampleSection:
    """A heading and the lines under it."""

    title: str
    lines: tuple[str, ...]


def sections(example: WorkedExample) -> Iterator[ExampleSection]:
    """Return the worked example section by section."""
    if example.figure:
        yield ExampleSection("Figure", tuple(example.figure.splitlines()))
    yield ExampleSection("Links", tuple(table_text(example.chain).splitlines()))
    yield ExampleSection("A matrices at this posture", tuple(_matrices(example)))
    yield ExampleSection("Forward kinematics", tuple(_forward(example)))
    if example.derivation:
        yield ExampleSection("How it is solved", tuple(_derivation(example)))
    if example.solution is None:
        yield ExampleSection("Inverse kinematics", tuple(_inverse(example)))
    else:
        yield ExampleSection("Inverse kinematics, by numbers", tuple(_solved(example)))


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
    return [f"[ {row} ]" for row in aligned(cells)]


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
