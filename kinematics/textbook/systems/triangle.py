"""The elbow triangle: two links of a plane and the line from the first joint to the tip.

The closed form of every planar pair of links (McKerrow, chapter 4, sections 11 and 16), written
for numbers of any kind: no step compares values. Lengths in mm, angles in rad, measured from the
x axis towards the y axis of whatever plane the two links lie in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType

from kinematics.five_axis.closed_form import REACH_MM
from kinematics.frames.numbers import atan2, sqrt
from kinematics.limits import wrap
from kinematics.textbook.systems.named import (
    NamedBranch,
    NamedSingularity,
    Quantity,
    System,
    Values,
)

STRAIGHT_SINE = 1e-7
"""An elbow whose sine is less has one posture: rounding of the tip alone makes some 1e-8."""

ELBOWS = MappingProxyType({"elbow up": (-1.0,), "elbow down": (1.0,)})
"""The two branches of an arm that lies along x, seen with y up."""

STRETCHED = "stretched: both elbow postures are one, and the tip cannot move along the arm"
FOLDED = "folded: both elbow postures are one, and the tip cannot move along the arm"
FOLDED_HOME = "folded onto the first joint: the first angle is free"


@dataclass(frozen=True, slots=True)
class Triangle:
    """First angle, second angle (relative), and what gives them.

    `direction` is the angle of the line to the tip, `lift` the angle at the first joint between
    that line and the first link.
    """

    first: float
    second: float
    span: float
    cosine: float
    direction: float
    lift: float

    def workings(self) -> tuple[Quantity, ...]:
        """Return the sides and angles as quantities, for people."""
        return (
            Quantity("D", self.span, "mm"),
            Quantity("cos(bend)", self.cosine, ""),
            Quantity("direction", self.direction, "rad"),
            Quantity("lift", self.lift, "rad"),
        )


def triangle(x: float, y: float, first: float, second: float, side: float) -> Triangle:
    """Solve the triangle of two links whose tip is at (x, y); `side` is the elbow's sign.

    cos(second angle) = (x^2 + y^2 - l1^2 - l2^2) / (2 l1 l2); first angle = direction - lift.
    """
    squared = x * x + y * y
    cosine = _bend_cosine(squared, first, second)
    sine = side * sqrt(1.0 - cosine * cosine)
    direction = atan2(y, x)
    lift = atan2(second * sine, first + second * cosine)
    bend = atan2(sine, cosine)
    return Triangle(direction - lift, bend, sqrt(squared), cosine, direction, lift)


def root(squared: float) -> float:
    """Return a square root, of 0 where rounding took a float below 0; of any kind of number."""
    return sqrt(max(squared, 0.0) if isinstance(squared, float) else squared)  # type: ignore[no-any-return]


def _bend_cosine(squared: float, first: float, second: float) -> float:
    """Return the cosine of the second angle for a squared span, with rounding beyond 1 taken off.

    Numbers that are no floats are left as they are.
    """
    cosine = (squared - first * first - second * second) / (2.0 * first * second)
    return min(max(cosine, -1.0), 1.0) if isinstance(cosine, float) else cosine


@dataclass(frozen=True, slots=True)
class Links:
    """Two links of a system's plane, and the joint at the beginning of the first.

    Where the tip is folded onto that joint, its angle is free; `absorbed` is the joint that then
    keeps the hand's direction, if any does.
    """

    first_mm: float
    second_mm: float
    joint: int = 0
    absorbed: int | None = None


def elbow_branches(
    one: System,
    goal: Values,
    seed: Values,
    distance: float,
    links: Links,
    signs: tuple[float, ...] = (),
    names: tuple[str, str] = ("elbow down", "elbow up"),
) -> list[NamedBranch]:
    """Return the branches of an elbow for a tip in reach, one where the links lie on one line.

    `signs` are those that the formulas take before the elbow's, and `names` those of the positive
    and the negative angle, which comes first. Where the tip is on the first joint (equal links,
    folded) that joint's angle is free.
    """
    first, second = links.first_mm, links.second_mm
    cosine = _bend_cosine(distance * distance, first, second)
    if 1.0 - cosine * cosine > STRAIGHT_SINE * STRAIGHT_SINE:
        return [
            NamedBranch(name, *one.formulas(one, goal, *signs, sign))
            for name, sign in ((names[1], -1.0), (names[0], 1.0))
        ]
    joints, workings = one.formulas(one, goal, *signs, 1.0)
    if cosine > 0.0:
        return [NamedBranch("elbow straight", joints, workings, (), STRETCHED)]
    if distance > REACH_MM:
        return [NamedBranch("elbow folded", joints, workings, (), FOLDED)]
    joints = _with_free(joints, links, seed[links.joint])
    free = (one.joint_names[links.joint],)
    return [NamedBranch("elbow folded", joints, workings, free, FOLDED_HOME)]


def _with_free(joints: Values, links: Links, value: float) -> Values:
    """Return the joints with the free one at a value."""
    made = list(joints)
    if links.absorbed is not None:
        made[links.absorbed] += made[links.joint] - value
    made[links.joint] = value
    return tuple(made)


def elbow_loss(bend_rad: float, first_mm: float, second_mm: float) -> tuple[str, bool]:
    """Return what a posture loses by its elbow, in words, and whether the first angle is free.

    The first angle is free where equal links are folded: the tip is on the first joint.
    """
    if abs(math.sin(bend_rad)) > STRAIGHT_SINE:
        return "", False
    if math.cos(bend_rad) > 0.0:
        return STRETCHED, False
    return FOLDED, abs(first_mm - second_mm) <= REACH_MM


def elbow_singularities(
    bend_rad: float, first_mm: float, second_mm: float
) -> list[NamedSingularity]:
    """Return how far an elbow of two links is from being straight, and from being folded."""
    bend = abs(wrap(bend_rad))
    square = first_mm**2 + second_mm**2 + 2.0 * first_mm * second_mm * math.cos(bend)
    span = math.sqrt(max(square, 0.0))
    return [
        NamedSingularity(f"elbow {STRETCHED}", bend, max(first_mm + second_mm - span, 0.0)),
        NamedSingularity(
            f"elbow {FOLDED}", math.pi - bend, max(span - abs(first_mm - second_mm), 0.0)
        ),
    ]


def to_half_turn(angle_rad: float) -> float:
    """Return how far an angle is from a multiple of half a turn."""
    return abs(math.remainder(angle_rad, math.pi))


# What two links span, whatever they belong to.


def broken_bound(distance: float, first: float, second: float) -> float | None:
    """Return the span in mm that a tip at this distance exceeds or undercuts, or None."""
    longest, shortest = first + second, abs(first - second)
    if distance > longest + REACH_MM:
        return longest
    return shortest if distance < shortest - REACH_MM else None


def brought_within(x: float, y: float, first: float, second: float) -> tuple[float, float]:
    """Return the point nearest to (x, y) that two links reach; at the joint itself, along x."""
    distance = math.hypot(x, y)
    bound = broken_bound(distance, first, second)
    if bound is None:
        return x, y
    if distance <= REACH_MM:
        return bound, 0.0
    return x * bound / distance, y * bound / distance
