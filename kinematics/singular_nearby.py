"""The nearest singular posture of a chain: which joints must move how far to get there.

Distances are in rad, and in lengths of the arm for slides, as singular values are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from kinematics.chains import Chain
from kinematics.generated import Generated, generated
from kinematics.linear import singular
from kinematics.links import JointKind
from kinematics.singularities import (
    SINGULAR,
    Condition,
    condition,
    default_rows,
    length_of,
    scaled_rows,
)

_STEP = 1e-6
_ROUNDS = 40
_FLAT = 1e-18
"""Squared slope below which a singular value goes nowhere."""


@dataclass(frozen=True, slots=True)
class NearestSingularity:
    """A singular posture near a given one, found by descent: none nearer was met, one may exist.

    `distance` is the root of the sum of the squared joint moves, in rad (slides in lengths of
    the arm); `condition` is that of the singular posture.
    """

    values: tuple[float, ...]
    distance: float
    condition: Condition


def nearest_singularity(
    chain: Chain, values: Sequence[float], rows: Sequence[int] | None = None
) -> NearestSingularity | None:
    """Return the nearest singular posture that descent finds; None where it finds none.

    Each of the smallest three singular values is followed to zero, by the shortest joint move
    (Newton's method on the value, its gradient being left . dJ . right); joint limits are not
    looked at. What is found is an upper bound of the distance.
    """
    chosen = default_rows(chain) if rows is None else tuple(rows)
    start = chain.checked(values)
    found = [
        end
        for which in range(1, min(3, len(chosen), len(chain)) + 1)
        if (end := _descend(chain, start, chosen, which)) is not None
    ]
    if not found:
        return None
    units = _units(chain)
    best = min(found, key=lambda end: _move(start, end, units))
    return NearestSingularity(best, _move(start, best, units), condition(chain, best, chosen))


def _units(chain: Chain) -> tuple[float, ...]:
    """Return what one dimensionless unit of each joint is, in rad or mm."""
    length = length_of(chain)
    return tuple(length if kind is JointKind.PRISMATIC else 1.0 for kind in chain.kinds)


def _move(start: Sequence[float], end: Sequence[float], units: Sequence[float]) -> float:
    return math.hypot(*((b - a) / u for a, b, u in zip(start, end, units, strict=True)))


def _descend(
    chain: Chain, start: Sequence[float], rows: Sequence[int], which: int
) -> tuple[float, ...] | None:
    """Follow one singular value, counted from the smallest, to zero by the shortest move."""
    made, units = generated(chain), _units(chain)
    values = tuple(start)
    for _ in range(_ROUNDS):
        jacobian = scaled_rows(chain, made, values, rows)
        parts = singular(jacobian)
        index = -which if parts.values[-1] >= SINGULAR else -1
        size = parts.values[index]
        if size < SINGULAR:
            return values
        gradient = _gradient(chain, made, values, rows, parts.left[index], parts.right[index])
        steep = sum(slope * slope for slope in gradient)
        if steep < _FLAT:
            return None
        back = [(a - b) / u for a, b, u in zip(start, values, units, strict=True)]
        shift = size + sum(slope * way for slope, way in zip(gradient, back, strict=True))
        target = [
            a - slope * shift / steep * u
            for a, slope, u in zip(start, gradient, units, strict=True)
        ]
        values = _limited(values, target, units)
    return None


def _gradient(
    chain: Chain,
    made: Generated,
    values: Sequence[float],
    rows: Sequence[int],
    left: Sequence[float],
    right: Sequence[float],
) -> list[float]:
    """Return how a singular value changes with each joint, by central differences of J alone."""
    slopes = []
    for joint, unit in enumerate(_units(chain)):
        ends = []
        for sign in (1.0, -1.0):
            moved = list(values)
            moved[joint] += sign * _STEP * unit
            jacobian = scaled_rows(chain, made, moved, rows)
            ends.append(
                sum(
                    a * sum(entry * b for entry, b in zip(row, right, strict=True))
                    for a, row in zip(left, jacobian, strict=True)
                )
            )
        slopes.append((ends[0] - ends[1]) / (2.0 * _STEP))
    return slopes


def _limited(
    values: Sequence[float], target: Sequence[float], units: Sequence[float]
) -> tuple[float, ...]:
    """Return the target, or a point half a unit on the way there if it is further."""
    far = _move(values, target, units)
    share = min(1.0, 0.5 / far) if far > 0.0 else 1.0
    return tuple(a + share * (b - a) for a, b in zip(values, target, strict=True))
