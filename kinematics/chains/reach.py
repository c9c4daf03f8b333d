"""Postures spread evenly over joint limits, to see what an arm reaches: some thousand, one by one.

`many` takes a million of the same postures at once, with numpy. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from kinematics.chains.chain import Chain
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError

Span = tuple[float, float]

MOST_CORNERS = 256
"""Corners of the joint limits that are sampled: all of them, of up to eight joints."""


@dataclass(frozen=True, slots=True)
class Spread:
    """`count` postures spread over the spans of joints, the same at every call, and the corners.

    The posture of number n takes of each span the fraction of 0.5 + n * step (M. Roberts, "The
    unreasonable effectiveness of quasirandom sequences", 2018): the steps are powers of a
    generalised golden ratio, so that no posture is near another. `corners` are postures with
    every joint at one of its ends.
    """

    spans: tuple[Span, ...]
    steps: tuple[float, ...]
    corners: tuple[tuple[float, ...], ...]
    count: int

    def postures(self) -> Iterator[tuple[float, ...]]:
        """Yield the corners, then the postures by their numbers."""
        yield from self.corners
        for number in range(1, self.count + 1):
            yield tuple(
                low + (high - low) * ((0.5 + number * step) % 1.0)
                for (low, high), step in zip(self.spans, self.steps, strict=True)
            )


def spread_over(spans: Sequence[Span], count: int) -> Spread:
    """Return how `count` postures are spread. Raises `KinematicsError` for a count below 1."""
    if count < 1:
        raise KinematicsError(f"at least one posture must be sampled, not {count}")
    ratio = 2.0
    for _ in range(64):  # towards the root of ratio^(joints + 1) = ratio + 1
        ratio = (1.0 + ratio) ** (1.0 / (len(spans) + 1))
    steps = tuple(ratio**-number for number in range(1, len(spans) + 1))
    corners = tuple(product(*spans)) if 2 ** len(spans) <= MOST_CORNERS else ()
    return Spread(tuple(spans), steps, corners, count)


def spans_of(chain: Chain) -> tuple[Span, ...]:
    """Return the joints' limits; a joint that turns without end takes one turn.

    Raises `KinematicsError` for a sliding joint without limits.
    """
    return tuple(_span(chain, index) for index in range(len(chain)))


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
