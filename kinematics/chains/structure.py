"""The structure of an arm, by which it is solved in closed form: how its axes lie to each other.

An arm has a closed form if some of its axes meet or are parallel (Pieper, 1968). Two classes are
solved here, to which nearly every arm with five or six turning joints belongs that is built; any
other is solved numerically. Only the axes of the zero position are examined, so that both
conventions and any choice of frames give the same class. Lengths in mm, angles in rad.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from kinematics.chains.assignment import AxisLine, AxisPair, Relation, relate
from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, JointKind
from kinematics.frames.transforms import Transform, position_of, z_axis_of
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
