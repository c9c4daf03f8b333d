"""An increment of a jog: legs as far as the bounds allow, and what bounds it.

Joints turn in proportion. The tip keeps to its line: a long increment is cut into pieces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.frames import BASE, axes_of
from armdrive.intents import GRIPPER_AXIS, Jog, Space
from armdrive.jog_bounds import Bounds, Ended, at_limits, furthest
from armdrive.jog_scale import Scale, axis_names
from armdrive.jog_ways import JointWay, TipWay, Way, in_base, on_limits, spans_of
from armdrive.legs import Leg
from armdrive.whereabouts import Coordinates

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from armdrive.legs import Speeds

PIECE_MM = 10.0
PIECE_RAD = math.radians(5.0)
"""How long the pieces of a line are at most: the tip leaves it by some tenths of a mm at most."""


@dataclass(frozen=True, slots=True)
class Stride:
    """Legs end to end, and why they lead less far than asked, where they do."""

    legs: tuple[Leg, ...]
    ended: Ended


def stride(
    config: ArmConfig, speeds: Speeds, jog: Jog, speed: float, start: Coordinates, *, known: bool
) -> Stride:
    """Return how an increment is driven; without bounds where the position is not known.

    Raises `BadRequest` for a frame that nobody knows.
    """
    way, pieces = _way(config, jog, start, known=known)
    bounds = Bounds(config) if known else None
    ended = Ended(at_limits(_clipped(config, jog, start)) if known else "")
    whole_s = _least_s(config, speeds, jog) / speed
    here, legs = start, []
    for piece in range(pieces):
        low = piece / pieces
        last, beyond = _free(bounds, way, here, low, (piece + 1) / pieces)
        there = way.at(last)
        if there is not None and there != here:
            lasts_s = max(speeds.duration_s(here, there, speed), (last - low) * whole_s)
            legs.append(Leg(here, there, lasts_s))
        if bounds is not None and math.isfinite(beyond):
            ended = bounds.ended(way, here.joints, beyond)
            break
        here = there or here
    return Stride(tuple(legs), ended)


def _least_s(config: ArmConfig, speeds: Speeds, jog: Jog) -> float:
    """Return how long an increment of the tip takes at least: no less than if it were held."""
    if jog.space is Space.JOINT:
        return 0.0
    full = Scale(config, speeds).full(jog.space)
    *tip, _ = zip(_amounts(config, jog), full, strict=True)
    return max(abs(amount) / most for amount, most in tip)


def _way(config: ArmConfig, jog: Jog, start: Coordinates, *, known: bool) -> tuple[Way, int]:
    """Return the way of an increment, which lasts a second, and into how many pieces it is cut."""
    amounts = _amounts(config, jog)
    if jog.space is Space.JOINT:
        return JointWay(start, amounts, spans_of(config, start) if known else None), 1
    if jog.frame != BASE:
        amounts = in_base(axes_of(config, start.joints, jog.frame), amounts)
    *turns, _ = amounts[3:]
    pieces = max(math.hypot(*amounts[:3]) / PIECE_MM, *(abs(turn) / PIECE_RAD for turn in turns))
    way = TipWay(config, on_limits(config, start), amounts, spans_of(config, start)[-1])
    return way, max(math.ceil(pieces), 1)


def _amounts(config: ArmConfig, jog: Jog) -> tuple[float, ...]:
    """Return an increment in mm and rad; people give degrees."""
    lengths = ("x", "y", "z", GRIPPER_AXIS)
    return tuple(
        amount if name in lengths else math.radians(amount)
        for name, amount in ((name, jog.amount(name)) for name in axis_names(config, jog.space))
    )


def _free(
    bounds: Bounds | None, way: Way, here: Coordinates, low: float, high: float
) -> tuple[float, float]:
    """Return how far a piece of a way may be gone, and something beyond that is not free."""
    if bounds is None:
        return high, math.inf

    def good(share: float) -> bool:
        there = way.at(low + share)
        return there is not None and bounds.holds(here.joints, there.joints)

    free, beyond = furthest(good, high - low)
    return low + free, low + beyond


def _clipped(config: ArmConfig, jog: Jog, start: Coordinates) -> list[str]:
    """Return the axes that end at their limits while the others go on."""
    names = axis_names(config, jog.space)
    spans = spans_of(config, start)
    places = (*start.joints, start.opening_mm)
    amounts = _amounts(config, jog)
    if jog.space is Space.CARTESIAN:
        names, spans, places, amounts = names[-1:], spans[-1:], places[-1:], amounts[-1:]
    return [
        name
        for name, place, amount, (low, high) in zip(names, places, amounts, spans, strict=True)
        if not low <= place + amount <= high
    ]
