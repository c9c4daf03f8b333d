"""Places that a chain's tool is brought to: evenly spread postures, and the corners of its limits.

`many` does the same for a million postures, with numpy. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

from kinematics.chains.chain import Chain
from kinematics.chains.generated import generated
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError
from kinematics.frames.transforms import position_of
from kinematics.frames.vectors import Vector

Span = tuple[float, float]

MOST_CORNERS = 256
"""Corners of the joint limits that are sampled: all of them, of up to eight joints."""


@dataclass(frozen=True, slots=True)
class Reach:
    """Places that a chain's tool was brought to: evenly spread postures and corners of its limits.

    What was not sampled may reach a little farther. `points[i]` belongs to `postures[i]`.
    """

    points: tuple[Vector, ...]
    postures: tuple[tuple[float, ...], ...]

    @property
    def box_mm(self) -> tuple[Span, Span, Span]:
        """Least and greatest x, y and z."""
        x, y, z = ((min(axis), max(axis)) for axis in zip(*self.points, strict=True))
        return x, y, z

    @property
    def radius_mm(self) -> Span:
        """Least and greatest distance from the first joint's axis frame, the world's z axis."""
        radii = [math.hypot(x, y) for x, y, _ in self.points]
        return min(radii), max(radii)


@dataclass(frozen=True, slots=True)
class Spread:
    """How postures are spread over the joint limits of a chain, the same at every call.

    The posture of number n takes of each span the fraction of 0.5 + n * step (M. Roberts, "The
    unreasonable effectiveness of quasirandom sequences", 2018): the steps are powers of a
    generalised golden ratio, so that no posture is near another. `corners` are postures with
    every joint at one of its ends.
    """

    spans: tuple[Span, ...]
    steps: tuple[float, ...]
    corners: tuple[tuple[float, ...], ...]


def spread_over(chain: Chain, count: int) -> Spread:
    """Return how `count` postures are spread; a joint that turns without end takes one turn.

    Raises `KinematicsError` for a sliding joint without limits, or a count below 1.
    """
    if count < 1:
        raise KinematicsError(f"at least one posture must be sampled, not {count}")
    spans = tuple(_span(chain, index) for index in range(len(chain)))
    ratio = 2.0
    for _ in range(64):  # towards the root of ratio^(joints + 1) = ratio + 1
        ratio = (1.0 + ratio) ** (1.0 / (len(chain) + 1))
    steps = tuple(ratio**-number for number in range(1, len(chain) + 1))
    return Spread(spans, steps, tuple(product(*spans)) if 2 ** len(spans) <= MOST_CORNERS else ())


def sampled_reach(chain: Chain, count: int = 4096) -> Reach:
    """Return places that any chain reaches within its limits. Raises as `spread_over` does."""
    spread, fk = spread_over(chain, count), generated(chain).fk
    postures = [
        tuple(
            low + (high - low) * ((0.5 + number * step) % 1.0)
            for (low, high), step in zip(spread.spans, spread.steps, strict=True)
        )
        for number in range(1, count + 1)
    ]
    all_postures = (*spread.corners, *postures)
    return Reach(tuple(position_of(fk(posture)) for posture in all_postures), all_postures)


def _span(chain: Chain, index: int) -> Span:
    link = chain.links[index]
    if math.isfinite(link.low) and math.isfinite(link.high):
        return link.low, link.high
    if link.kind is JointKind.REVOLUTE:
        return -math.pi, math.pi
    raise KinematicsError(
        f"joint {chain.joint_names[index]!r} slides without limits, so its reach has no end: "
        "give its link low and high"
    )
