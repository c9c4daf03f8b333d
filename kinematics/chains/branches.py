"""The structure of an arm, by which it is solved in closed form, and its postures for a frame.

An arm has a closed form if some of its axes meet or are parallel (Pieper, 1968). Two classes are
solved here, to which nearly every arm with five or six turning joints belongs that is built; any
other is solved numerically. Only the axes of the zero position are examined, so that both
conventions and any choice of frames give the same class. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

from kinematics.chains.assignment import AxisLine, AxisPair, Relation, relate
from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.rotations import columns, rotate
from kinematics.frames.transforms import (
    IN_PLACE,
    Transform,
    compose,
    homogeneous,
    inverted,
    position_of,
    rotation_of,
    z_axis_of,
)
from kinematics.frames.vectors import X_AXIS, Vector, add, distance, dot, scale, subtract

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
    """Frames whose z axes are the joint axes of the zero position, and the tool's frame in it.

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


def axes_of(chain: Chain) -> Axes:
    """Return the axes of a chain in its zero position."""
    frames = chain.frames(chain.zero)
    kept = frames[:-1] if chain.convention is Convention.STANDARD else frames[1:]
    return Axes(kept, chain.fk(chain.zero), max(chain.longest_reach_mm, 1.0))


def family_of(chain: Chain) -> Family | str:
    """Return the class that a chain belongs to, or the reason why it belongs to none."""
    count = len(chain)
    if any(kind is not JointKind.REVOLUTE for kind in chain.kinds):
        return "a joint slides, and the classes are of turning joints"
    if count not in (5, 6):
        return f"the classes are of five or six joints, not of {count}"
    axes = axes_of(chain)
    if axes.parallel(1, 2) and not axes.parallel(0, 1):
        if axes.parallel(2, 3) and (count == 5 or axes.meeting(4, 5) is not None):
            return Family.THREE_PARALLEL
        points = (axes.meeting(3, 4), axes.meeting(4, 5)) if count == 6 else (None, None)
        if (
            points[0] is not None
            and points[1] is not None
            and distance(points[0], points[1]) <= EXACT * axes.size_mm
        ):
            return Family.SPHERICAL_WRIST
    if count == 5:
        return "axes 2, 3 and 4 are not parallel, or axis 1 is parallel to them"
    return (
        "axes 2 and 3 are not parallel (or axis 1 is too), or neither axis 4 is parallel to them "
        "while axes 5 and 6 meet, nor do the last three axes meet in one point"
    )


# Every posture of an arm for a frame of its tool, joint by joint.
#
# An arm is a row of constant frames and turns about z: T = C0 Rz(q1) C1 Rz(q2) C2 ... Rz(qn) Cn.
# Two equations give every joint (Paden and Kahan; the subproblems of Elias and Wen, 2022,
# "IK-Geo"): `angle_between_levels`, a direction turned to another one, and `roots`, a cos q +
# b sin q = c, the form of every condition on the height of a turned point or on its distance from
# another point.
#
# Of the arms solved here, axes 2 and 3 are parallel. The height of a point of the hand along them
# gives joint 1, the triangle of joints 2 and 3 is level (McKerrow, chapter 4, section 16), and what
# is left of the hand's turn gives the other joints.

Posture = tuple[float, ...]

# Share of their usual size below which an angle's coefficients leave that angle free.
NO_MATTER = 1e-10

# How far (squared, as a share) a goal may lie beyond an edge and still be solved at the edge.
#
# Rounding needs far less. The caller compares every posture with the goal afterwards.
TOUCHING = 1e-6

# Axes whose directions have a smaller cosine are at a right angle.
SQUARE = 1e-12


