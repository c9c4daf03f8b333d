"""The elbow triangle: two links of a plane and the line from the first joint to the tip.

The closed form of every planar pair of links (McKerrow, chapter 4, sections 11 and 16), written
for numbers of any kind: no step compares values. Lengths in mm, angles in rad, measured from the
x axis towards the y axis of whatever plane the two links lie in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType

from kinematics.frames.numbers import atan2, sqrt
from kinematics.limits import wrap
from kinematics.textbook.systems.named import NamedSingularity, Quantity

# The two branches of an arm that lies along x, seen with y up.
ELBOWS = MappingProxyType({"elbow up": (-1.0,), "elbow down": (1.0,)})

STRETCHED = "stretched: both elbow postures are one, and the tip cannot move along the arm"
FOLDED = "folded: both elbow postures are one, and the tip cannot move along the arm"


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
    cosine = (squared - first * first - second * second) / (2.0 * first * second)
    if isinstance(cosine, float):  # out of reach, the links point at the tip
        cosine = min(max(cosine, -1.0), 1.0)
    sine = side * sqrt(1.0 - cosine * cosine)
    direction = atan2(y, x)
    lift = atan2(second * sine, first + second * cosine)
    bend = atan2(sine, cosine)
    return Triangle(direction - lift, bend, sqrt(squared), cosine, direction, lift)


def root(squared: float) -> float:
    """Return a square root, of 0 for a float below 0; of any kind of number."""
    return sqrt(max(squared, 0.0) if isinstance(squared, float) else squared)  # type: ignore[no-any-return]


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
