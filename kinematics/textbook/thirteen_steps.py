"""The frames and link parameters of an arm, found from its joint axes in thirteen steps.

`assign_frames` does the geometry; this module explains it step by step. Standard frames by Asokan,
lecture 2.7; Craig's frames by the same steps with his rules (chapter 3, "affixing frames to
links"). Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from kinematics.chains.assignment import (
    BASE_FRAME,
    LAST_FRAME,
    ORIGIN,
    X_AXIS_OF_FRAME,
    Z_AXIS,
    Assignment,
    AxisPair,
    Relation,
)
from kinematics.chains.chain import table_text
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.rotations import columns
from kinematics.frames.transforms import IN_PLACE, Transform, position_of, rotation_of
from kinematics.frames.vectors import Vector, angle_between, distance
from kinematics.text import counted, plain
from kinematics.textbook.systems.named import assignment_rules
from kinematics.textbook.worked_example import frame_text, number_text

# Axes that are nearer than this to parallel were probably meant to be: the step says so.
NEARLY_PARALLEL_RAD = 1e-3


@dataclass(frozen=True, slots=True)
class AssignmentStep:
    """One of the thirteen steps, for frame or link `index`: the rule, and what it gives here."""

    number: int
    index: int
    stage: str
    lines: tuple[str, ...]

    @property
    def is_of_link(self) -> bool:
        """Whether it finds a link's parameters, not a frame."""
        return self.number > LAST_FRAME


def assignment_steps(found: Assignment) -> tuple[AssignmentStep, ...]:
    """Return the steps in the order in which they are taken."""
    return tuple(_Account(found).steps())


def axes_lines(found: Assignment) -> Iterator[str]:
    """Yield what is given, in pairs of lines: each joint and its axis, the tool and its axes.

    Lengths are in mm, which the heading should say.
    """
    named = zip(found.zero.axes, found.chain.joint_names, strict=True)
    for number, (axis, name) in enumerate(named, 1):
        yield f"joint {number}, {name}: {axis.kind.value}"
        line = axis.line
        yield f"  at {place_text(line.point)} along {vector_text(line.direction)}"
    normal, sliding, approach = map(vector_text, columns(rotation_of(found.zero.tool)))
    yield f"tip at {place_text(position_of(found.zero.tool))}"
    yield f"  approach {approach}, sliding {sliding}, normal {normal}"


def result_lines(found: Assignment) -> Iterator[str]:
    """Yield the link table, and the transforms before and after it that are not the identity."""
    chain = found.chain
    yield from table_text(chain).splitlines()
    for title, frame in (
        ("frame 0 in the world", chain.base),
        ("tool in the last frame", chain.tool),
    ):
        if frame != IN_PLACE:
            yield from ("", title, *frame_text(frame))


def place_text(point: Vector) -> str:
    """Return a point without its unit."""
    return f"({', '.join(plain(each, 2) for each in point)})"


def point_text(point: Vector) -> str:
    """Return a point in mm."""
    return f"{place_text(point)} mm"


def vector_text(vector: Vector) -> str:
    """Return a direction."""
    return f"({', '.join(plain(each, 4) for each in vector)})"


