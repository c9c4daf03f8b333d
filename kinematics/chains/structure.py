"""The structure of an arm, by which it is solved in closed form, and its constant frames.

An arm has a closed form if some of its axes meet or are parallel (Pieper, 1968). The classes are
those of Ostermeier, Külz and Althoff (2025), "Automatic geometric decomposition for analytical
inverse kinematics", without those that need a search or the roots of a quartic: no arm that is
built has three first axes, or two last ones, all askew. Only the relation of each axis to the next
in one posture is examined (the axes of the product of exponentials), so that both conventions and
any choice of frames give the same class. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise
from typing import NamedTuple

from kinematics.chains.assignment import AxisLine, AxisPair, Relation, relate
from kinematics.chains.chain import Chain
from kinematics.chains.code_lines import CodeLines, Rows3, Term, Vector3, transposed
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.transforms import (
    IN_PLACE,
    Transform,
    compose,
    homogeneous,
    invert,
    position_of,
    rotation_of,
    z_axis_of,
)
from kinematics.frames.vectors import Vector, add, distance, scale

EXACT = 1e-8
"""Axes that lean less than this towards each other are parallel, and those that pass each other
nearer than this share of the arm's length meet: on a metre it is 1e-5 mm."""

NEARLY = 0.01
"""The same for an arm that is nearly of a class, as a calibrated one is: half a degree."""


class Family(Enum):
    """The property that allows a closed form."""

    SPHERICAL_WRIST = "spherical wrist: the last three axes meet in one point"
    THREE_PARALLEL = "three parallel axes: 2, 3 and 4"
    LAST_TWO_MEET = "the last two of five axes meet"


class FirstThree(Enum):
    """How the first three joints place the point in which the wrist's axes meet."""

    SECOND_AND_THIRD_PARALLEL = "axes 2 and 3 are parallel"
    FIRST_AND_SECOND_PARALLEL = "axes 1 and 2 are parallel"
    FIRST_AND_SECOND_MEET = "axes 1 and 2 meet"
    SECOND_AND_THIRD_MEET = "axes 2 and 3 meet"


@dataclass(frozen=True, slots=True)
class Structure:
    """The class of an arm.

    `from_hand` says that the axes are counted from the hand: the arm is solved backwards.
    `tolerance` is how far axes may lean or pass each other and still count as of the class: beyond
    `EXACT` the class is only nearly the arm's, and its postures have to be improved.
    """

    family: Family
    first_three: FirstThree | None = None
    from_hand: bool = False
    tolerance: float = EXACT

    @property
    def exact(self) -> bool:
        """Whether the arm is of this class, but for rounding."""
        return self.tolerance == EXACT

    def __str__(self) -> str:
        said = self.family.value if self.exact else f"nearly {self.family.value}"
        if self.first_three is not None:
            said += f", {self.first_three.value}"
        if self.from_hand:
            said += ", counted from the hand"
        return said


@dataclass(frozen=True, slots=True)
class Axes:
    """Frames whose z axes are the joint axes of a posture, and the tool's frame in it.

    `size_mm` is the arm's length, and `tolerance` says what is near to zero.
    """

    frames: tuple[Transform, ...]
    hand: Transform
    size_mm: float
    tolerance: float = EXACT

    def pair(self, first: int, second: int) -> AxisPair:
        """Return how two axes lie to each other, within the tolerance."""
        one, other = (
            AxisLine(position_of(frame), z_axis_of(frame))
            for frame in (self.frames[first], self.frames[second])
        )
        return relate(one, other, one.point, self.tolerance, self.tolerance * self.size_mm)

    def parallel(self, first: int, second: int) -> bool:
        """Whether two axes have the same direction or opposite ones."""
        return self.pair(first, second).relation in (Relation.PARALLEL, Relation.COINCIDENT)

    def meeting(self, first: int, second: int) -> Vector | None:
        """Return the point in which two axes meet; None if they are parallel or pass each other."""
        pair = self.pair(first, second)
        if pair.relation is not Relation.INTERSECTING:
            return None
        return scale(0.5, add(pair.near, pair.far))

    def related(self, first: int, second: int) -> bool:
        """Whether two axes are parallel or meet."""
        return self.pair(first, second).relation is not Relation.SKEW

    def all_meeting(self, first: int, second: int, third: int) -> Vector | None:
        """Return the point in which three axes meet."""
        points = self.meeting(first, second), self.meeting(second, third)
        if points[0] is None or points[1] is None:
            return None
        near = distance(points[0], points[1]) <= self.tolerance * self.size_mm
        return points[0] if near else None

    def backwards(self) -> Axes:
        """Return the axes counted from the hand."""
        return replace(self, frames=self.frames[::-1])


