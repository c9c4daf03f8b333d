"""An arm's constant places as code sees it that finds postures, in the order in which it does.

Every frame has its joint's axis as z, and each stands at a constant place in the one before it,
turned about z by that one's joint: T = C0 Rz(q1) C1 Rz(q2) C2 ... Rz(qn) Cn. The frames of axes
that meet share their origin. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from kinematics.chains.chain import Chain
from kinematics.chains.code_lines import CodeLines, Rows3, Term, Vector3, transposed
from kinematics.chains.structure import FIXED_RAD, Axes, Family, FirstThree, Structure, axes_of
from kinematics.chains.subproblems import turn_of, turned
from kinematics.frames.transforms import (
    IN_PLACE,
    Transform,
    compose,
    homogeneous,
    invert,
    rotation_of,
)

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