class BranchFinder:
    """The constant frames of one arm, and its postures for a goal."""

    def __init__(self, chain: Chain, family: Family) -> None:
        axes = axes_of(chain)
        ways = pairwise((IN_PLACE, *_let_meet(axes, family), axes.hand))
        self._frames = [compose(inverted(one), other) for one, other in ways]
        self._rows = [rotation_of(frame) for frame in self._frames]
        self._places = [position_of(frame) for frame in self._frames]
        self._size = axes.size_mm
        self._count = len(chain)
        self._family = family
        # the directions, 1 or -1, of axes 3 and 4 against the axes before them
        self._third, self._fourth = (math.copysign(1.0, self._rows[i][2][2]) for i in (2, 3))
        self._height = self._places[2][2] + self._third * self._places[3][2]
        if family is Family.THREE_PARALLEL:
            self._height += self._third * self._fourth * self._places[4][2]

    def postures(
        self, goal: Transform, free: Sequence[float], *, heading_free: bool = False
    ) -> Iterator[Posture]:
        """Yield the postures for a frame; a joint that may take any value has the one in `free`.

        With `heading_free` the goal may be turned about the world's z axis through its origin: what
        is asked of five joints, the first axis vertical and the next three parallel.
        """
        finish = self._wrist if self._family is Family.SPHERICAL_WRIST else self._parallel
        for first, hand, origin in self._first(goal, free, heading_free):
            seen = [self._into(1, column) for column in hand]
            for rest in finish(seen, self._into(1, subtract(origin, self._places[1])), free):
                yield first, *rest

    def _first(
        self, goal: Transform, free: Sequence[float], heading_free: bool
    ) -> Iterator[tuple[float, list[Vector], Vector]]:
        """Yield joint 1's angles, and the axes and the origin of the last joint's frame there.

        Both are seen from where joint 1 carries them, before the constant frame behind it.
        """
        inner = compose(inverted(self._frames[0]), goal)
        last = compose(inner, inverted(self._frames[-1]))
        hand, origin = list(columns(rotation_of(last))), position_of(last)
        axis = columns(self._rows[1])[2]
        height = self._height + dot(axis, self._places[1])
        if heading_free:
            tip = position_of(inner)
            for heading in self._roots(*self._lean(hand[2]), free[0]):
                turned = [_unturned(column, heading) for column in hand]
                way = _combined(turned, self._places[-1])
                for angle in self._roots(*_at_height(axis, tip, height + dot(axis, way)), free[0]):
                    yield angle, turned, subtract(_unturned(tip, angle), way)
            return
        equation = _at_height(axis, origin, height)
        if self._count == 5:
            # near the base axis the height says little of joint 1, and a vertical hand's lean
            # nothing: take what says more
            equation = max(equation, self._lean(hand[2]), key=lambda one: math.hypot(*one[:2]))
        for angle in self._roots(*equation, free[0]):
            turned = [_unturned(column, angle) for column in hand]
            yield angle, turned, _unturned(origin, angle)

    def _lean(self, last_axis: Vector) -> tuple[float, float, float]:
        """Return the equation of joint 1 by which the last of five axes leans to axis 2."""
        lean = self._third * self._fourth * self._rows[4][2][2]
        a, b, c = _at_height(columns(self._rows[1])[2], last_axis, lean)
        return self._size * a, self._size * b, self._size * c

    def _triangle(self, end: Vector, free: Sequence[float]) -> Iterator[tuple[float, float]]:
        """Yield the angles of joints 2 and 3 that bring joint 4's origin to a point."""
        start, arm = self._places[2], self._places[3]
        towards = self._into(2, (start[0], start[1], 0.0))
        square = sum(x * x for x in end[:2]) - sum(x * x for v in (start, arm) for x in v[:2])
        a, b, c = 2.0 * _along(towards, arm), 2.0 * _across(arm, towards), square
        for third in roots(a, b, c, free[2], self._size**2):
            reached = add(start, rotate(self._rows[2], _turned((arm[0], arm[1], 0.0), third)))
            yield angle_between_levels(reached, end, free[1], self._size), third

    def _wrist(
        self, hand: list[Vector], end: Vector, free: Sequence[float]
    ) -> Iterator[tuple[float, ...]]:
        """Yield joints 2 to 6 of an arm whose last three axes meet: `end` is where they do.

        Axis 6's lean to axis 4 gives joint 5, the directions of axis 6 and of x the other two.
        """
        row, last = self._rows[4][2], columns(self._rows[5])[2]
        square = max(abs(row[2]), abs(last[2])) <= SQUARE
        for second, third in self._triangle(end, free):
            x, _, z = (
                self._into(3, _unturned(self._into(2, _unturned(one, second)), third))
                for one in hand
            )
            gap = _along(z, z) if square else None  # 1 - z² would lose digits
            for fifth in roots(*_at_height(last, row, z[2]), free[4], 1.0, gap):
                leaning = rotate(self._rows[4], _turned(last, fifth))
                fourth = angle_between_levels(leaning, z, free[3], 1.0)
                left = self._into(5, _unturned(self._into(4, _unturned(x, fourth)), fifth))
                yield second, third, fourth, fifth, math.atan2(left[1], left[0])

    def _parallel(
        self, hand: list[Vector], end: Vector, free: Sequence[float]
    ) -> Iterator[tuple[float, ...]]:
        """Yield joints 2 to 5 or 6 of an arm whose axes 2 to 4 are parallel (Elias and Wen, 5.4).

        What is seen along these axes gives the joints beyond them; then joints 2 to 4 have a sum,
        and the triangle of joints 2 and 3 ends where joint 4 must be.
        """
        both = self._third * self._fourth
        start = self._through_three(X_AXIS)
        for last, pointing in self._beyond(hand, both, free):
            total = angle_between_levels(start, _combined(hand, pointing), 0.0, 0.0)
            hinge = subtract(end, _turned(self._through_three(self._places[4]), total))
            for second, third in self._triangle(hinge, free):
                left = both * (total - second - self._third * third)
                yield second, third, math.remainder(left, math.tau), *last

    def _beyond(
        self, hand: list[Vector], both: float, free: Sequence[float]
    ) -> Iterator[tuple[tuple[float, ...], Vector]]:
        """Yield the joints beyond the fourth, and where the last frame sees x of joint 4's link."""
        x, y, z = hand
        row = scale(both, self._rows[4][2])
        if self._count == 5:
            fifth = angle_between_levels((x[2], y[2]), row, free[4], 0.0)
            yield (fifth,), _unturned(self._into(4, X_AXIS), fifth)
            return
        last = columns(self._rows[5])[2]
        for fifth in roots(*_at_height(last, row, z[2]), free[4], 1.0):
            turned = self._into(5, _unturned(row, fifth))
            sixth = angle_between_levels((x[2], y[2]), turned, free[5], 1.0)
            pointing = self._into(5, _unturned(self._into(4, X_AXIS), fifth))
            yield (fifth, sixth), _unturned(pointing, sixth)

    def _roots(self, a: float, b: float, c: float, free: float) -> list[float]:
        return roots(a, b, c, free, self._size)

    def _through_three(self, v: Vector) -> Vector:
        """Return a direction of joint 4's frame in joint 2's, where the three joints' sum is 0."""
        return rotate(self._rows[2], rotate(self._rows[3], v))

    def _into(self, index: int, v: Vector) -> Vector:
        """Return a direction of joint `index`'s link as the next joint's frame sees it."""
        (a, b, c), (d, e, f), (g, h, i) = self._rows[index]
        x, y, z = v
        return a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z


