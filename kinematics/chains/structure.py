"""The structure of an arm, by which it is solved in closed form, and its constant frames.

An arm has a closed form if some of its axes meet or are parallel (Pieper, 1968). Two classes are
solved here, to which nearly every arm with five or six turning joints belongs that is built; any
other is solved numerically. Only the relation of each axis to the next in one posture is examined
(the axes of the product of exponentials), so that both conventions and any choice of frames give
the same class. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
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

# Axes that lean less than this towards each other are parallel, and those that pass each other
# nearer than this share of the arm's length meet: on a metre it is 1e-5 mm.
EXACT = 1e-8


class Family(Enum):
    """The class of an arm: the property that allows a closed form."""

    SPHERICAL_WRIST = (
        "spherical wrist: the last three axes meet in one point, axes 2 and 3 are parallel"
    )
    THREE_PARALLEL = "three parallel axes: 2, 3 and 4"


@dataclass(frozen=True, slots=True)
class Axes:
    """Frames whose z axes are the joint axes of a posture, and the tool's frame in it.

    `size_mm` is the arm's length.
    """

    frames: tuple[Transform, ...]
    hand: Transform
    size_mm: float

    def pair(self, first: int, second: int) -> AxisPair:
        """Return how two axes lie to each other, but for rounding."""
        one, other = (
            AxisLine(position_of(frame), z_axis_of(frame))
            for frame in (self.frames[first], self.frames[second])
        )
        return relate(one, other, one.point, EXACT, EXACT * self.size_mm)

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
        near = distance(points[0], points[1]) <= EXACT * self.size_mm
        return points[0] if near else None


def axes_of(chain: Chain) -> Axes:
    """Return the axes of a chain in its zero position."""
    frames = chain.frames(chain.zero)
    kept = frames[:-1] if chain.convention is Convention.STANDARD else frames[1:]
    return Axes(kept, chain.fk(chain.zero), max(chain.longest_reach_mm, 1.0))


def family_of(chain: Chain) -> Family | None:
    """Return the class that a chain belongs to."""
    count = len(chain)
    if count not in (5, 6) or any(kind is not JointKind.REVOLUTE for kind in chain.kinds):
        return None
    axes = axes_of(chain)
    if axes.parallel(0, 1) or not axes.parallel(1, 2):
        return None
    if axes.parallel(2, 3) and (count == 5 or axes.meeting(4, 5) is not None):
        return Family.THREE_PARALLEL
    if count == 6 and axes.all_meeting(3, 4, 5) is not None:
        return Family.SPHERICAL_WRIST
    return None


def why_no_family(chain: Chain) -> str:
    """Return the reason why a chain belongs to no class."""
    count = len(chain)
    if any(kind is not JointKind.REVOLUTE for kind in chain.kinds):
        return "a joint slides, and the classes are of turning joints"
    if count not in (5, 6):
        return f"the classes are of five or six joints, not of {count}"
    if count == 5:
        return "axes 2, 3 and 4 are not parallel, or axis 1 is parallel to them"
    return (
        "axes 2 and 3 are not parallel (or axis 1 is too), or neither axis 4 is parallel to them "
        "while axes 5 and 6 meet, nor do the last three axes meet in one point"
    )


# An arm's constant places as code sees it that finds postures, in the order in which it does.
#
# Every frame has its joint's axis as z, and each stands at a constant place in the one before it,
# turned about z by that one's joint: T = C0 Rz(q1) C1 Rz(q2) C2 ... Rz(qn) Cn. The frames of axes
# that meet share their origin.

# An entry of a constant rotation this near to 0, 1 or -1 is that number.
CLEAN = 1e-12

# A length this short is nothing.
CLEAN_MM = 1e-10


class Place(NamedTuple):
    """A frame in another one: how it is turned, and where it stands."""

    rows: Rows3
    origin: Vector3


class Layout:
    """An arm's constant places, in the order in which its joints are solved, and the code so far.

    `x`, `y`, `z` and `origin` are the goal for the last joint's frame, seen from C0. `tip` is the
    goal for the tool there; in the last joint's frame it is at `last_origin`.
    """

    def __init__(self, chain: Chain, family: Family) -> None:
        self.code = CodeLines()
        axes = axes_of(chain)
        self.size = axes.size_mm
        ways = pairwise((IN_PLACE, *_let_meet(axes, family), axes.hand))
        self.places = [_constant(compose(invert(one), other)) for one, other in ways]
        self.free = [Term(1.0, f"f{index}") for index in range(len(chain))]
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
        """Write lines that keep postures, given by their angles."""
        for angles in postures:
            self.code.write(f"found.append(({', '.join('{}' for _ in angles)}))", *angles)

    def _asked(self) -> tuple[Vector3, Vector3, Vector3, Vector3, Vector3]:
        code = self.code
        cells = [[Term(1.0, f"g{row}{column}") for column in range(4)] for row in range(3)]
        x, y, z, origin = ((a, b, c) for a, b, c in zip(*cells, strict=True))
        goal: Rows3 = transposed((x, y, z))
        first, last = self.places[0], self.places[-1]
        base = transposed(first.rows)
        tip = code.times(base, code.minus(origin, first.origin))
        x, y, z = (code.times(base, code.times(goal, column)) for column in last.rows)
        way = code.times(transposed((x, y, z)), last.origin)
        return x, y, z, code.minus(tip, way), tip


def _let_meet(axes: Axes, family: Family) -> list[Transform]:
    """Return the frames, those at the hand moved along their axes to where these meet."""
    frames, last = list(axes.frames), len(axes.frames) - 1
    pairs = [(last - 1, last)]
    if family is Family.SPHERICAL_WRIST:
        pairs.append((last - 2, last - 1))
    for pair in pairs:
        point = axes.meeting(*pair)
        for index in pair if point is not None else ():
            frames[index] = homogeneous(rotation_of(frames[index]), point or (0, 0, 0))
    return frames


def _constant(frame: Transform) -> Place:
    """Return a place of numbers, cleaned of rounding."""
    rows = [tuple(Term(_clean(entry)) for entry in row[:3]) for row in frame[:3]]
    x, y, z = (Term(row[3] if abs(row[3]) > CLEAN_MM else 0.0) for row in frame[:3])
    return Place((rows[0], rows[1], rows[2]), (x, y, z))  # type: ignore[arg-type]


def _clean(entry: float) -> float:
    whole = float(round(entry))
    return whole if abs(entry - whole) < CLEAN else entry