def axes_of(chain: Chain, tolerance: float = EXACT) -> Axes:
    """Return the axes of a chain in its zero position."""
    frames = chain.frames(chain.zero)
    kept = frames[:-1] if chain.convention is Convention.STANDARD else frames[1:]
    return Axes(kept, chain.fk(chain.zero), max(chain.longest_reach_mm, 1.0), tolerance)


def structures(chain: Chain) -> Iterator[Structure]:
    """Yield the classes that a chain belongs to, the best ones to solve first.

    Classes that a chain nearly belongs to come last.
    """
    if len(chain) not in (5, 6) or any(kind is not JointKind.REVOLUTE for kind in chain.kinds):
        return
    for tolerance in (EXACT, NEARLY):
        yield from _structures(axes_of(chain, tolerance))


def why_no_structure(chain: Chain) -> str:
    """Return the reason why a chain belongs to no class."""
    count = len(chain)
    if any(kind is not JointKind.REVOLUTE for kind in chain.kinds):
        return "a joint slides, and the classes are of turning joints"
    if count not in (5, 6):
        return f"the classes are of five or six joints, not of {count}"
    axes = axes_of(chain)
    if any(seen.parallel(0, 1) and seen.parallel(1, 2) for seen in (axes, axes.backwards())):
        return "three axes in a row at one end are parallel: they move a point in a plane only"
    pair = "" if count == 5 else " with axes 5 and 6 parallel or meeting"
    wrist = "last three axes meet in one point" if count == 6 else "last two axes meet"
    return (
        f"axes 2, 3 and 4 are not parallel{pair}, nor do the {wrist} and two neighbours of the "
        "first three, or these are parallel; counted from the hand it is no different"
    )


def _structures(axes: Axes) -> Iterator[Structure]:
    ends = ((False, axes), (True, axes.backwards()))
    for from_hand, seen in ends:
        three = seen.parallel(1, 2) and seen.parallel(2, 3) and not seen.parallel(0, 1)
        if three and (len(seen.frames) == 5 or seen.related(4, 5)):
            yield Structure(Family.THREE_PARALLEL, None, from_hand, axes.tolerance)
    for from_hand, seen in ends:
        wrist = seen.all_meeting(3, 4, 5) if len(seen.frames) == 6 else seen.meeting(3, 4)
        if wrist is not None and (first_three := _first_three(seen)) is not None:
            family = Family.SPHERICAL_WRIST if len(seen.frames) == 6 else Family.LAST_TWO_MEET
            yield Structure(family, first_three, from_hand, axes.tolerance)


def _first_three(axes: Axes) -> FirstThree | None:
    """Return how two of the first three axes lie to each other.

    None where they do not, or all three are parallel and move a point along a surface only.
    """
    first_parallel, last_parallel = axes.parallel(0, 1), axes.parallel(1, 2)
    if first_parallel and last_parallel:
        return None
    if last_parallel:
        return FirstThree.SECOND_AND_THIRD_PARALLEL
    if first_parallel:
        return FirstThree.FIRST_AND_SECOND_PARALLEL
    if axes.meeting(0, 1) is not None:
        return FirstThree.FIRST_AND_SECOND_MEET
    if axes.meeting(1, 2) is not None:
        return FirstThree.SECOND_AND_THIRD_MEET
    return None


# An arm's constant places as code sees it that finds postures, in the order in which it does.
#
# Every frame has its joint's axis as z, and each stands at a constant place in the one before it,
# turned about z by that one's joint: T = C0 Rz(q1) C1 Rz(q2) C2 ... Rz(qn) Cn. The frames of axes
# that meet share their origin.

CLEAN = 1e-12
"""An entry of a constant rotation this near to 0, 1 or -1 is that number."""

CLEAN_MM = 1e-10
"""A length this short is nothing."""


class Place(NamedTuple):
    """A frame in another one: how it is turned, and where it stands."""

    rows: Rows3
    origin: Vector3


