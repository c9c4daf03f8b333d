"""What kind of arm a link table describes, as far as its inverse kinematics goes.

An arm is solved in closed form where axes meet or are parallel (Pieper, 1968). The classes are
those of Ostermeier, Külz and Althoff (2025), "Automatic geometric decomposition for analytical
inverse kinematics", as far as they need no search. All that is looked at is how each axis lies to
the next at one posture (the product of exponentials' axes), so that both conventions and any choice
of frames give the same class. Lengths in mm, angles in rad.
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
from kinematics.chains.subproblems import turn_of, turned
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

FIXED_RAD = 0.7
"""Where a seven-joint arm's fixed joint stands while the arm is classified: any angle does at which
no axes are parallel by chance."""


class Family(Enum):
    """What lets an arm be solved in closed form."""

    SPHERICAL_WRIST = "spherical wrist: the last three axes meet in one point"
    THREE_PARALLEL = "three parallel axes: 2, 3 and 4"
    LAST_TWO_MEET = "the last two of five axes meet"


class FirstThree(Enum):
    """How the first three joints place the point in which the wrist's axes meet."""

    SECOND_AND_THIRD_PARALLEL = "axes 2 and 3 are parallel"
    FIRST_AND_SECOND_PARALLEL = "axes 1 and 2 are parallel"
    FIRST_AND_SECOND_MEET = "axes 1 and 2 meet"
    SECOND_AND_THIRD_MEET = "axes 2 and 3 meet"
    GENERAL = "the first three axes are neither parallel nor do they meet"


@dataclass(frozen=True, slots=True)
class Structure:
    """The class of an arm.

    `from_hand` says that the axes are counted from the hand: the arm is solved backwards. `fixed`
    is the index of the joint of a seven-joint arm that keeps its angle while the others are
    solved. `tolerance` is how far axes may lean or pass each other and still count as of the class:
    beyond `EXACT` the class is only nearly the arm's, and its postures have to be improved.
    """

    family: Family
    first_three: FirstThree | None = None
    from_hand: bool = False
    fixed: int | None = None
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
        if self.fixed is not None:
            said += f", while joint {self.fixed + 1} keeps its angle"
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

    def all_meeting(self, first: int, second: int, third: int) -> Vector | None:
        """Return the point in which three axes meet."""
        points = self.meeting(first, second), self.meeting(second, third)
        if points[0] is None or points[1] is None:
            return None
        near = distance(points[0], points[1]) <= self.tolerance * self.size_mm
        return points[0] if near else None

    def without(self, index: int) -> Axes:
        """Return the axes but one, whose joint keeps its angle."""
        kept = (*self.frames[:index], *self.frames[index + 1 :])
        return replace(self, frames=kept)

    def backwards(self) -> Axes:
        """Return the axes counted from the hand."""
        return replace(self, frames=self.frames[::-1])


def axes_of(chain: Chain, values: Sequence[float], tolerance: float = EXACT) -> Axes:
    """Return the axes of a chain in a posture."""
    frames = chain.frames(values)
    kept = frames[:-1] if chain.convention is Convention.STANDARD else frames[1:]
    return Axes(kept, chain.fk(values), max(chain.longest_reach_mm, 1.0), tolerance)


def structures(chain: Chain) -> Iterator[Structure]:
    """Yield the classes that a chain belongs to, those that are solved best first.

    Those that it nearly belongs to come last, of five and six joints.
    """
    count = len(chain)
    if any(kind is not JointKind.REVOLUTE for kind in chain.kinds):
        return
    if count in (5, 6):
        for tolerance in (EXACT, NEARLY):
            yield from _structures(axes_of(chain, chain.zero, tolerance), None)
    elif count == 7:
        for fixed in (2, 3, 4, 1, 5, 0, 6):  # the upper arm's turn first, as in a human arm
            posture = tuple(FIXED_RAD if index == fixed else 0.0 for index in range(count))
            yield from _structures(axes_of(chain, posture).without(fixed), fixed)


def why_no_structure(chain: Chain) -> str:
    """Return the reason why a chain is of no class."""
    count = len(chain)
    if any(kind is not JointKind.REVOLUTE for kind in chain.kinds):
        return "a joint slides, and the classes are of turning joints"
    if count not in (5, 6, 7):
        return f"the classes are of five to seven joints, not of {count}"
    if count == 7:
        return "whichever joint is kept still, the other six are of no class"
    axes = axes_of(chain, chain.zero)
    if any(seen.parallel(0, 1) and seen.parallel(1, 2) for seen in (axes, axes.backwards())):
        return "three axes in a row at one end are parallel: they move a point in a plane only"
    wrist = "last three axes meet in one point" if count == 6 else "last two axes meet"
    return (
        f"axes 2, 3 and 4 are not parallel, nor do the {wrist}; counted from the hand it is no "
        "different"
    )


