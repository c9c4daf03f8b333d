"""A million postures of any chain at once, with numpy: where the tool comes, and maps of the reach.

The tool's point is carried back from the last joint to the first, for whole columns of joint values
at once. Postures are taken in blocks whose intermediate arrays stay in the processor's cache: a
million of a six-axis arm take some 0.2 s. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from kinematics.chains.chain import Chain
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError
from kinematics.frames.transforms import position_of
from kinematics.limits import Span, corners_of

Array: TypeAlias = npt.NDArray[np.float64]

# Postures in a block: as few as keep a call's own cost small, as many as the caches hold.
BLOCK = 8192


def reach_maps(
    chain: Chain, planes: Sequence[tuple[int, int]], count: int, cells: int
) -> list[Array]:
    """Return places that the tool was brought to, for each plane one of each of its cells: (N, 2).

    The postures are random ones within the joint limits, the same at every call, and the corners of
    the limits. A plane is two of x, y and z by their numbers, 0, 1 and 2; the larger side of the
    reach in it is cut into `cells`. The places furthest along each axis are among them. Raises
    `KinematicsError` for a sliding joint without limits.
    """
    spans = tuple(_span(chain, index) for index in range(len(chain)))
    tips = np.concatenate([_tips(chain, block) for block in _blocks(spans, count)])
    return [_one_of_each_cell(tips[:, across], tips[:, up], cells) for across, up in planes]


def _blocks(spans: Sequence[Span], count: int) -> Iterator[Array]:
    """Yield blocks of postures, a row for each joint."""
    if corners := corners_of(spans):
        yield np.array(corners).T
    lows, highs = np.array(spans).T[:, :, None]
    draw = np.random.default_rng(1)
    for first in range(0, count, BLOCK):
        yield draw.uniform(lows, highs, (len(spans), min(BLOCK, count - first)))


def _tips(chain: Chain, block: Array) -> Array:
    """Return the tool's place in each posture of a block, a row for each posture: (N, 3)."""
    *before, last = chain.constants
    x, y, z = (np.full(block.shape[1], at) for at in position_of(last))
    for constant, kind, values in zip(
        reversed(before), reversed(chain.kinds), block[::-1], strict=True
    ):
        if kind is JointKind.PRISMATIC:
            z = z + values
        else:
            cosines, sines = np.cos(values), np.sin(values)
            x, y = cosines * x - sines * y, sines * x + cosines * y
        (a, b, c, right), (d, e, f, ahead), (g, h, i, up), _ = constant
        x, y, z = (
            a * x + b * y + c * z + right,
            d * x + e * y + f * z + ahead,
            g * x + h * y + i * z + up,
        )
    return np.stack((x, y, z), axis=1)


def _one_of_each_cell(across: Array, up: Array, cells: int) -> Array:
    axes = across, up
    size = max(float(np.ptp(axis)) for axis in axes) / cells or 1.0
    columns, rows = (np.minimum((axis - axis.min()) // size, cells - 1) for axis in axes)
    _, first = np.unique(columns * cells + rows, return_index=True)
    ends = [end for axis in axes for end in (axis.argmin(), axis.argmax())]
    found = np.unique([*first, *ends])
    return np.stack((across[found], up[found]), axis=1)


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