class _Account:
    """Tells one assignment step by step."""

    def __init__(self, found: Assignment) -> None:
        self._found = found
        self._craig = found.chain.convention is Convention.CRAIG
        self._rules = assignment_rules(found.chain.convention)
        self._count = len(found.chain)
        self._stage = ""

    def steps(self) -> Iterator[AssignmentStep]:
        count = self._count
        self._stage = "The joints"
        yield self._step(1, 0, f"{counted(count, 'joint')}: frames 0 to {count}")
        self._stage = "Frame 0"
        shown = () if self._craig else (self._origin(0), self._x(0))
        yield self._step(BASE_FRAME, 0, f"z0 = {vector_text(self._axis(0, 2))}", *shown)
        for k in range(1, count):
            self._stage = f"Frame {k}"
            yield from self._frame_steps(k)
        self._stage = f"Frame {count}"
        yield self._last_frame()
        for k in range(1, count + 1):
            self._stage = f"Link {k}, joint {self._found.chain.joint_names[k - 1]}"
            yield from self._link_steps(k)

    def _frame_steps(self, k: int) -> Iterator[AssignmentStep]:
        pair = self._found.pairs[k - 1]
        yield self._step(Z_AXIS, k, f"z{k} = {vector_text(self._axis(k, 2))}")
        yield self._step(ORIGIN, k, *self._lie(k, pair), self._origin(k))
        yield self._step(X_AXIS_OF_FRAME, k, self._x(k))
        yield self._step(6, k, f"y{k} = {vector_text(self._axis(k, 1))}")
        yield self._step(7, k, f"k = {k + 1}: go on with step {3 if k + 1 < self._count else 8}")

    def _last_frame(self) -> AssignmentStep:
        count = self._count
        lines = [f"z{count} = {vector_text(self._axis(count, 2))}", self._x(count)]
        if self._craig:
            lines.append(f"frame 0 is frame 1: L0 = {point_text(position_of(self._frame(0)))}")
        return self._step(LAST_FRAME, count, *lines, self._origin(count))

    def _link_steps(self, k: int) -> Iterator[AssignmentStep]:
        link = self._found.chain.links[k - 1]
        before = k - 1 if self._craig else k
        turns = link.kind is JointKind.REVOLUTE
        yield self._step(9, k, f"b{k} = {point_text(self._found.points[k - 1])}")
        theta, d, a, alpha = link.parameters(0.0)
        varies = f"the joint's variable{', added to this' if (theta if turns else d) else ''}"
        for number, name, value, unit, varied in (
            (10, f"theta{k}", theta, "rad", turns),
            (11, f"d{k}", d, "mm", not turns),
            (12, f"a{before}", a, "mm", False),
            (13, f"alpha{before}", alpha, "rad", False),
        ):
            equation = f"{name} = {number_text(value, unit)}"
            yield self._step(number, k, f"{equation} ({varies})" if varied else equation)

    def _step(self, number: int, k: int, *lines: str) -> AssignmentStep:
        names = {"k": k, "before": k - 1, "next": k + 1, "n": self._count, "last": self._count - 1}
        rule = self._rules[number - 1].format(**names)
        notes = [
            f"note: {choice.sentence}"
            for choice in self._found.choices
            if (choice.frame, choice.step) == (k, number)
        ]
        found = tuple(f"    {line}" for line in (*lines, *notes))
        return AssignmentStep(number, k, self._stage, (f"{number}. {rule}", *found))

    def _lie(self, k: int, pair: AxisPair) -> Iterator[str]:
        """Say how the axes k and k + 1 lie to each other."""
        near, far = (axis.line for axis in self._found.zero.axes[k - 1 : k + 1])
        angle_rad = angle_between(near.direction, far.direction)
        at = f"at {number_text(angle_rad, 'rad')}"
        gap = number_text(distance(pair.near, pair.far), "mm")
        opposite = ", in opposite directions" if angle_rad > math.pi / 2.0 else ""
        lie = {
            Relation.SKEW: f"are skew: {gap} apart, {at}",
            Relation.INTERSECTING: f"intersect {at}",
            Relation.PARALLEL: f"are parallel, {gap} apart{opposite}",
            Relation.COINCIDENT: f"are the same line{opposite}",
        }[pair.relation]
        yield f"axes {k} and {k + 1} {lie}"
        if pair.relation in (Relation.SKEW, Relation.INTERSECTING):
            if pair.relation is Relation.SKEW:
                yield f"common normal from {point_text(pair.near)} to {point_text(pair.far)}"
            if pair.sine < NEARLY_PARALLEL_RAD:
                away = max(distance(pair.near, near.point), distance(pair.far, far.point))
                yield (
                    f"only {pair.sine:.1g} rad from parallel, and their common normal is "
                    f"{number_text(away, 'mm')} from the given points: if they are meant to be "
                    "parallel, give both the same direction"
                )

    def _frame(self, number: int) -> Transform:
        return self._found.frames[number]

    def _axis(self, number: int, axis: int) -> Vector:
        return columns(rotation_of(self._frame(number)))[axis]

    def _origin(self, number: int) -> str:
        return f"L{number} = {point_text(position_of(self._frame(number)))}"

    def _x(self, number: int) -> str:
        return f"x{number} = {vector_text(self._axis(number, 0))}"
