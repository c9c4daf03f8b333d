"""Maps of what a chain reaches, from many postures within its limits (mm and rad)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import itemgetter

from kinematics.chains.chain import Chain
from kinematics.chains.generated import generated
from kinematics.chains.links import JointKind
from kinematics.errors import KinematicsError
from kinematics.frames.transforms import position_of
from kinematics.limits import Span, spread_over

Place = tuple[float, float]


def reach_maps(
    chain: Chain, planes: Sequence[tuple[int, int]], count: int, cells: int
) -> list[list[Place]]:
    """Return places that the tool was brought to, for each plane one of each of its cells.

    The postures are those of `spread_over` for the joint limits. A plane is two of x, y and z by
    their numbers, 0, 1 and 2; the larger side of the reach in it is cut into `cells`. The places
    furthest along each axis are among them. Raises as `spread_over` and `spans_of` do.
    """
    fk = generated(chain).fk
    tips = [position_of(fk(values)) for values in spread_over(spans_of(chain), count)]
    return [_one_of_each_cell([itemgetter(*plane)(tip) for tip in tips], cells) for plane in planes]


def _one_of_each_cell(places: Sequence[Place], cells: int) -> list[Place]:
    ends = [pick(places, key=itemgetter(axis)) for axis in (0, 1) for pick in (min, max)]
    (left, _), (right, _), (_, low), (_, high) = ends
    size = max(right - left, high - low) / cells or 1.0
    shown: dict[tuple[int, int], Place] = {}
    for x, y in places:
        shown.setdefault((int((x - left) / size), int((y - low) / size)), (x, y))
    return list(dict.fromkeys((*shown.values(), *ends)))


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
