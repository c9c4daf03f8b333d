"""A million postures of any chain at once, with numpy: where the tool comes, and maps of the reach.

The function that `generated` writes for the place of one posture is run on whole columns of joint
values. Postures are taken in blocks whose intermediate arrays stay in the processor's
cache: a million of a six-axis arm take some 0.2 s. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from kinematics.chains.chain import Chain
from kinematics.chains.generated import functions_of, place_source
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError
from kinematics.limits import Span, Spread, spread_over

Array: TypeAlias = npt.NDArray[np.float64]

# Postures in a block: as few as keep a call's own cost small, as many as the caches hold.
BLOCK = 8192


def reach_maps(
    chain: Chain, planes: Sequence[tuple[int, int]], count: int, cells: int
) -> list[Array]:
    """Return places that the tool was brought to, for each plane one of each of its cells: (N, 2).

    The postures are those of `spread_over` for the joint limits. A plane is two of x, y and z by
    their numbers, 0, 1 and 2; the larger side of the reach in it is cut into `cells`. The places
    furthest along each axis are among them. Raises as `spread_over` and `spans_of` do.
    """
    spread = spread_over(spans_of(chain), count)
    tips = _tips(chain, _blocks(spread), len(spread.corners) + count)
    return [_one_of_each_cell(tips[:, across], tips[:, up], cells) for across, up in planes]


def _blocks(spread: Spread) -> Iterator[Array]:
    """Yield what `Spread.postures` does, a block of postures at a time, a row for each joint."""
    if spread.corners:
        yield np.array(spread.corners).T
    lows, highs = np.array(spread.spans).T[:, :, None]
    step = np.array(spread.steps)[:, None]
    for first in range(1, spread.count + 1, BLOCK):
        numbers = np.arange(float(first), min(first + BLOCK, spread.count + 1))
        yield lows + (highs - lows) * ((0.5 + numbers * step) % 1.0)


def _tips(chain: Chain, blocks: Iterator[Array], count: int) -> Array:
    place, tips = _place(chain), np.empty((3, count))
    start = 0
    for values in blocks:
        end = start + values.shape[1]
        (found,) = place(values)
        for axis, coordinate in enumerate(found):
            tips[axis, start:end] = coordinate
        start = end
    return tips.T


def _place(chain: Chain) -> Callable[[Array], Sequence[Sequence[Array]]]:
    """Return the generated function with numpy's sine and cosine in the place of `math`'s."""
    called = {"sin": np.sin, "cos": np.cos}
    made = functions_of(place_source(chain), called, "kinematics of many")
    place: Callable[[Array], Sequence[Sequence[Array]]] = made["place"]
    return place


def _one_of_each_cell(across: Array, up: Array, cells: int) -> Array:
    axes = across, up  # one after the other: numpy is twice as quick in a single long row
    size = max(float(axis.max() - axis.min()) for axis in axes) / cells or 1.0
    columns, rows = (
        np.minimum((axis - axis.min()) / size, cells - 1).astype(np.intp) for axis in axes
    )
    first = np.full(cells * cells, -1)
    first[columns * cells + rows] = np.arange(len(across))
    ends = [end for axis in axes for end in (axis.argmin(), axis.argmax())]
    found = np.unique([*first[first >= 0], *ends])
    return np.stack((across[found], up[found]), axis=1)


def spans_of(chain: Chain) -> tuple[Span, ...]:
    """Return the joints' limits; a joint that turns without end takes one turn.

    Raises `KinematicsError` for a sliding joint without limits.
    """
    return tuple(_span(chain, index) for index in range(len(chain)))


def _span(chain: Chain, index: int) -> Span:
    link = chain.links[index]
    if link.bounded:
        return link.low, link.high
    if link.kind is JointKind.REVOLUTE:
        return -math.pi, math.pi
    raise KinematicsError(
        f"joint {chain.joint_names[index]!r} slides without limits, so its reach has no end: "
        "give its link low and high"
    )
