"""What kind of arm a link table describes, as far as its inverse kinematics goes.

An arm is solved in closed form where axes meet or are parallel (Pieper, 1968). The classes are
those of Ostermeier, Külz and Althoff (2025), "Automatic geometric decomposition for analytical
inverse kinematics", as far as they need no search. All that is looked at is how each axis lies to
the next at one posture (the product of exponentials' axes), so that both conventions and any choice
of frames give the same class. Lengths in mm, angles in rad.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from kinematics.chains.assignment import AxisLine, AxisPair, Relation, relate
from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.transforms import Transform, position_of, z_axis_of
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