class Layout:
    """An arm's constant places, in the order in which its joints are solved, and the code so far.

    `x`, `y`, `z` and `origin` are the goal for the last joint's frame, seen from C0. `tip` is the
    goal for the tool there; in the last joint's frame it is at `last_origin`. If the joints are
    counted from the hand, every joint turns backwards and the goal is inverted.
    """

    def __init__(self, chain: Chain, structure: Structure) -> None:
        self.code = CodeLines()
        self.structure = structure
        axes = axes_of(chain)
        self.size = axes.size_mm
        self.sign = -1.0 if structure.from_hand else 1.0
        order, frames = list(range(len(chain))), list(axes.frames)
        ends = IN_PLACE, axes.hand
        if structure.from_hand:
            order.reverse()
            frames.reverse()
            ends = ends[::-1]
        _let_meet(frames, structure, self.size)
        ways = pairwise((ends[0], *frames, ends[1]))
        self.places = [_constant(compose(invert(one), other)) for one, other in ways]
        self.free = [Term(self.sign, f"f{index}") for index in order]
        self.x, self.y, self.z, self.origin, self.tip = self._asked()
        self.last_origin = self.places[-1].origin

    def __len__(self) -> int:
        return len(self.free)

    def rows(self, index: int) -> Rows3:
        """Return how the frame of joint `index` + 1 is turned in that of joint `index`."""
        return self.places[index].rows

    def place(self, index: int) -> Vector3:
        """Return where the frame of joint `index` + 1 stands in that of joint `index`."""
        return self.places[index].origin

    def into(self, index: int, v: Vector3) -> Vector3:
        """Return a direction of joint `index`'s frame, as it is turned, in the next frame."""
        return self.code.times(transposed(self.rows(index)), v)

    def tilt(self, index: int) -> Term:
        """Return the direction, 1 or -1, of an axis that is parallel to the one before it."""
        return Term(math.copysign(1.0, self.rows(index)[2][2].factor))

    def found(self, *postures: Sequence[Term]) -> None:
        """Write lines that keep postures, given by angles in the order solved."""
        for angles in postures:
            turned = [Term(self.sign * one.factor, one.variable) for one in angles]
            listed = turned[::-1] if self.structure.from_hand else turned
            self.code.write(f"found.append(({', '.join('{}' for _ in listed)}))", *listed)

    def _asked(self) -> tuple[Vector3, Vector3, Vector3, Vector3, Vector3]:
        code = self.code
        cells = [[Term(1.0, f"g{row}{column}") for column in range(4)] for row in range(3)]
        x, y, z, origin = ((a, b, c) for a, b, c in zip(*cells, strict=True))
        goal: Rows3 = transposed((x, y, z))
        if self.structure.from_hand:
            goal = (x, y, z)
            back = code.times(goal, origin)
            origin = (-back[0], -back[1], -back[2])
        first, last = self.places[0], self.places[-1]
        base = transposed(first.rows)
        tip = code.times(base, code.minus(origin, first.origin))
        x, y, z = (code.times(base, code.times(goal, column)) for column in last.rows)
        way = code.times(transposed((x, y, z)), last.origin)
        return x, y, z, code.minus(tip, way), tip


def _let_meet(frames: list[Transform], structure: Structure, size: float) -> None:
    """Move frames along their axes into the points in which the axes meet."""
    axes = Axes(tuple(frames), IN_PLACE, size, structure.tolerance)
    last = len(frames) - 1
    pairs = [(last - 1, last)]
    if structure.family is Family.SPHERICAL_WRIST:
        pairs.append((last - 2, last - 1))
    if structure.first_three is FirstThree.FIRST_AND_SECOND_MEET:
        pairs.append((0, 1))
    if structure.first_three is FirstThree.SECOND_AND_THIRD_MEET:
        pairs.append((1, 2))
    for pair in pairs:
        point = axes.meeting(*pair)
        for index in pair if point is not None else ():
            frames[index] = homogeneous(rotation_of(frames[index]), point or (0, 0, 0))


def _constant(frame: Transform) -> Place:
    """Return a place of numbers, cleaned of rounding."""
    rows = [tuple(Term(_clean(entry)) for entry in row[:3]) for row in frame[:3]]
    x, y, z = (Term(row[3] if abs(row[3]) > CLEAN_MM else 0.0) for row in frame[:3])
    return Place((rows[0], rows[1], rows[2]), (x, y, z))  # type: ignore[arg-type]


def _clean(entry: float) -> float:
    whole = float(round(entry))
    return whole if abs(entry - whole) < CLEAN else entry