def _structures(axes: Axes, fixed: int | None) -> Iterator[Structure]:
    ends = ((False, axes), (True, axes.backwards()))
    for from_hand, seen in ends:
        if seen.parallel(1, 2) and seen.parallel(2, 3) and not seen.parallel(0, 1):
            yield Structure(Family.THREE_PARALLEL, None, from_hand, fixed, axes.tolerance)
    for from_hand, seen in ends:
        wrist = seen.all_meeting(3, 4, 5) if len(seen.frames) == 6 else seen.meeting(3, 4)
        if wrist is not None and (first_three := _first_three(seen)) is not None:
            family = Family.SPHERICAL_WRIST if len(seen.frames) == 6 else Family.LAST_TWO_MEET
            yield Structure(family, first_three, from_hand, fixed, axes.tolerance)


def _first_three(axes: Axes) -> FirstThree | None:
    """Return how the first three axes lie; None for those that move a point along a surface."""
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
    return FirstThree.GENERAL


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

    `x`, `y`, `z` and `origin` are what is asked of the last joint's frame, seen from C0, and `tip`
    is where the tool is asked there, `last_origin` further on in the last joint's frame. Counted
    from the hand, every joint turns backwards and the goal is inverted.
    """

    def __init__(self, chain: Chain, structure: Structure) -> None:
        self.code = CodeLines()
        self.structure = structure
        count, fixed = len(chain), structure.fixed
        still = [FIXED_RAD if index == fixed else 0.0 for index in range(count)]
        axes = axes_of(chain, still)
        self.size = axes.size_mm
        self.order = [index for index in range(count) if index != fixed]
        self.sign = -1.0 if structure.from_hand else 1.0
        frames, ends = list(axes.frames), (IN_PLACE, axes.hand)
        if structure.from_hand:
            self.order.reverse()
            frames.reverse()
            ends = ends[::-1]
        left_out = None
        if fixed is not None:
            left_out = count - 1 - fixed if structure.from_hand else fixed
        _let_meet(frames, left_out, structure, self.size)
        ways = pairwise((ends[0], *frames, ends[1]))
        self.places = [_constant(compose(invert(one), other)) for one, other in ways]
        if fixed is not None and left_out is not None:
            self._join(left_out, fixed)
        self.free = [Term(self.sign, f"f{index}") for index in self.order]
        self.x, self.y, self.z, self.origin, self.tip = self._asked()
        self.last_origin = self.places[-1].origin

    def __len__(self) -> int:
        return len(self.order)

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
            pairs = zip(self.order, angles, strict=True)
            values = {joint: Term(self.sign * one.factor, one.variable) for joint, one in pairs}
            if self.structure.fixed is not None:
                values[self.structure.fixed] = Term(1.0, f"f{self.structure.fixed}")
            listed = [values[joint] for joint in sorted(values)]
            self.code.write(f"found.append(({', '.join('{}' for _ in listed)}))", *listed)

    def _join(self, place: int, joint: int) -> None:
        """Make one place of the two beside a joint that keeps its angle."""
        code = self.code
        name = Term(self.sign, f"f{joint}")
        turn = turn_of(code, code.total((name,), (Term(-self.sign * FIXED_RAD),)))
        before, after = self.places[place : place + 2]
        x, y, z = (
            code.times(before.rows, turned(code, turn, column)) for column in transposed(after.rows)
        )
        way = code.times(before.rows, turned(code, turn, after.origin))
        joined = Place(transposed((x, y, z)), code.plus(before.origin, way))
        self.places[place : place + 2] = [joined]

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


def _let_meet(
    frames: list[Transform], left_out: int | None, structure: Structure, size: float
) -> None:
    """Move frames along their axes into the points in which the axes meet."""
    kept = [index for index in range(len(frames)) if index != left_out]
    axes = Axes(tuple(frames[index] for index in kept), IN_PLACE, size, structure.tolerance)
    last = len(kept) - 1
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
            frames[kept[index]] = homogeneous(rotation_of(frames[kept[index]]), point or (0, 0, 0))


def _constant(frame: Transform) -> Place:
    """Return a place of numbers, cleaned of rounding."""
    rows = [tuple(Term(_clean(entry)) for entry in row[:3]) for row in frame[:3]]
    x, y, z = (Term(row[3] if abs(row[3]) > CLEAN_MM else 0.0) for row in frame[:3])
    return Place((rows[0], rows[1], rows[2]), (x, y, z))  # type: ignore[arg-type]


def _clean(entry: float) -> float:
    whole = float(round(entry))
    return whole if abs(entry - whole) < CLEAN else entry