def roots(
    a: float, b: float, c: float, free: float, size: float, gap: float | None = None
) -> list[float]:
    """Return the angles with a cos q + b sin q = c: two, one at the edge of reach, or none.

    `size` is the usual size of a and b; if both are next to nothing, any angle is a solution, and
    `free` is returned. `gap` is a² + b² - c², where the caller knows it with more digits.
    """
    square = a * a + b * b
    if square <= (NO_MATTER * size) ** 2:
        return [free] if abs(c) <= 10.0 * NO_MATTER * size else []
    gap = square - c * c if gap is None else gap
    if gap < -TOUCHING * square:
        return []
    root, c = (math.sqrt(gap), c) if gap > 0.0 else (0.0, math.copysign(math.sqrt(square), c))
    signs = (root, -root) if root else (0.0,)
    return [math.atan2(b * c + a * one, a * c - b * one) for one in signs]


def angle_between_levels(u: Sequence[float], v: Sequence[float], free: float, size: float) -> float:
    """Return the angle about z that turns u to v; the free one where v is on the axis."""
    if _along(v, v) <= (NO_MATTER * size) ** 2:
        return free
    return math.atan2(_across(u, v), _along(u, v))


def _at_height(axis: Vector, point: Vector, height: float) -> tuple[float, float, float]:
    """Return the equation of the angle q that has axis . Rz(-q) point at a height."""
    return _along(axis, point), _across(axis, point), height - axis[2] * point[2]


def _along(u: Sequence[float], v: Sequence[float]) -> float:
    return u[0] * v[0] + u[1] * v[1]


def _across(u: Sequence[float], v: Sequence[float]) -> float:
    return u[0] * v[1] - u[1] * v[0]


def _turned(v: Vector, angle: float) -> Vector:
    """Return a vector turned about z."""
    c, s = math.cos(angle), math.sin(angle)
    return c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]


def _unturned(v: Vector, angle: float) -> Vector:
    return _turned(v, -angle)


def _combined(axes: Sequence[Vector], v: Vector) -> Vector:
    """Return a vector given in axes."""
    x, y, z = axes
    return add(add(scale(v[0], x), scale(v[1], y)), scale(v[2], z))


def _let_meet(axes: Axes, family: Family) -> list[Transform]:
    """Return the frames, those at the hand moved along their axes to where these meet."""
    frames, last = list(axes.frames), len(axes.frames) - 1
    pairs = [(last - 1, last)]
    if family is Family.SPHERICAL_WRIST:
        pairs.append((last - 2, last - 1))
    for pair in pairs:
        point = axes.meeting(*pair)
        for index in pair if point is not None else ():
            frames[index] = homogeneous(rotation_of(frames[index]), point or (0.0, 0.0, 0.0))
    return frames
